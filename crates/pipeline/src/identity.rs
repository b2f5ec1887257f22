//! Whether the particles of a file without ids keep their places from frame to frame (`main-renderer.md` 3.4).

use std::collections::HashMap;

use glam::Vec3;
use meniscus_core::Flaw;

use crate::{PreparedFrame, PreparedSet};

/// Pairs looked at per set: enough that a share of a few percent is certain.
const PAIRS: usize = 2000;
/// Neighbours count as parted when they move relative to each other by more than this many spacings between two frames. What
/// all move together does not count: fast water covers many spacings from frame to frame.
const PARTED_SPACINGS: f32 = 2.0;
/// From this share on the indices are no identities. Splashes part a few percent, files in a new order nearly all.
const UNSTABLE: f64 = 0.25;

/// A particle: its index in the file, and where it is, world.
type Place = (u32, Vec3);

/// What is remembered of a set.
#[derive(Debug)]
struct Sample {
    particles: usize,
    /// Neighbours of each other.
    pairs: Vec<[Place; 2]>,
}

/// Compares every frame with the one before.
#[derive(Debug, Default)]
pub(crate) struct IdentityWatch {
    last_frame: Option<usize>,
    last: Vec<Sample>,
}

impl IdentityWatch {
    /// Looks at `frame`; a flaw where it follows the frame looked at before and its particles have other indices.
    pub(crate) fn observe(&mut self, frame: &PreparedFrame, spacing_world: f32) -> Option<Flaw> {
        if self.last_frame == Some(frame.index) {
            return None;
        }
        let follows = self.last_frame.is_some_and(|last| last.abs_diff(frame.index) == 1);
        let watched = || frame.sets.iter().filter(|set| !set.has_ids);
        let share = watched()
            .zip(&self.last)
            .filter(|(set, sample)| follows && set.chunked.particles.len() == sample.particles)
            .map(|(set, sample)| parted(set, &sample.pairs, spacing_world))
            .fold(0.0, f64::max);
        let sample = |set: &PreparedSet| Sample { particles: set.chunked.particles.len(), pairs: pairs(set) };
        self.last = watched().map(sample).collect();
        self.last_frame = Some(frame.index);
        (share > UNSTABLE).then_some(Flaw::UnstableIdentity { share })
    }
}

/// Neighbours of a set, spread over it.
fn pairs(set: &PreparedSet) -> Vec<[Place; 2]> {
    let chunked = &set.chunked;
    let at =
        |slot: usize| (chunked.attribute_order[slot], Vec3::from(chunked.particles[slot].position_world));
    let last = chunked.particles.len().saturating_sub(1);
    // Slots that follow each other are all but always of one chunk.
    (0..last).step_by((last / PAIRS).max(1)).map(|slot| [at(slot), at(slot + 1)]).collect()
}

/// Share of `pairs` that are further from each other in `set` than they were, or nearer.
fn parted(set: &PreparedSet, pairs: &[[Place; 2]], spacing_world: f32) -> f64 {
    let mut now: HashMap<u32, Option<Vec3>> =
        pairs.iter().flatten().map(|&(index, _)| (index, None)).collect();
    for (particle, index) in set.chunked.particles.iter().zip(&set.chunked.attribute_order) {
        if let Some(position) = now.get_mut(index) {
            *position = Some(particle.position_world.into());
        }
    }
    let moved = |(index, before): Place| now[&index].map(|after| after - before);
    let is_parted = |[a, b]: &[(u32, Vec3); 2]| match (moved(*a), moved(*b)) {
        (Some(a), Some(b)) => (a - b).length() > PARTED_SPACINGS * spacing_world,
        _ => false,
    };
    pairs.iter().filter(|pair| is_parted(pair)).count() as f64 / pairs.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use meniscus_core::{Look, ParticleFrame, ParticleSet, SetFrame};
    use meniscus_lod::Identity;

    use super::*;
    use crate::Preparer;

    /// A block of water that has moved by `frame` times five spacings and is sheared a little; particles in an order of their own.
    fn frame(index: usize, ids: Vec<u64>, order: impl Fn(usize) -> usize) -> PreparedFrame {
        let at = |i: usize| {
            let [x, y, z] = [i % 20, i / 20 % 20, i / 400].map(|c| c as f32);
            [x + index as f32 * (5.0 + 0.02 * z), y, z]
        };
        let positions = (0..8000).map(|i| at(order(i))).collect();
        let particles = ParticleFrame { positions, ids, ..Default::default() };
        let water = ParticleSet { name: "water".into(), look: Look::Water, particles };
        let preparer = Preparer {
            page_particles: 1 << 20,
            spacing_world: 1.0,
            identity: Identity::Id,
            quantity: None,
            foam: None,
        };
        preparer.prepare(SetFrame { index, sets: vec![water], ..Default::default() })
    }

    #[test]
    fn water_that_moves_keeps_its_identity_and_a_file_in_a_new_order_does_not() {
        let as_it_is = |i: usize| i;
        let shuffled = |i: usize| i * 4001 % 8000;
        let mut watch = IdentityWatch::default();
        assert_eq!(watch.observe(&frame(0, Vec::new(), as_it_is), 1.0), None);
        assert_eq!(watch.observe(&frame(1, Vec::new(), as_it_is), 1.0), None);
        let flaw = watch.observe(&frame(2, Vec::new(), shuffled), 1.0);
        assert!(matches!(flaw, Some(Flaw::UnstableIdentity { share }) if share > 0.5), "{flaw:?}");
        // The same frame again is no news, a jump is not compared.
        assert_eq!(watch.observe(&frame(2, Vec::new(), as_it_is), 1.0), None);
        assert_eq!(watch.observe(&frame(7, Vec::new(), as_it_is), 1.0), None);
    }

    #[test]
    fn with_ids_the_order_does_not_matter() {
        let mut watch = IdentityWatch::default();
        assert_eq!(watch.observe(&frame(0, (0..8000).collect(), |i| i), 1.0), None);
        let ids = (0..8000).map(|i| i * 4001 % 8000).collect();
        assert_eq!(watch.observe(&frame(1, ids, |i| i * 4001 % 8000), 1.0), None);
    }
}
