//! Chunking: every particle once, compact and sorted, the same for any number of threads.

#[allow(dead_code, reason = "shared with the other tests")]
mod common;

use common::{center, chunked, of_many_sizes, pool, size};
use glam::{DVec3, Vec3};
use meniscus_core::{Aabb, ParticleFrame};
use meniscus_gpu::role::{PackedParticle, StandIn};
use meniscus_lod::{ChunkOptions, ChunkedSet, Identity, chunks};
use proptest::prelude::*;

/// Stand-ins have the volume, the centre of mass and the second moments of what they stand for.
fn assert_conserved(particles: &[PackedParticle], stand_ins: &[StandIn], spacing: f32) {
    let half = |bits: u32| f64::from(half::f16::from_bits(bits as u16));
    let volume: f64 = stand_ins.iter().map(|s| half(s.packed & 0xffff)).sum();
    let volume_of = |p: &PackedParticle| f64::from(size(p)).powi(3);
    let all: f64 = particles.iter().map(volume_of).sum();
    // Whole numbers up to 2048 are exact in half precision, and chunks are smaller; others are rounded to 2^-11.
    let tolerance = if particles.iter().all(|p| size(p) == 1.0) { 0.0 } else { all / 2048.0 };
    assert!((volume - all).abs() <= tolerance, "{volume} of {all}");
    let moments = |of: &mut dyn Iterator<Item = (DVec3, f64, f64)>| {
        of.fold((DVec3::ZERO, 0.0), |(sum, squares), (center, volume, own)| {
            (sum + center * volume, squares + volume * (center.length_squared() + own))
        })
    };
    let origin = center(&particles[0]).as_dvec3();
    // A sphere's own second moment is 3/5 of its squared radius; particles are counted with the default radius of 0.625
    // spacings, stand-ins without what they are widened by (0.715 / 0.645).
    let (sum, squares) = moments(&mut particles.iter().map(|p| {
        let radius = 0.625 * f64::from(spacing) * f64::from(size(p));
        (center(p).as_dvec3() - origin, volume_of(p), 0.6 * radius * radius)
    }));
    let (sum_of, squares_of) = moments(&mut stand_ins.iter().map(|s| {
        let radius = half(s.packed >> 16) * f64::from(spacing) * 0.645 / 0.715;
        let center = Vec3::from(s.center_world).as_dvec3() - origin;
        (center, half(s.packed & 0xffff), 0.6 * radius * radius)
    }));
    let n = all;
    let size = (squares / n).sqrt() + origin.length() * 1e-3;
    // Centres are rounded to f32, radii to half precision, 2^-11 relative, which counts twice in their squares; so are volumes
    // that are no whole numbers.
    assert!((sum - sum_of).length() <= n * 1e-5 * size + tolerance * size, "{sum} {sum_of}");
    assert!((squares - squares_of).abs() / n < 2e-3 * size * size, "{squares} {squares_of}");
}

/// What must hold of any set.
fn assert_sound(frame: &ParticleFrame, options: &ChunkOptions, set: &ChunkedSet) {
    let mut sources = set.attribute_order.clone();
    sources.sort_unstable();
    assert!(sources.iter().copied().eq(0..frame.len() as u32), "a particle is missing or doubled");
    for (particle, &source) in set.particles.iter().zip(&set.attribute_order) {
        assert_eq!(particle.position_world, frame.positions[source as usize]);
        assert_eq!(size(particle), half::f16::from_f32(frame.size(source as usize)).to_f32());
        if options.identity == Identity::Id {
            let alone = ParticleFrame {
                positions: vec![particle.position_world],
                ids: vec![frame.id(source as usize)],
                sizes: vec![frame.size(source as usize)],
                ..Default::default()
            };
            assert_eq!(chunks::build(&alone, options).particles[0], *particle, "hash is not of the id");
        }
    }
    assert_eq!(set.bounds, frame.bounds());
    assert_eq!(set.pages().map(<[_]>::len).sum::<usize>(), frame.len());
    assert!(set.pages().all(|page| !page.is_empty() && page.len() <= options.page_particles));

    let mut slot = 0;
    for chunk in &set.chunks {
        assert_eq!(set.page_slots(chunk.page as usize).start + chunk.first as usize, slot);
        slot += chunk.count as usize;
        let particles = set.particles_of(chunk);
        assert!(!particles.is_empty() && particles.len() <= options.chunk_particles);
        assert_eq!(chunk.bounds, Aabb::of_points(particles.iter().map(|p| &p.position_world)));
        let (isolated, others) = particles.split_at(chunk.isolated as usize);
        let (shell, buried) = others.split_at(chunk.shell as usize);
        for part in [isolated, shell, buried] {
            assert!(part.is_sorted_by_key(|p| p.hash()));
        }
        assert_eq!(chunk.buried_bounds, Aabb::of_points(buried.iter().map(|p| &p.position_world)));
        assert_eq!(chunk.largest, particles.iter().map(size).fold(0.0, f32::max));
        // One rounding of each of up to a few thousand directions of length 1.
        assert!(chunk.outward.length() <= 1.0 + 1e-4);
        for (part, levels) in [shell, buried].into_iter().zip(&chunk.stand_ins) {
            for stand_ins in levels.iter().filter(|stand_ins| stand_ins.count > 0) {
                let spheres = &set.stand_ins[chunk.page as usize][std::ops::Range::from(*stand_ins)];
                assert_conserved(part, spheres, options.spacing_world);
            }
        }
    }
    assert_eq!(slot, frame.len());
}

#[test]
fn a_pool_with_spray_is_cut_into_compact_chunks() {
    let frame = pool([40, 40, 40], 64);
    let options = ChunkOptions { page_particles: 10_000, ..ChunkOptions::new(0, 1.0) };
    let set = chunks::build(&frame, &options);
    assert_sound(&frame, &options, &set);
    assert!(set.pages().len() > 6);
    let in_pool = |chunk: &&meniscus_lod::Chunk| chunk.bounds.max.z < 41.0;
    for chunk in set.chunks.iter().filter(in_pool) {
        // At most 512 particles of spacing 1, a cube of 8; along the curve, two and a half of them in a row.
        assert!(chunk.bounds.extent().max_element() < 20.0, "{chunk:?}");
    }
    let volume: f32 = set.chunks.iter().filter(in_pool).map(|c| c.bounds.extent().element_product()).sum();
    // The boxes overlap little: together at most twice the pool.
    assert!(volume < 2.0 * 40.0f32.powi(3), "{volume}");
}

#[test]
fn particles_of_many_sizes_are_kept_with_their_volumes() {
    let frame = of_many_sizes(pool([30, 30, 30], 64));
    let options = ChunkOptions::new(10_000, 1.0);
    let set = chunks::build(&frame, &options);
    assert_sound(&frame, &options, &set);
    assert!(set.has_sizes && set.chunks.iter().any(|chunk| chunk.stand_ins[0][0].count > 0));
}

#[test]
fn sizes_that_are_none_are_drawn_as_the_sets_own() {
    let sizes = vec![f32::NAN, 0.0, -2.0, f32::INFINITY, 1e-9, 0.75];
    let frame = ParticleFrame { positions: vec![[0.5; 3]; 6], sizes, ..Default::default() };
    let set = chunked(&frame);
    let by_source: Vec<f32> = (0..6)
        .map(|source| {
            set.attribute_order.iter().position(|&s| s == source).map(|slot| size(&set.particles[slot]))
        })
        .map(|found| found.expect("each is there"))
        .collect();
    assert_eq!(by_source, [1.0, 1.0, 1.0, 32.0, 0.031_25, 0.75]);
}

/// As many as in the bulk, but too small to hide what is behind them.
#[test]
fn a_cloud_of_small_particles_buries_nothing() {
    let frame = pool([20, 20, 20], 0);
    let buried = |size: f32| {
        let sizes = vec![size; frame.len()];
        let set = chunked(&ParticleFrame { sizes, ..frame.clone() });
        set.chunks.iter().map(|chunk| chunk.count - chunk.isolated - chunk.shell).sum::<u32>()
    };
    assert!(buried(1.0) > 1000);
    assert_eq!(buried(0.5), 0);
}

#[test]
fn spray_is_isolated_and_the_pool_is_not() {
    let (side, spray) = ([30, 30, 30], 50);
    let frame = pool(side, spray);
    let set = chunked(&frame);
    let isolated = |chunk: &meniscus_lod::Chunk| set.particles_of(chunk)[..chunk.isolated as usize].to_vec();
    let (in_air, in_pool): (Vec<_>, Vec<_>) =
        set.chunks.iter().flat_map(isolated).map(|p| center(&p)).partition(|p| p.z > side[2] as f32);
    assert_eq!(in_air.len(), spray);
    // A corner has seven neighbours about it, of which the cells may miss some; the cells reach that far at least.
    let at_corner = |p: &Vec3| p.to_array().iter().all(|&c| (c - 14.5).abs() > 12.5);
    assert!(in_pool.iter().all(at_corner), "{in_pool:?}");
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let frame = pool([50, 40, 30], 100);
    let build = |threads| {
        let threads = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        threads.install(|| chunked(&frame))
    };
    let one = build(1);
    for threads in [2, 3, 8] {
        let many = build(threads);
        assert_eq!(one.particles, many.particles);
        assert_eq!(one.attribute_order, many.attribute_order);
        assert_eq!(one.chunks, many.chunks);
        assert_ne!(one.serial(), many.serial());
    }
}

#[test]
fn the_same_particles_go_first_wherever_they_have_moved() {
    let frame = pool([20, 20, 20], 0);
    let ids: Vec<u64> = (0..frame.len() as u64).map(|i| i * 3 + 1_000_000_007).collect();
    let moved = ParticleFrame {
        positions: frame.positions.iter().rev().map(|&p| (Vec3::from(p) * 1.1 + 7.0).to_array()).collect(),
        ids: ids.iter().rev().copied().collect(),
        ..Default::default()
    };
    let still = ParticleFrame { ids, ..frame };
    let hashes = |frame: &ParticleFrame| {
        let set = chunked(frame);
        let mut by_id: Vec<(u64, u16)> = set
            .attribute_order
            .iter()
            .zip(&set.particles)
            .map(|(&source, particle)| (frame.id(source as usize), particle.hash()))
            .collect();
        by_id.sort_unstable();
        by_id
    };
    assert_eq!(hashes(&still), hashes(&moved));
}

#[test]
fn a_chunk_does_not_depend_on_the_order_of_the_file() {
    let frame = pool([12, 12, 14], 0);
    let ids: Vec<u64> = (0..frame.len() as u64).collect();
    let reversed = ParticleFrame {
        positions: frame.positions.iter().rev().copied().collect(),
        ids: ids.iter().rev().copied().collect(),
        ..Default::default()
    };
    // All in one cell, within which the curve has the order of the file.
    let options = ChunkOptions { chunk_particles: 4096, ..ChunkOptions::new(1 << 20, 100.0) };
    let [set, other] = [&ParticleFrame { ids, ..frame }, &reversed].map(|f| chunks::build(f, &options));
    assert_eq!(set.chunks.len(), 1);
    let equal_hashes = set.particles.windows(2).filter(|pair| pair[0].hash() == pair[1].hash()).count();
    assert!(equal_hashes > 5, "two thousand of 65536 collide some thirty times: {equal_hashes}");
    assert_eq!(set.particles, other.particles);
}

#[test]
fn degenerate_sets_are_cut_too() {
    for frame in [
        ParticleFrame::default(),
        ParticleFrame { positions: vec![[1.0, 2.0, 3.0]], ..Default::default() },
        ParticleFrame { positions: vec![[-1e30, 0.0, 1e30], [1e30, 5.0, f32::MAX]], ..Default::default() },
    ] {
        let options = ChunkOptions::new(100, 0.5);
        assert_sound(&frame, &options, &chunks::build(&frame, &options));
    }
    let equal = ParticleFrame { positions: vec![[4.0; 3]; 1_000_000], ..Default::default() };
    let set = chunked(&equal);
    assert_eq!(set.chunks.len(), 1_000_000usize.div_ceil(ChunkOptions::DEFAULT_CHUNK_PARTICLES));
    assert!(set.chunks.iter().all(|c| c.isolated == 0 && c.bounds.extent() == Vec3::ZERO));
    assert!(set.particles.iter().all(|p| center(p) == Vec3::splat(4.0)));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn any_cloud_is_cut_soundly(
        positions in prop::collection::vec(prop::array::uniform3(-20.0f32..20.0), 0..300),
        spacing_world in 0.01f32..10.0,
        chunk_particles in 1usize..60,
        page_particles in 1usize..200,
    ) {
        let frame = ParticleFrame { positions, ..Default::default() };
        let options = ChunkOptions { spacing_world, chunk_particles, ..ChunkOptions::new(page_particles, 1.0) };
        assert_sound(&frame, &options, &chunks::build(&frame, &options));
    }
}
