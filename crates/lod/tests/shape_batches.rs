//! Who gets a shape, and who may be a neighbour.

#[allow(dead_code, reason = "shared with the other tests")]
mod common;

use glam::Vec3;
use meniscus_core::ParticleFrame;
use meniscus_gpu::role::KeptRange;
use meniscus_lod::{ChunkOptions, ChunkedSet, chunks, shape_batches};

fn pool() -> ChunkedSet {
    chunks::build(&common::pool([40, 40, 20], 4), &ChunkOptions::new(9000, 1.0))
}

/// The slots of the particles in `pages`.
fn slots(set: &ChunkedSet, pages: &[Vec<KeptRange>]) -> Vec<usize> {
    let of_page = |(page, ranges): (usize, &Vec<KeptRange>)| {
        let start = set.page_slots(page).start;
        let of_range = |range: &KeptRange| range.first..range.first + range.count;
        ranges.iter().flat_map(of_range).map(|i| start + i as usize).collect::<Vec<_>>()
    };
    pages.iter().enumerate().flat_map(of_page).collect()
}

#[test]
fn every_particle_of_a_shell_is_shaped_once_with_all_that_is_near() {
    let set = pool();
    assert!(set.pages().len() > 2);
    let support = 2.5;
    let position = |slot: usize| Vec3::from(set.particles[slot].position_world);
    for most in [1, 4000, usize::MAX] {
        let batches = shape_batches(&set, support, most);
        assert_eq!(batches.len() == 1, most == usize::MAX);
        let mut shaped = vec![0; set.particles.len()];
        let mut places: Vec<Vec<u32>> = vec![Vec::new(); set.pages().len()];
        for batch in &batches {
            let mut near = vec![false; set.particles.len()];
            slots(&set, &batch.sources).into_iter().for_each(|slot| near[slot] = true);
            assert_eq!(near.iter().filter(|near| **near).count(), batch.source_particles);
            let targets = slots(&set, &batch.targets);
            for (page, ranges) in batch.targets.iter().enumerate() {
                let of_range = |range: &KeptRange| range.shape - 1..range.shape - 1 + range.count;
                places[page].extend(ranges.iter().flat_map(of_range));
            }
            for &slot in &targets {
                shaped[slot] += 1;
                let at = position(slot);
                assert!(at.clamp(batch.bounds.min, batch.bounds.max) == at);
            }
            for &slot in targets.iter().step_by(97) {
                let at = position(slot);
                let is_missed = |&other: &usize| !near[other] && position(other).distance(at) < support;
                assert_eq!((0..near.len()).find(is_missed), None);
            }
        }
        for chunk in &set.chunks {
            let first = set.page_slots(chunk.page as usize).start + chunk.first as usize;
            for i in 0..chunk.count as usize {
                let is_shell = (chunk.isolated..chunk.isolated + chunk.shell).contains(&(i as u32));
                assert_eq!(shaped[first + i], u32::from(is_shell));
            }
        }
        for (page, mut places) in places.into_iter().enumerate() {
            places.sort_unstable();
            assert!(places.into_iter().eq(0..set.shapes_in(page) as u32));
        }
    }
}

#[test]
fn nothing_has_no_batches() {
    let set = chunks::build(&ParticleFrame::default(), &ChunkOptions::new(100, 1.0));
    assert_eq!(shape_batches(&set, 2.5, 1000), []);
}
