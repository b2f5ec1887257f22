//! Which particles of a set a picture needs.

use meniscus_core::Camera;
use meniscus_gpu::role::{KeptRange, PackedParticle};
use rayon::prelude::*;

use crate::view::View;
use crate::weight::MAX_GROWTH;
use crate::{Chunk, ChunkedSet, LodError, LodParams, Policy};

/// Most particles of a kept range. One workgroup draws one range: 512 are two to eight rounds of a workgroup of 64 to 256
/// lanes, enough to pay for its start, and a full set of 18 M still is 35,000 evenly sized pieces of work in 0.6 MB.
pub const RANGE_PARTICLES: u32 = 512;

/// Smallest keep probability other than none, in 1/65536: below it, the sixteen bits of the hash would bias the fade's
/// mean weight by more than 0.3 % (see the bound in the tests of [`crate::weight`]).
pub const MIN_KEEP: u32 = 16;

/// Particle numbers of one set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ParticleCounts {
    /// In the set.
    pub input: u64,
    /// Left after culling and thinning.
    pub kept: u64,
    /// Chunks looked at.
    pub chunks: u64,
    /// Chunks outside the view.
    pub chunks_culled: u64,
}

/// What is drawn.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// Kept ranges of each page of the set, near chunks first; each at most [`RANGE_PARTICLES`] long.
    pub ranges: Vec<Vec<KeptRange>>,
    /// Particles and chunks in and kept.
    pub counts: ParticleCounts,
    /// Particles of the chunks that are in view: what `counts.kept` is a fraction of.
    pub visible: u64,
}

/// A chunk in view.
struct Candidate<'a> {
    chunk: &'a Chunk,
    /// View distance of its nearest point, world units.
    nearest: f32,
    importance: f64,
    /// Keep probability below which its isolated particles must not fall.
    spared: f64,
}

/// Chooses the particles of `set` for a picture of `size_px` = `[width, height]` pixels. `radius_world` is the largest
/// radius, in world units, at which any pass draws a particle of the set's own size. Deterministic for any number of threads.
///
/// Chunks outside the frustum or before the near plane are left out. Under [`Policy::Default`] a chunk in view is kept
/// with probability `p = min(1, s w)`: the importance `w` is the source's peripheral fall-off times the projected diameter
/// of a particle, and the scale `s` is found by bisection so that the kept fraction of the particles of all chunks in view
/// is the threshold (within the spread of their hashes). Isolated particles are spared while larger than a pixel, half a
/// pixel being none; they are paid for out of the same budget, of which they cannot take more than half from the others.
///
/// # Errors
/// [`LodError`] where an argument is out of range.
pub fn select(
    set: &ChunkedSet,
    camera: &Camera,
    size_px: [u32; 2],
    radius_world: f32,
    params: &LodParams,
) -> Result<Selection, LodError> {
    validate(camera, size_px, radius_world, params)?;
    let view = View::new(camera, size_px);
    let mut candidates: Vec<Candidate> = set
        .chunks
        .par_iter()
        // Under every threshold as if grown in full, so that the chunks in view do not depend on the threshold.
        .filter(|chunk| view.sees(&chunk.bounds, radius_world * MAX_GROWTH))
        .map(|chunk| Candidate::new(chunk, &view, radius_world, params.policy))
        .collect();
    let cut = Cut::solve(&candidates, params);
    // Stable: equal distances stay in the order of the chunks.
    candidates.par_sort_by(|a, b| a.nearest.total_cmp(&b.nearest));
    let prefixes: Vec<[Prefix; 2]> =
        candidates.par_iter().map(|candidate| prefixes(set, candidate, &cut)).collect();

    let mut selection = Selection {
        ranges: vec![Vec::new(); set.pages().len()],
        counts: ParticleCounts {
            input: set.particles.len() as u64,
            kept: prefixes.iter().flatten().map(|prefix| u64::from(prefix.count)).sum(),
            chunks: set.chunks.len() as u64,
            chunks_culled: (set.chunks.len() - candidates.len()) as u64,
        },
        visible: candidates.iter().map(|candidate| u64::from(candidate.chunk.count)).sum(),
    };
    for (candidate, prefixes) in candidates.iter().zip(prefixes) {
        let ranges = &mut selection.ranges[candidate.chunk.page as usize];
        prefixes.into_iter().for_each(|prefix| prefix.split_into(ranges));
    }
    Ok(selection)
}

fn validate(
    camera: &Camera,
    size_px: [u32; 2],
    radius_world: f32,
    params: &LodParams,
) -> Result<(), LodError> {
    params.validate()?;
    camera.validate()?;
    if size_px.contains(&0) {
        return Err(LodError::EmptyPicture(size_px));
    }
    if !(radius_world > 0.0 && radius_world.is_finite()) {
        return Err(LodError::Radius(radius_world));
    }
    Ok(())
}

impl<'a> Candidate<'a> {
    fn new(chunk: &'a Chunk, view: &View, radius_world: f32, policy: Policy) -> Self {
        let center = chunk.bounds.center();
        let nearest = view.nearest(&chunk.bounds);
        let size = match policy {
            Policy::Default => view.diameter_px(radius_world, view.distance(center)),
            Policy::Thesis => 1000.0 / view.distance(center),
        };
        let spared = match policy {
            Policy::Default => (2.0 * view.diameter_px(radius_world, nearest) - 1.0).clamp(0.0, 1.0),
            Policy::Thesis => 0.0,
        };
        // Positive and finite, so that the bisection has a bracket whatever the scene's unit.
        let importance = f64::from(view.fall_off(center) * size).clamp(1e-30, 1e30);
        Self { chunk, nearest, importance, spared: f64::from(spared) }
    }
}

/// How importance becomes a keep probability; rises with the threshold for every importance.
enum Cut {
    /// Threshold 1, to the last particle.
    All,
    /// Threshold 0.
    None,
    /// `min(1, scale * importance)`.
    Scale(f64),
    /// `1 - cut / importance`, where positive.
    Level(f64),
}

impl Cut {
    fn solve(candidates: &[Candidate], params: &LodParams) -> Self {
        let threshold = f64::from(params.threshold);
        match params.policy {
            _ if params.threshold >= 1.0 => Self::All,
            _ if params.threshold <= 0.0 || candidates.is_empty() => Self::None,
            Policy::Default => Self::Scale(solve_scale(candidates, threshold)),
            Policy::Thesis => {
                let (sum, count) = candidates.iter().fold((0.0, 0.0), |(sum, count), c| {
                    let n = f64::from(c.chunk.count);
                    (sum + n * c.importance, count + n)
                });
                // l / (1 + l) >= 1 - t with l = r w / CLOD, solved for the random number r.
                Self::Level(sum / count * (1.0 - threshold) / threshold)
            }
        }
    }

    fn probability(&self, importance: f64) -> f64 {
        match self {
            Self::All => 1.0,
            Self::None => 0.0,
            Self::Scale(scale) => (scale * importance).min(1.0),
            Self::Level(cut) => (1.0 - cut / importance).max(0.0),
        }
    }

    /// The keep probability in 1/65536; 0 keeps none.
    fn keep(&self, importance: f64, at_least: f64) -> u32 {
        let p = self.probability(importance).max(at_least);
        if p == 0.0 { 0 } else { ((p * 65536.0).round() as u32).clamp(MIN_KEEP, KeptRange::KEEP_ALL) }
    }
}

/// The scale at which the expected number of kept particles is `threshold` times all, isolated ones counted with what is
/// spared of them, but the others still are kept for half the threshold.
fn solve_scale(candidates: &[Candidate], threshold: f64) -> f64 {
    let total: f64 = candidates.iter().map(|c| f64::from(c.chunk.count)).sum();
    let kept = |scale: f64| {
        let (kept, unspared) = candidates.iter().fold((0.0, 0.0), |(kept, unspared), c| {
            let p = (scale * c.importance).min(1.0);
            let (all, isolated) = (f64::from(c.chunk.count), f64::from(c.chunk.isolated));
            (kept + all * p + isolated * (c.spared - p).max(0.0), unspared + all * p)
        });
        f64::min(kept, 2.0 * unspared)
    };
    let (least, most) = candidates
        .iter()
        .fold((f64::INFINITY, 0.0f64), |(least, most), c| (least.min(c.importance), most.max(c.importance)));
    // At the low end no p is above half the threshold, at the high end every p is 1. Sixty halvings of the logarithm of
    // their ratio leave less than the distance of two neighbouring f32 thresholds, so that higher ones keep more.
    let (mut low, mut high) = (0.5 * threshold / most, 1.0 / least);
    for _ in 0..60 {
        let middle = (low * high).sqrt();
        if kept(middle) < threshold * total { low = middle } else { high = middle }
    }
    high
}

/// The first particles of a chunk or of its rest, kept with one probability.
struct Prefix {
    first: u32,
    count: u32,
    keep: u32,
}

/// What is kept of a chunk's isolated particles and of the others; all of them in one where all are.
fn prefixes(set: &ChunkedSet, candidate: &Candidate, cut: &Cut) -> [Prefix; 2] {
    let chunk = candidate.chunk;
    let keep = cut.keep(candidate.importance, 0.0);
    let spared = if keep == KeptRange::KEEP_ALL { 0 } else { chunk.isolated };
    let (isolated, others) = set.particles_of(chunk).split_at(spared as usize);
    let prefix = |first, particles, keep| Prefix { first, count: kept_prefix(particles, keep), keep };
    [
        prefix(chunk.first, isolated, cut.keep(candidate.importance, candidate.spared)),
        prefix(chunk.first + spared, others, keep),
    ]
}

/// How many particles, sorted by hash, have a hash below `keep`.
fn kept_prefix(particles: &[PackedParticle], keep: u32) -> u32 {
    if keep >= KeptRange::KEEP_ALL {
        return particles.len() as u32;
    }
    particles.partition_point(|particle| u32::from(particle.hash()) < keep) as u32
}

impl Prefix {
    /// Appends the prefix in as few pieces as allowed, their lengths at most one apart.
    fn split_into(self, ranges: &mut Vec<KeptRange>) {
        let pieces = self.count.div_ceil(RANGE_PARTICLES);
        let border = |piece: u32| (u64::from(self.count) * u64::from(piece) / u64::from(pieces)) as u32;
        ranges.extend((0..pieces).map(|piece| KeptRange {
            first: self.first + border(piece),
            count: border(piece + 1) - border(piece),
            keep: self.keep,
            flags: 0,
        }));
    }
}
