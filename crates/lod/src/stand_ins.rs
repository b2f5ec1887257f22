//! Coarse stand-ins for the particles of a chunk in the thickness: spheres that hold the volume, the centre of mass and the
//! second moments of what they stand for, so that column integrals are conserved (`algorithms.md` 2.3).

use std::ops::Range;

use glam::{DVec3, Vec3};
use half::f16;
use meniscus_gpu::role::StandIn;

/// How coarse the stand-ins of a chunk are: one per cell of 2.5 spacings, one per block of 2 x 2 x 2 cells, one for all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Coarseness {
    /// One per cell, for some sixteen particles.
    Cells,
    /// One per block of eight cells, for some 125 particles.
    Blocks,
    /// One for all.
    Whole,
}

impl Coarseness {
    /// All, the finest first.
    pub const ALL: [Self; 3] = [Self::Cells, Self::Blocks, Self::Whole];

    /// Edge of what one stand-in replaces, in spacings; of a whole part about.
    pub fn edge_spacings(self) -> f32 {
        match self {
            Self::Cells => 2.5,
            Self::Blocks => 5.0,
            Self::Whole => 8.0,
        }
    }
}

/// Stand-ins of a part of a chunk, in the list of its page.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StandIns {
    /// Index of the first.
    pub first: u32,
    /// How many; 0 where there are none that would do.
    pub count: u32,
}

/// Radius of a sphere, over that with the second moments of what it stands for. A row of spheres with 0.715 of their
/// distance as radius has no ripple at that distance: the spectrum of the chord, (sin q - q cos q) / q^3 with q = 2 pi R / e,
/// is zero there. A full cell has moments for 0.645.
const WIDENED: f64 = 0.715 / 0.645;

/// What particles reach about their own centre: a sphere of 0.625 spacings, the radius that is drawn by default.
const OWN_RADIUS_SPACINGS: f64 = 0.625;

/// Stand-ins wider than this many of their edges stand for particles that are not together, and are not used.
const WIDEST: f64 = 1.5;

/// Sums over particles, their positions counted from one of them.
#[derive(Clone, Copy, Default)]
pub(crate) struct Moments {
    count: usize,
    /// In those of a particle of the set's own size, which all that follow are weighted by.
    volume: f64,
    sum: DVec3,
    squares: f64,
    /// Squares of relative sizes.
    own: f64,
}

/// Volumes and radii that half precision holds to all its digits.
fn is_normal(value: f64) -> bool {
    (f16::MIN_POSITIVE.to_f64()..=f16::MAX.to_f64()).contains(&value)
}

impl Moments {
    /// Adds a particle of relative `size` at `offset` (world units, from whatever all are counted from).
    pub(crate) fn add(&mut self, offset: Vec3, size: f32) {
        let (offset, size) = (offset.as_dvec3(), f64::from(size));
        let volume = size * size * size;
        self.count += 1;
        self.volume += volume;
        self.sum += volume * offset;
        self.squares += volume * offset.length_squared();
        self.own += volume * size * size;
    }

    pub(crate) fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.volume += other.volume;
        self.sum += other.sum;
        self.squares += other.squares;
        self.own += other.own;
    }

    /// The sphere for all particles added, `None` for none, or where it would be too wide to stand for a compact group.
    fn stand_in(&self, origin: Vec3, spacing_world: f64, edge_spacings: f32) -> Option<StandIn> {
        let mean = self.sum / self.volume;
        let variance_per_axis = (self.squares / self.volume - mean.length_squared()).max(0.0) / 3.0;
        let own = OWN_RADIUS_SPACINGS * spacing_world;
        // A sphere has a fifth of its squared radius as second moment along each axis; of particles of several sizes the mean,
        // weighted by volume, counts.
        let radius = (5.0 * variance_per_axis + own * own * (self.own / self.volume)).sqrt() * WIDENED;
        let relative = radius / spacing_world;
        let is_compact = relative <= WIDEST * f64::from(edge_spacings);
        (is_compact && is_normal(relative) && is_normal(self.volume)).then(|| StandIn {
            center_world: (origin.as_dvec3() + mean).as_vec3().to_array(),
            packed: u32::from(f16::from_f64(relative).to_bits()) << 16
                | u32::from(f16::from_f64(self.volume).to_bits()),
        })
    }
}

/// Gathers the stand-ins of one part of a chunk while its cells come along the curve.
#[derive(Default)]
pub(crate) struct Gathering {
    /// Of the block that is under way.
    block: Moments,
    block_code: u64,
    whole: Moments,
    found: [Vec<StandIn>; 3],
    /// Whether stand-ins of a coarseness cannot be used.
    is_spoilt: [bool; 3],
}

impl Gathering {
    /// Adds the moments of the cell at `code` of the curve, counted from `origin`.
    pub(crate) fn add_cell(&mut self, code: u64, cell: &Moments, origin: Vec3, spacing_world: f64) {
        if cell.count == 0 {
            return;
        }
        if code >> 3 != self.block_code {
            self.end_block(origin, spacing_world);
            self.block_code = code >> 3;
        }
        self.push(Coarseness::Cells, *cell, origin, spacing_world);
        self.block.merge(cell);
        self.whole.merge(cell);
    }

    fn end_block(&mut self, origin: Vec3, spacing_world: f64) {
        let block = std::mem::take(&mut self.block);
        if block.count > 0 {
            self.push(Coarseness::Blocks, block, origin, spacing_world);
        }
    }

    fn push(&mut self, coarseness: Coarseness, moments: Moments, origin: Vec3, spacing_world: f64) {
        let level = coarseness as usize;
        match moments.stand_in(origin, spacing_world, coarseness.edge_spacings()) {
            Some(stand_in) => self.found[level].push(stand_in),
            None => self.is_spoilt[level] = true,
        }
    }

    /// Appends what was gathered to `list`; empties this.
    pub(crate) fn end(&mut self, origin: Vec3, spacing_world: f64, list: &mut Vec<StandIn>) -> [StandIns; 3] {
        self.end_block(origin, spacing_world);
        let whole = std::mem::take(&mut self.whole);
        if whole.count > 0 {
            self.push(Coarseness::Whole, whole, origin, spacing_world);
        }
        Coarseness::ALL.map(|coarseness| {
            let level = coarseness as usize;
            let found = std::mem::take(&mut self.found[level]);
            // Those that replace few particles gain nothing, and all lists together must not outgrow the particles.
            let is_of_use = found.len() * 4 <= whole.count;
            if std::mem::take(&mut self.is_spoilt[level]) || !is_of_use {
                return StandIns::default();
            }
            let first = list.len() as u32;
            list.extend(&found);
            StandIns { first, count: found.len() as u32 }
        })
    }
}

/// The indices of stand-ins in their page's list.
impl From<StandIns> for Range<usize> {
    fn from(stand_ins: StandIns) -> Self {
        stand_ins.first as usize..(stand_ins.first + stand_ins.count) as usize
    }
}
