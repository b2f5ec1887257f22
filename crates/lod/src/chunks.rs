//! A frame in the order that level of detail needs. Runs on reader threads, knows no GPU.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::Vec3;
use meniscus_core::{Aabb, ParticleFrame};
use meniscus_gpu::role::{FoamDrop, PackedParticle, StandIn};
use rayon::prelude::*;

use crate::cells::Cells;
use crate::foam;
use crate::grid::CellOrder;
use crate::stand_ins::{Coarseness, Gathering, Moments, StandIns};
use crate::{FoamOptions, Identity};

/// A particle with fewer others than this about two and a half spacings around it is isolated. The bulk has some hundred
/// and twenty there, a flat surface sixty, an edge of the fluid thirty, a thread of single particles four.
pub const ISOLATED_BELOW: u16 = 4;

/// A run of neighbouring particles of one page in three parts: isolated particles ([`ISOLATED_BELOW`]); the shell, which
/// may be seen from outside of the fluid; and what is buried under it. Each is sorted by rising hash.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chunk {
    /// Box around the particle centres, world.
    pub bounds: Aabb,
    /// Which page.
    pub page: u32,
    /// Index of the first particle in its page.
    pub first: u32,
    /// Number of particles, > 0.
    pub count: u32,
    /// How many of them, at the front, are isolated.
    pub isolated: u32,
    /// How many follow that belong to the shell; the others are buried.
    pub shell: u32,
    /// Place of the shell's first shape among those of its page, where shells have shapes; the others follow.
    pub first_shape: u32,
    /// Box around the centres of the buried particles, world.
    pub buried_bounds: Aabb,
    /// Where the shell faces, the mean over its particles: shorter than 1 where it faces several ways.
    pub outward: Vec3,
    /// Largest relative size of its particles.
    pub largest: f32,
    /// Stand-ins of shell and buried particles, each in the order of [`Coarseness::ALL`](crate::Coarseness::ALL).
    pub stand_ins: [[StandIns; 3]; 2],
}

/// Where a particle is in its chunk; orders the parts.
#[derive(Clone, Copy)]
enum Part {
    Isolated = 0,
    Shell = 1,
    Buried = 2,
}

/// How a frame is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChunkOptions {
    /// Most particles of a page: `Page::most_elements`. At least 1.
    pub page_particles: usize,
    /// Physical distance of neighbouring particles, world units. Any other number than a positive one only costs quality.
    pub spacing_world: f32,
    /// Most particles of a chunk, at least 1; chunks have at least half as many but for the last. See
    /// [`Self::DEFAULT_CHUNK_PARTICLES`].
    pub chunk_particles: usize,
    /// What the hash is made of ([`crate::Policy::identity`]).
    pub identity: Identity,
}

impl ChunkOptions {
    /// A cube of about eight spacings: hardly thicker than the shell of the fluid, so that what is hidden behind it is
    /// found; large enough to fill a workgroup, and that 18 M particles are some forty thousand decisions, a few
    /// milliseconds.
    pub const DEFAULT_CHUNK_PARTICLES: usize = 512;

    /// Default chunks, hashed by id.
    pub fn new(page_particles: usize, spacing_world: f32) -> Self {
        Self {
            page_particles,
            spacing_world,
            chunk_particles: Self::DEFAULT_CHUNK_PARTICLES,
            identity: Identity::Id,
        }
    }
}

/// A particle frame in chunks, ready for upload.
#[derive(Clone, Debug)]
pub struct ChunkedSet {
    /// All pages one after the other; [`Self::pages`] tells them apart.
    pub particles: Vec<PackedParticle>,
    /// Index in the frame of the particle in each slot of `particles`: brings attributes into the same order.
    pub attribute_order: Vec<u32>,
    /// The chunks in the order of their particles.
    pub chunks: Vec<Chunk>,
    /// Stand-ins of each page's chunks.
    pub stand_ins: Vec<Vec<StandIn>>,
    /// Drops of foam, drawn for isolated particles in place of their spheres and for others over them; `None` for a set without
    /// foam. In the order of [`foam::prefix`].
    pub foam: Option<Vec<FoamDrop>>,
    /// Box around all particle centres, world.
    pub bounds: Aabb,
    /// Whether particles have sizes of their own.
    pub has_sizes: bool,
    page_starts: Vec<usize>,
    serial: u64,
}

impl ChunkedSet {
    /// The pages, none of them empty.
    pub fn pages(&self) -> impl ExactSizeIterator<Item = &[PackedParticle]> {
        (0..self.page_starts.len()).map(|page| &self.particles[self.page_slots(page)])
    }

    /// Slots of page `page` in `particles` and `attribute_order`.
    ///
    /// # Panics
    /// If there is no such page.
    pub fn page_slots(&self, page: usize) -> Range<usize> {
        let end = self.page_starts.get(page + 1).copied().unwrap_or(self.particles.len());
        self.page_starts[page]..end
    }

    /// The particles of one of the set's chunks.
    ///
    /// # Panics
    /// If the chunk is of another set.
    pub fn particles_of(&self, chunk: &Chunk) -> &[PackedParticle] {
        let first = self.page_starts[chunk.page as usize] + chunk.first as usize;
        &self.particles[first..first + chunk.count as usize]
    }

    /// How many particles of page `page` belong to the shell, each of which may have a shape.
    pub fn shapes_in(&self, page: usize) -> usize {
        let of_page = self.chunks.iter().filter(|chunk| chunk.page as usize == page);
        of_page.map(|chunk| chunk.shell as usize).sum()
    }

    /// Tells sets of one process apart: two sets with the same number hold the same data.
    pub fn serial(&self) -> u64 {
        self.serial
    }

    /// Bytes held in memory.
    pub fn bytes(&self) -> u64 {
        let per_particle = size_of::<PackedParticle>() + size_of::<u32>();
        let stand_ins: usize = self.stand_ins.iter().map(|page| size_of_val(page.as_slice())).sum();
        let foam = self.foam.as_ref().map_or(0, |drops| size_of_val(drops.as_slice()));
        (self.particles.len() * per_particle + self.chunks.len() * size_of::<Chunk>() + stand_ins + foam)
            as u64
    }
}

/// Cuts a frame into chunks and pages. Deterministic for any number of threads. Takes O(n log n), and 32 bytes per particle
/// at its height, of which 23 are the result; scattered particles, each in a cell of its own, take three times as much.
///
/// # Panics
/// Beyond 2^32 particles, which is 48 GiB of positions.
pub fn build(frame: &ParticleFrame, options: &ChunkOptions) -> ChunkedSet {
    build_with_foam(frame, options, None)
}

/// As [`build`], with what is drawn as foam; 52 bytes per particle more at its height where velocities count.
///
/// # Panics
/// As [`build`].
pub fn build_with_foam(
    frame: &ParticleFrame,
    options: &ChunkOptions,
    foam: Option<&FoamOptions>,
) -> ChunkedSet {
    let n = frame.len();
    assert!(u32::try_from(n).is_ok(), "{n} particles in one set; at most 2^32 - 1 can be indexed");
    let order = CellOrder::new(&frame.positions, options.spacing_world);
    let cells = Cells::of(&order, frame, options.spacing_world, ISOLATED_BELOW);
    let cuts = cells.cuts(n, options.chunk_particles.min(options.page_particles));
    let (mut chunks, page_starts) = lay_out(&cuts, options.page_particles.max(1));

    // Zeros, which the system makes where they are first written: by all threads.
    let mut particles: Vec<PackedParticle> = bytemuck::zeroed_vec(n);
    let mut attribute_order = vec![0u32; n];
    let mut rests = (particles.as_mut_slice(), attribute_order.as_mut_slice());
    let mut first_slot = 0;
    let mut jobs = Vec::with_capacity(chunks.len());
    for chunk in &mut chunks {
        let count = chunk.count as usize;
        let (particles, rest) = std::mem::take(&mut rests.0).split_at_mut(count);
        rests.0 = rest;
        let (sources, rest) = std::mem::take(&mut rests.1).split_at_mut(count);
        rests.1 = rest;
        jobs.push(ChunkJob { first_slot, chunk, particles, sources });
        first_slot += count;
    }
    let context = Context { frame, options, order: &order, cells: &cells };
    let of_chunks: Vec<Vec<StandIn>> =
        jobs.into_par_iter().map_init(Scratch::default, |scratch, job| job.fill(&context, scratch)).collect();

    number_shapes(&mut chunks);

    static SERIAL: AtomicU64 = AtomicU64::new(0);
    ChunkedSet {
        particles,
        attribute_order,
        bounds: chunks.iter().fold(Aabb::EMPTY, |bounds, chunk| bounds.union(chunk.bounds)),
        stand_ins: by_page(&mut chunks, &of_chunks, page_starts.len()),
        chunks,
        has_sizes: !frame.sizes.is_empty(),
        foam: foam.map(|foam| foam::drops(&order, frame, options.spacing_world, foam)),
        page_starts,
        serial: SERIAL.fetch_add(1, Ordering::Relaxed),
    }
}

/// Gives the shells of each page their places among its shapes.
fn number_shapes(chunks: &mut [Chunk]) {
    for of_page in chunks.chunk_by_mut(|a, b| a.page == b.page) {
        let mut next = 0;
        for chunk in of_page {
            chunk.first_shape = next;
            next += chunk.shell;
        }
    }
}

/// The stand-ins of the chunks, one list per page, into which the chunks then point. Those of one coarseness and part lie side
/// by side, so that the few that each chunk of distant water has make runs long enough for a workgroup.
fn by_page(chunks: &mut [Chunk], of_chunks: &[Vec<StandIn>], pages: usize) -> Vec<Vec<StandIn>> {
    let mut lists = vec![Vec::new(); pages];
    for coarseness in Coarseness::ALL {
        for part in 0..2 {
            for (chunk, stand_ins) in chunks.iter_mut().zip(of_chunks) {
                let list = &mut lists[chunk.page as usize];
                let of_part = &mut chunk.stand_ins[part][coarseness as usize];
                let first = list.len() as u32;
                list.extend_from_slice(&stand_ins[Range::from(*of_part)]);
                of_part.first = first;
            }
        }
    }
    lists
}

/// Chunks of the given ends, a new page where the next chunk does not fit; and the first slot of each page.
fn lay_out(cuts: &[usize], page_particles: usize) -> (Vec<Chunk>, Vec<usize>) {
    let mut page_starts: Vec<usize> = Vec::new();
    let mut start = 0;
    let chunks = cuts
        .iter()
        .map(|&end| {
            if page_starts.last().is_none_or(|&page_start| end - page_start > page_particles) {
                page_starts.push(start);
            }
            let first = start - page_starts[page_starts.len() - 1];
            let chunk = Chunk {
                bounds: Aabb::EMPTY,
                page: page_starts.len() as u32 - 1,
                first: first as u32,
                count: (end - start) as u32,
                isolated: 0,
                shell: 0,
                first_shape: 0,
                buried_bounds: Aabb::EMPTY,
                outward: Vec3::ZERO,
                largest: 1.0,
                stand_ins: Default::default(),
            };
            start = end;
            chunk
        })
        .collect();
    (chunks, page_starts)
}

/// What all chunks of a frame are made from.
struct Context<'a> {
    frame: &'a ParticleFrame,
    options: &'a ChunkOptions,
    order: &'a CellOrder,
    cells: &'a Cells,
}

/// Sorts the particles of one chunk into their slots.
struct ChunkJob<'a> {
    first_slot: usize,
    chunk: &'a mut Chunk,
    particles: &'a mut [PackedParticle],
    sources: &'a mut [u32],
}

/// Memory of a thread that fills chunks.
#[derive(Default)]
struct Scratch {
    /// The chunk's particles along the curve.
    positions: Vec<[f32; 3]>,
    /// Their relative sizes.
    sizes: Vec<f32>,
    parts: Vec<Part>,
    /// What they are sorted by, most significant first: part (2 bits), hash (16 bits), place on the curve (32 bits).
    ranks: Vec<u64>,
    gatherings: [Gathering; 2],
}

impl ChunkJob<'_> {
    /// Fills the chunk and gives its stand-ins.
    fn fill(self, context: &Context, scratch: &mut Scratch) -> Vec<StandIn> {
        let Context { frame, options, order, cells } = *context;
        let Scratch { positions, sizes, parts, ranks, gatherings } = scratch;
        let slots = self.first_slot..self.first_slot + self.particles.len();
        let index = |local: usize| order.index(self.first_slot + local);
        // On their own, so that the cache misses of a frame in random order overlap.
        positions.clear();
        positions.extend((0..self.particles.len()).map(|local| frame.positions[index(local) as usize]));
        sizes.clear();
        sizes.extend((0..self.particles.len()).map(|local| frame.size(index(local) as usize)));
        self.chunk.largest = sizes.iter().copied().fold(0.0, f32::max);

        parts.clear();
        for (cell, locals) in cells.in_slots(slots.clone()) {
            parts.resize(locals.end, if cell.is_buried { Part::Buried } else { Part::Shell });
        }
        cells.isolated_in(slots.clone()).for_each(|local| parts[local] = Part::Isolated);
        self.chunk.buried_bounds = Aabb::of_points(
            positions.iter().zip(&*parts).filter(|(_, part)| matches!(part, Part::Buried)).map(|(p, _)| p),
        );
        self.chunk.outward = outward(cells, slots.clone());

        let origin = Vec3::from(positions[0]);
        let spacing_world = f64::from(options.spacing_world);
        for (cell, locals) in cells.in_slots(slots) {
            let mut moments = Moments::default();
            for local in locals.filter(|&local| !matches!(parts[local], Part::Isolated)) {
                moments.add(Vec3::from(positions[local]) - origin, sizes[local]);
            }
            gatherings[usize::from(cell.is_buried)].add_cell(cell.code, &moments, origin, spacing_world);
        }
        let mut stand_ins = Vec::new();
        for (of_part, gathering) in self.chunk.stand_ins.iter_mut().zip(gatherings) {
            *of_part = gathering.end(origin, spacing_world, &mut stand_ins);
        }

        ranks.clear();
        ranks.extend(positions.iter().zip(&*parts).enumerate().map(|(local, (&position, &part))| {
            let hash = options.identity.hash(frame.id(index(local) as usize), position.into());
            (part as u64) << 48 | u64::from(hash) << 32 | local as u64
        }));
        ranks.sort_unstable();
        // Equal hashes by id, which does not depend on the order of the file.
        for equals in ranks.chunk_by_mut(|a, b| a >> 32 == b >> 32).filter(|equals| equals.len() > 1) {
            equals.sort_by_key(|&rank| frame.id(index(rank as u32 as usize) as usize));
        }

        let slots = self.particles.iter_mut().zip(self.sources);
        for (&rank, (particle, source)) in ranks.iter().zip(slots) {
            let local = rank as u32 as usize;
            *particle = PackedParticle::sized(positions[local], (rank >> 32) as u16, sizes[local]);
            *source = index(local);
        }
        let before = |part: Part| ranks.partition_point(|rank| rank >> 48 < part as u64) as u32;
        self.chunk.isolated = before(Part::Shell);
        self.chunk.shell = before(Part::Buried) - self.chunk.isolated;
        self.chunk.bounds = Aabb::of_points(positions.iter());
        stand_ins
    }
}

/// The mean direction in which the cells of `slots` are open, weighted by their particles.
fn outward(cells: &Cells, slots: Range<usize>) -> Vec3 {
    let (mut sum, mut total) = (Vec3::ZERO, 0.0);
    for (cell, locals) in cells.in_slots(slots).filter(|(cell, _)| !cell.is_buried) {
        sum += Vec3::from(cell.outward.map(f32::from)).normalize_or_zero() * locals.len() as f32;
        total += locals.len() as f32;
    }
    sum / f32::max(total, 1.0)
}
