//! Which particles of a set a picture needs.

use meniscus_core::Camera;
use meniscus_gpu::role::{KeptRange, Occludee, PackedParticle};
use rayon::prelude::*;

use crate::cut::{BURIED, Cut};
use crate::detail::stand_ins_for;
use crate::stand_ins::{Coarseness, StandIns};
use crate::view::View;
use crate::weight::{MAX_GROWTH, growth};
use crate::{Chunk, ChunkedSet, LodError, LodParams, Mode, Policy};

/// Most particles of a kept range. One workgroup draws one range: 512 are two to eight rounds of a workgroup of 64 to 256
/// lanes, enough to pay for its start, and a full set of 18 M still is 35,000 evenly sized pieces of work in 0.6 MB.
pub const RANGE_PARTICLES: u32 = 512;

/// What a selection is made for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    /// The camera.
    pub camera: Camera,
    /// `[width, height]` of the picture in pixels.
    pub size_px: [u32; 2],
    /// The largest radius at which any pass draws a particle of the set's own size, world units.
    pub radius_world: f32,
    /// How far what is drawn for a particle of the shell reaches from its centre, in radii of its sphere; 1 for the sphere itself.
    pub shell_reach: f32,
    /// Distance of neighbouring particles of the set's own size, world units.
    pub spacing_world: f32,
    /// Pixels per side of a sample of the thickness, > 0: the coarser, the sooner stand-ins cost less than particles.
    pub sample_px: u32,
}

impl Viewpoint {
    /// How far what is drawn of `chunk` may reach from the centres of its particles, world units.
    fn reach_world(&self, chunk: &Chunk) -> f32 {
        self.radius_world * chunk.largest * MAX_GROWTH * self.shell_reach
    }
}

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
    /// Of the kept, those that are only drawn where nothing hides them.
    pub tested: u64,
    /// Stand-ins in the thickness.
    pub stand_ins: u64,
}

impl std::ops::AddAssign for ParticleCounts {
    fn add_assign(&mut self, other: Self) {
        self.input += other.input;
        self.kept += other.kept;
        self.chunks += other.chunks;
        self.chunks_culled += other.chunks_culled;
        self.tested += other.tested;
        self.stand_ins += other.stand_ins;
    }
}

/// What is drawn of one page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PageSelection {
    /// What the surface is drawn from first, near chunks first; each at most [`RANGE_PARTICLES`] long, as all that follow.
    pub front: Vec<KeptRange>,
    /// What is drawn after that, where `front` does not hide it.
    pub occludees: Vec<Occludee>,
    /// Particles that count in the thickness.
    pub mass: Vec<KeptRange>,
    /// Stand-ins that count in the thickness for the others.
    pub stand_ins: Vec<KeptRange>,
}

impl PageSelection {
    /// All ranges that the surface is drawn from.
    pub fn surface(&self) -> impl Iterator<Item = &KeptRange> {
        self.front.iter().chain(self.occludees.iter().map(|occludee| &occludee.range))
    }
}

/// What is drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    /// Of each page of the set.
    pub pages: Vec<PageSelection>,
    /// Particles and chunks in and kept.
    pub counts: ParticleCounts,
    /// Particles of the chunks that are in view: what `counts.kept` is a fraction of.
    pub visible: u64,
    /// Smallest keep probability, in 1/65536, of what is drawn first and larger than a pixel.
    pub least_keep: u32,
    /// Whether that is all and of one size, also of shells that face away. Buried particles, which only show through cracks, do not count.
    pub is_uniform_surface: bool,
    /// Whether all particles that count in the thickness count as themselves and have the set's own size.
    pub is_uniform_mass: bool,
    /// Half size in pixels that no particle exceeds that counts in the thickness as itself.
    pub most_half_px: f32,
    /// Radius in pixels that no sphere exceeds that is drawn, at its point nearest to the eye.
    pub most_radius_px: f32,
    /// Sum over what is drawn first of the squared radii in pixels.
    pub front_square_px: f64,
    /// Thickness that a pixel does not exceed even if all that counts in the thickness is piled up in it, spacings; infinite where
    /// that is not known.
    pub most_thickness: f64,
    /// Whether particles have sizes of their own.
    pub has_sizes: bool,
}

impl Selection {
    /// Radius in pixels of what is drawn first, root of the mean square; 0 where that is nothing.
    pub fn front_half_px(&self) -> f32 {
        let count = self.counts.kept - self.counts.tested;
        (self.front_square_px / count.max(1) as f64).sqrt() as f32
    }

    /// Nothing of `set`.
    fn empty(set: &ChunkedSet) -> Self {
        Self {
            pages: vec![PageSelection::default(); set.pages().len()],
            counts: ParticleCounts {
                input: set.particles.len() as u64,
                chunks: set.chunks.len() as u64,
                ..Default::default()
            },
            visible: 0,
            least_keep: KeptRange::KEEP_ALL,
            is_uniform_surface: !set.has_sizes,
            is_uniform_mass: !set.has_sizes,
            most_half_px: 0.0,
            most_radius_px: 0.0,
            front_square_px: 0.0,
            most_thickness: 0.0,
            has_sizes: set.has_sizes,
        }
    }

    fn add(&mut self, chunk: &Chunk, choice: &Choice) {
        self.visible += u64::from(chunk.count);
        self.least_keep = self.least_keep.min(choice.least_keep);
        self.is_uniform_surface &= choice.is_uniform_surface;
        self.is_uniform_mass &= choice.is_uniform_mass;
        self.most_half_px = self.most_half_px.max(choice.most_half_px);
        self.most_radius_px = self.most_radius_px.max(choice.most_radius_px);
        self.front_square_px += choice.front_square_px;
        self.most_thickness += choice.most_thickness;
        for part in &choice.parts {
            let kept = u64::from(part.surface.count);
            self.counts.kept += kept;
            self.counts.tested += if part.tested.is_some() { kept } else { 0 };
            self.counts.stand_ins += u64::from(part.stand_ins.count);
        }
        choice.append_to(&mut self.pages[chunk.page as usize]);
    }

    /// All of `parts`, one after the other.
    fn joined(set: &ChunkedSet, parts: Vec<Self>) -> Self {
        let mut all = Self::empty(set);
        for part in &parts {
            all.visible += part.visible;
            all.least_keep = all.least_keep.min(part.least_keep);
            all.is_uniform_surface &= part.is_uniform_surface;
            all.is_uniform_mass &= part.is_uniform_mass;
            all.most_half_px = all.most_half_px.max(part.most_half_px);
            all.most_radius_px = all.most_radius_px.max(part.most_radius_px);
            all.front_square_px += part.front_square_px;
            all.most_thickness += part.most_thickness;
            all.counts.kept += part.counts.kept;
            all.counts.tested += part.counts.tested;
            all.counts.stand_ins += part.counts.stand_ins;
        }
        all.pages.par_iter_mut().enumerate().for_each(|(index, page)| {
            let of_page = || parts.iter().map(|part| &part.pages[index]);
            page.front = concat(of_page().map(|part| &part.front));
            page.occludees = concat(of_page().map(|part| &part.occludees));
            page.mass = concat(of_page().map(|part| &part.mass));
            page.stand_ins = joined(concat(of_page().map(|part| &part.stand_ins)));
        });
        all
    }
}

fn concat<'a, T: Copy + 'a>(lists: impl Iterator<Item = &'a Vec<T>> + Clone) -> Vec<T> {
    let mut all = Vec::with_capacity(lists.clone().map(Vec::len).sum());
    lists.for_each(|list| all.extend_from_slice(list));
    all
}

/// A chunk in view.
pub(crate) struct Candidate<'a> {
    pub(crate) chunk: &'a Chunk,
    /// View distance of its nearest point, world units.
    nearest: f32,
    pub(crate) importance: f64,
    /// Importance of its shell in that: 1 where it may face the eye, that of buried particles where it faces away.
    pub(crate) shell: f64,
    /// Keep probability below which its isolated particles must not fall.
    pub(crate) spared: f64,
}

/// Chooses the particles of `set` for a picture. Deterministic for any number of threads.
///
/// Chunks outside the frustum, before the near plane or beyond the far distance are left out. Under [`Policy::Default`] a chunk in view is kept
/// with probability `p = min(1, s w)`: the importance `w` is the source's peripheral fall-off times the projected diameter
/// of a particle, down to a tenth of that for what is buried or faces away, and the scale `s` is found by bisection so that the kept fraction of the
/// particles of all chunks in view is the threshold (within the spread of their hashes). Isolated particles are spared while
/// larger than a pixel, half a pixel being none; they are paid for out of the same budget, of which they cannot take more
/// than half from the others. Under [`Mode::ErrorBound`] only particles closer together than the tolerated error are thinned.
///
/// The surface is drawn from the shells that face the eye first. What faces away or is buried is drawn where those do not
/// hide it, so that the picture is the same with far less work. In the thickness, stand-ins take the place of particles where
/// the tolerated errors allow, but not at full detail. Isolated particles of a set with foam are no part of either.
///
/// # Errors
/// [`LodError`] where an argument is out of range.
pub fn select(set: &ChunkedSet, viewpoint: &Viewpoint, params: &LodParams) -> Result<Selection, LodError> {
    validate(viewpoint, params)?;
    let view = View::new(&viewpoint.camera, viewpoint.size_px);
    let candidates = candidates(set, &view, viewpoint, params);
    let cut = Cut::solve(&candidates, params);
    let chooser = Chooser { set, view, viewpoint, params, cut };
    let in_order = near_first(&candidates);
    // Ordered, whatever thread is done first.
    let parts: Vec<Selection> = in_order
        .par_chunks(CHUNKS_AT_ONCE)
        .map(|some| {
            let mut part = Selection::empty(set);
            for &index in some {
                part.add(candidates[index as usize].chunk, &chooser.choose(&candidates[index as usize]));
            }
            part
        })
        .collect();
    let mut selection = Selection::joined(set, parts);
    selection.counts.chunks_culled = (set.chunks.len() - candidates.len()) as u64;
    Ok(selection)
}

/// Chunks that a thread chooses from at a time: more than pay for lists of their own, few enough to keep many cores busy.
const CHUNKS_AT_ONCE: usize = 512;

/// The candidates' indices, those with the nearest points first and equal distances in the order of the chunks.
fn near_first(candidates: &[Candidate]) -> Vec<u32> {
    let mut order: Vec<(f32, u32)> =
        candidates.iter().enumerate().map(|(i, candidate)| (candidate.nearest, i as u32)).collect();
    order.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    order.into_iter().map(|(_, index)| index).collect()
}

/// What became of a chunk, for debug views.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fate {
    /// Outside of the picture's sides.
    Outside,
    /// Before the near plane.
    TooNear,
    /// Beyond the far distance.
    TooFar,
    /// In view.
    Selected {
        /// Particles that the surface may be drawn from.
        kept: u32,
        /// Whether all of them are drawn only where nothing hides them.
        tested: bool,
        /// What stands for shell and buried particles in the thickness; `None`: themselves.
        stand_ins: [Option<Coarseness>; 2],
    },
}

/// What becomes of every chunk of `set` in [`select`], in their order.
///
/// # Errors
/// As [`select`].
pub fn explain(set: &ChunkedSet, viewpoint: &Viewpoint, params: &LodParams) -> Result<Vec<Fate>, LodError> {
    validate(viewpoint, params)?;
    let view = View::new(&viewpoint.camera, viewpoint.size_px);
    let candidates = candidates(set, &view, viewpoint, params);
    let cut = Cut::solve(&candidates, params);
    let chooser = Chooser { set, view, viewpoint, params, cut };
    let mut selected = candidates.iter().peekable();
    let fate = |chunk: &Chunk| match selected.next_if(|candidate| std::ptr::eq(candidate.chunk, chunk)) {
        Some(candidate) => chooser.choose(candidate).fate(chunk),
        None => {
            let nearest = chooser.view.nearest(&chunk.bounds);
            let farthest = nearest + chunk.bounds.extent().dot(chooser.view.forward().abs());
            let reach = viewpoint.reach_world(chunk);
            match params.far {
                Some(far) if nearest > far => Fate::TooFar,
                _ if farthest + reach < viewpoint.camera.near => Fate::TooNear,
                _ => Fate::Outside,
            }
        }
    };
    Ok(set.chunks.iter().map(fate).collect())
}

/// The chunks in view, in their order.
fn candidates<'a>(
    set: &'a ChunkedSet,
    view: &View,
    viewpoint: &Viewpoint,
    params: &LodParams,
) -> Vec<Candidate<'a>> {
    set.chunks
        .par_iter()
        // Under every threshold as if grown in full, so that the chunks in view do not depend on the threshold.
        .filter(|chunk| view.sees(&chunk.bounds, viewpoint.reach_world(chunk)))
        .filter(|chunk| params.far.is_none_or(|far| view.nearest(&chunk.bounds) <= far))
        .map(|chunk| Candidate::new(chunk, view, viewpoint.radius_world * chunk.largest, params.policy))
        .collect()
}

fn validate(viewpoint: &Viewpoint, params: &LodParams) -> Result<(), LodError> {
    params.validate()?;
    viewpoint.camera.validate()?;
    if viewpoint.size_px.contains(&0) {
        return Err(LodError::EmptyPicture(viewpoint.size_px));
    }
    let is_length = |length: f32| length > 0.0 && length.is_finite();
    if !is_length(viewpoint.radius_world) || !is_length(viewpoint.shell_reach) {
        return Err(LodError::Radius(viewpoint.radius_world));
    }
    if !is_length(viewpoint.spacing_world) {
        return Err(LodError::Spacing(viewpoint.spacing_world));
    }
    Ok(())
}

impl<'a> Candidate<'a> {
    /// `radius_world`: of the largest particle.
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
        let away = f64::from(-chunk.outward.dot(view.towards_eye(center)));
        let shell = match policy {
            Policy::Default => (1.0 - 2.0 * away).clamp(BURIED, 1.0),
            Policy::Thesis => 1.0,
        };
        Self { chunk, nearest, importance, shell, spared: f64::from(spared) }
    }
}

/// The first `count` particles of a part of a chunk from `first` on, all with one keep probability.
#[derive(Clone, Copy, Default)]
struct Prefix {
    first: u32,
    count: u32,
    keep: u32,
    /// As of [`KeptRange`].
    shape: u32,
}

impl Prefix {
    /// Calls `take` with the prefix in as few pieces as allowed, their lengths at most one apart.
    fn for_each_piece(self, mut take: impl FnMut(KeptRange)) {
        let Self { first, count, keep, shape } = self;
        if count <= RANGE_PARTICLES {
            // Nearly all.
            if count > 0 {
                take(KeptRange { first, count, keep, shape });
            }
            return;
        }
        let pieces = count.div_ceil(RANGE_PARTICLES);
        let border = |piece: u32| (u64::from(count) * u64::from(piece) / u64::from(pieces)) as u32;
        for piece in 0..pieces {
            take(KeptRange {
                first: first + border(piece),
                count: border(piece + 1) - border(piece),
                keep,
                shape: if shape > 0 { shape + border(piece) } else { 0 },
            });
        }
    }
}

/// Of a part of a chunk: what of it the surface is drawn from, and what stands for it in the thickness.
#[derive(Clone, Copy, Default)]
struct PartChoice {
    surface: Prefix,
    /// Where it shows, if it is to be tested.
    tested: Option<Occludee>,
    mass: Prefix,
    stand_ins: StandIns,
}

/// What is drawn of a chunk: isolated particles, shell, buried ones.
struct Choice {
    parts: [PartChoice; 3],
    least_keep: u32,
    is_uniform_surface: bool,
    is_uniform_mass: bool,
    most_half_px: f32,
    most_radius_px: f32,
    front_square_px: f64,
    most_thickness: f64,
}

impl Choice {
    fn fate(&self, chunk: &Chunk) -> Fate {
        let drawn = || self.parts.iter().filter(|part| part.surface.count > 0);
        let coarseness = |part: usize| {
            let taken = self.parts[part + 1].stand_ins;
            let is_taken = |coarseness: &Coarseness| chunk.stand_ins[part][*coarseness as usize] == taken;
            Coarseness::ALL.into_iter().find(is_taken).filter(|_| taken.count > 0)
        };
        Fate::Selected {
            kept: drawn().map(|part| part.surface.count).sum(),
            tested: drawn().all(|part| part.tested.is_some()),
            stand_ins: [coarseness(0), coarseness(1)],
        }
    }

    fn append_to(&self, page: &mut PageSelection) {
        for part in &self.parts {
            match part.tested {
                None => part.surface.for_each_piece(|range| page.front.push(range)),
                Some(shows) => {
                    part.surface.for_each_piece(|range| page.occludees.push(Occludee { range, ..shows }));
                }
            }
            part.mass.for_each_piece(|range| page.mass.push(range));
            if part.stand_ins.count > 0 {
                let StandIns { first, count } = part.stand_ins;
                page.stand_ins.push(KeptRange { first, count, keep: KeptRange::KEEP_ALL, shape: 0 });
            }
        }
    }
}

/// Runs that touch joined into longer ones: a chunk has a handful of stand-ins, too few for a workgroup.
fn joined(mut ranges: Vec<KeptRange>) -> Vec<KeptRange> {
    ranges.sort_unstable_by_key(|range| range.first);
    let mut joined: Vec<KeptRange> = Vec::new();
    for range in ranges {
        match joined.last_mut() {
            Some(last)
                if last.first + last.count == range.first && last.count + range.count <= RANGE_PARTICLES =>
            {
                last.count += range.count;
            }
            _ => joined.push(range),
        }
    }
    joined
}

/// What decides about the chunks.
struct Chooser<'a> {
    set: &'a ChunkedSet,
    view: View,
    viewpoint: &'a Viewpoint,
    params: &'a LodParams,
    cut: Cut,
}

impl Chooser<'_> {
    fn choose(&self, candidate: &Candidate) -> Choice {
        let chunk = candidate.chunk;
        let particles = self.set.particles_of(chunk);
        let spacing_px = self.viewpoint.spacing_world * self.view.px_per_world(candidate.nearest);
        let sample_px = self.viewpoint.sample_px as f32;
        let ends = [0, chunk.isolated, chunk.isolated + chunk.shell, chunk.count];
        let keeps = self.keeps(candidate, spacing_px * chunk.largest);
        let parts: [PartChoice; 3] = std::array::from_fn(|part| {
            let (first, end) = (ends[part], ends[part + 1]);
            // Spray that is drawn as foam is no sphere besides.
            let is_foam = part == 0 && self.set.foam.is_some();
            if first == end || is_foam {
                return PartChoice::default();
            }
            let of_part = &particles[first as usize..end as usize];
            let keep = keeps[part];
            let shape = if part == 1 { 1 + chunk.first_shape } else { 0 };
            let surface =
                Prefix { first: chunk.first + first, count: kept_prefix(of_part, keep), keep, shape };
            let all = Prefix { count: end - first, keep: KeptRange::KEEP_ALL, shape: 0, ..surface };
            let (mass, stand_ins) = match part.checked_sub(1) {
                Some(_) if self.cut.keeps_none() => (Prefix::default(), StandIns::default()),
                Some(part) if self.params.policy == Policy::Default => {
                    match stand_ins_for(&chunk.stand_ins[part], part == 1, spacing_px, sample_px, self.params)
                    {
                        Some(stand_ins) => (Prefix::default(), stand_ins),
                        None => (all, StandIns::default()),
                    }
                }
                _ => (Prefix { shape: 0, ..surface }, StandIns::default()),
            };
            PartChoice { surface, tested: self.tested(chunk, part, keep), mass, stand_ins }
        });
        let is_small = self.grown_radius_px(candidate) < POINT_HALF_PX;
        let least = |prefixes: &mut dyn Iterator<Item = Prefix>| {
            let drawn = prefixes.filter(|prefix| prefix.count > 0);
            drawn.map(|prefix| prefix.keep).min().unwrap_or(KeptRange::KEEP_ALL)
        };
        let front = || parts.iter().filter(|part| part.tested.is_none());
        let (front, open, mass) = (
            least(&mut front().map(|part| part.surface)),
            least(&mut parts[..2].iter().map(|part| part.surface)),
            least(&mut parts.iter().map(|part| part.mass)),
        );
        Choice {
            least_keep: if is_small { KeptRange::KEEP_ALL } else { front },
            is_uniform_surface: is_small || open == KeptRange::KEEP_ALL,
            is_uniform_mass: mass == KeptRange::KEEP_ALL,
            most_half_px: self.most_half_px(candidate, &parts),
            most_radius_px: self.most_radius_px(candidate, &parts),
            front_square_px: self.front_square_px(candidate, &parts),
            most_thickness: self.most_thickness(candidate, mass),
            parts,
        }
    }

    /// Keep probability of each part in 1/65536; the largest particles are `spacing_px` pixels apart.
    fn keeps(&self, candidate: &Candidate, spacing_px: f32) -> [u32; 3] {
        if self.params.mode == Mode::ErrorBound {
            // The kept ones of a shell are about as far apart as the tolerated error.
            let p = f64::from(spacing_px / self.params.error_px.max(f32::MIN_POSITIVE)).min(1.0);
            // What faces away or is buried only shows through cracks, and once the shell has holes it is no longer found
            // hidden: it thins out with the shell, but faster.
            let hidden = (1.0 - candidate.shell) / (1.0 - BURIED);
            let keep = |hidden: f64| Cut::integer(p.powf(2.0 + 6.0 * hidden));
            return [keep(0.0), keep(hidden), keep(1.0)];
        }
        let keep = |factor: f64, at_least: f64| self.cut.keep(candidate.importance * factor, at_least);
        let buried = if self.params.policy == Policy::Default { BURIED } else { 1.0 };
        [keep(1.0, candidate.spared), keep(candidate.shell, 0.0), keep(buried, 0.0)]
    }

    /// Half size in pixels that no particle of `parts` exceeds that counts in the thickness as itself.
    fn most_half_px(&self, candidate: &Candidate, parts: &[PartChoice]) -> f32 {
        let growth = |mass: &Prefix| if mass.keep == KeptRange::KEEP_ALL { 1.0 } else { MAX_GROWTH };
        let of_part = |part: &PartChoice| match part.mass.count {
            0 => 0.0,
            _ => {
                let radius_world = self.viewpoint.radius_world * candidate.chunk.largest * growth(&part.mass);
                self.view.most_half_px(radius_world, candidate.nearest)
            }
        };
        parts.iter().map(of_part).fold(0.0, f32::max)
    }

    /// Radius in pixels that no sphere of `parts` exceeds that is drawn, at its point nearest to the eye.
    fn most_radius_px(&self, candidate: &Candidate, parts: &[PartChoice]) -> f32 {
        let drawn = parts.iter().map(|part| part.surface).filter(|surface| surface.count > 0);
        let Some(least_keep) = drawn.map(|surface| surface.keep).min() else { return 0.0 };
        let growth = growth(least_keep as f32 / KeptRange::KEEP_ALL as f32, 1.0);
        let radius_world = self.viewpoint.radius_world * candidate.chunk.largest * growth;
        radius_world * self.view.px_per_world(candidate.nearest - radius_world * self.viewpoint.shell_reach)
    }

    /// Sum of the squared radii in pixels of what is drawn first, each as in the middle of the chunk.
    fn front_square_px(&self, candidate: &Candidate, parts: &[PartChoice]) -> f64 {
        let front = parts.iter().filter(|part| part.tested.is_none());
        let count: u32 = front.map(|part| part.surface.count).sum();
        let radius_world = self.viewpoint.radius_world * candidate.chunk.largest;
        let distance = self.view.distance(candidate.chunk.bounds.center());
        let half_px = f64::from(0.5 * self.view.diameter_px(radius_world, distance));
        f64::from(count) * half_px * half_px
    }

    /// Thickness in spacings that a chunk does not exceed in a pixel if all of it is there; `least_keep` is the smallest keep
    /// probability of what counts as itself. Particles and the stand-ins that replace them have the same volume, thinned ones more.
    fn most_thickness(&self, candidate: &Candidate, least_keep: u32) -> f64 {
        if least_keep != KeptRange::KEEP_ALL {
            return f64::INFINITY;
        }
        let side_px = f64::from(self.view.most_half_px(self.viewpoint.spacing_world, candidate.nearest));
        let volume = f64::from(candidate.chunk.count) * f64::from(candidate.chunk.largest).powi(3);
        volume * side_px * side_px
    }

    fn grown_radius_px(&self, candidate: &Candidate) -> f32 {
        let radius_world = self.viewpoint.radius_world * candidate.chunk.largest;
        0.5 * self.view.diameter_px(radius_world, candidate.nearest) * MAX_GROWTH
    }

    /// Where a part shows, if something may hide it: `None` for what is drawn first.
    fn tested(&self, chunk: &Chunk, part: usize, keep: u32) -> Option<Occludee> {
        let (bounds, reach) = match part {
            0 => return None,
            1 if self.may_face_eye(chunk) => return None,
            1 => (&chunk.bounds, self.viewpoint.shell_reach),
            _ => (&chunk.buried_bounds, 1.0),
        };
        let growth = if keep == KeptRange::KEEP_ALL { 1.0 } else { MAX_GROWTH };
        let reach_world = self.viewpoint.radius_world * chunk.largest * growth * reach;
        let silhouette = self.view.silhouette(bounds, reach_world)?;
        let packed = |tile: [u32; 2]| tile[0] | tile[1] << 16;
        Some(Occludee {
            range: KeptRange { first: 0, count: 0, keep: 0, shape: 0 },
            front: silhouette.front,
            first_tile: packed(silhouette.first_tile),
            last_tile: packed(silhouette.last_tile),
            pad: 0,
        })
    }

    fn may_face_eye(&self, chunk: &Chunk) -> bool {
        let coherence = chunk.outward.length();
        let facing = chunk.outward.dot(self.view.towards_eye(chunk.bounds.center()));
        coherence < FACING_COHERENCE || facing > FACING_AWAY * coherence
    }
}

/// Below this mean length of the directions that a chunk's shell faces, it faces several ways, and may be in front.
const FACING_COHERENCE: f32 = 0.3;
/// From this cosine on, shells that face away are not among those that are drawn first.
const FACING_AWAY: f32 = -0.2;
/// Half a pixel's diagonal: smaller splats are drawn as one pixel whatever their radius (`shaders/ssfr/splat.inc.wgsl`).
const POINT_HALF_PX: f32 = 0.71;

/// How many particles, sorted by hash, have a hash below `keep`.
fn kept_prefix(particles: &[PackedParticle], keep: u32) -> u32 {
    if keep >= KeptRange::KEEP_ALL {
        return particles.len() as u32;
    }
    particles.partition_point(|particle| u32::from(particle.hash()) < keep) as u32
}
