//! Made particle sets and cameras.

use glam::Vec3;
use meniscus_core::{Camera, ParticleFrame, Projection};
use meniscus_gpu::role::{KeptRange, PackedParticle};
use meniscus_lod::{ChunkOptions, ChunkedSet, PageSelection, Selection, Viewpoint, chunks};

/// Numbers in [0, 1) that depend on nothing but the seed (Knuth's MMIX generator, high bits).
pub fn random(mut seed: u64) -> impl FnMut() -> f32 {
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 40) as f32 / (1u64 << 24) as f32
    }
}

/// A jittered lattice of spacing 1 from the origin, and above it `spray` particles at least ten spacings apart.
pub fn pool(side: [usize; 3], spray: usize) -> ParticleFrame {
    let mut random = random(7);
    let mut positions = Vec::new();
    for z in 0..side[2] {
        for y in 0..side[1] {
            for x in 0..side[0] {
                positions.push([x, y, z].map(|c| c as f32 + 0.3 * (random() - 0.5)));
            }
        }
    }
    let top = side[2] as f32 + 20.0;
    positions.extend((0..spray).map(|i| [(i % 16 * 10) as f32, (i / 16 * 10) as f32, top]));
    ParticleFrame { positions, ..Default::default() }
}

/// `frame` with particles of half to twice the set's own size, in numbers that half precision holds as they are.
pub fn of_many_sizes(frame: ParticleFrame) -> ParticleFrame {
    let mut random = random(11);
    let sizes = frame.positions.iter().map(|_| [0.5, 1.0, 1.5, 2.0][(random() * 4.0) as usize]).collect();
    ParticleFrame { sizes, ..frame }
}

/// Size of a particle, relative to the set's own.
pub fn size(particle: &PackedParticle) -> f32 {
    half::f16::from_bits((particle.packed >> 16) as u16).to_f32()
}

/// One page, default chunks, spacing 1.
pub fn chunked(frame: &ParticleFrame) -> ChunkedSet {
    chunks::build(frame, &ChunkOptions::new(1 << 23, 1.0))
}

/// A perspective and a parallel camera at `eye` that look at `target`, z up.
pub fn cameras(eye: Vec3, target: Vec3) -> [Camera; 2] {
    [Projection::Perspective { fovy_rad: 0.9 }, Projection::Orthographic { height_world: 40.0 }]
        .map(|projection| Camera { eye, target, up: Vec3::Z, projection, near: 0.05 })
}

/// A view of a set of spacing 1.
pub fn viewpoint(camera: &Camera, size_px: [u32; 2], radius_world: f32) -> Viewpoint {
    Viewpoint { camera: *camera, size_px, radius_world, shell_reach: 1.0, spacing_world: 1.0, sample_px: 2 }
}

/// The slots that a selection draws the surface from, with their keep probability in 1/65536: those drawn first, near ones
/// first, then the tested.
pub fn kept_slots(set: &ChunkedSet, selection: &Selection) -> Vec<(usize, u32)> {
    let of_page = |(page, of_page): (usize, &PageSelection)| {
        let first = set.page_slots(page).start;
        let slots = |r: &KeptRange| (r.first..r.first + r.count).map(move |i| first + i as usize);
        of_page.surface().flat_map(|r| slots(r).map(|slot| (slot, r.keep))).collect::<Vec<_>>()
    };
    selection.pages.iter().enumerate().flat_map(of_page).collect()
}

/// Centre of a particle.
pub fn center(particle: &PackedParticle) -> Vec3 {
    particle.position_world.into()
}
