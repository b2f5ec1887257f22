//! What is drawn for a foamy particle: a cloud of small soft drops. A particle stands for far more water than a drop of spray or a
//! bubble holds; drawn as one disc, it would look like a ball of snow.

use glam::Vec3;
use meniscus_core::ParticleFrame;
use meniscus_gpu::role::FoamDrop;
use rayon::prelude::*;

use super::Foaminess;
use crate::grid::CellOrder;

/// Drops of one particle.
pub const DROPS: usize = 16;
/// Less foam than this is not drawn: a fiftieth of a drop's light would not be seen.
const LEAST: f32 = 0.02;
/// Of trapped air and of spray: radius of a particle's cloud of drops, which flow into those of its neighbours, and radius of the
/// drops, both in spacings; optical depth at their centre. `DROPS` of the first on a spacing squared have a mean optical depth
/// of 1.1: a layer of particles that are all foam hides two thirds of what is behind.
const TRAPPED: [f32; 3] = [1.2, 0.26, 1.0];
const SPRAY: [f32; 3] = [1.6, 0.11, 1.6];

/// The drops of the foamy ones among the particles of `order`: the first drop of each, then the second of each, and so on, so
/// that [`prefix`] is thinner foam.
pub(super) fn of(
    order: &CellOrder,
    frame: &ParticleFrame,
    spacing_world: f32,
    foaminess: &[Foaminess],
) -> Vec<FoamDrop> {
    let foamy: Vec<(u32, Foaminess)> = foaminess
        .iter()
        .enumerate()
        .filter(|(_, foam)| foam.total() >= LEAST)
        .map(|(slot, &foam)| (order.index(slot), foam))
        .collect();
    (0..DROPS * foamy.len())
        .into_par_iter()
        .map(|i| {
            let (index, foam) = foamy[i % foamy.len()];
            drop_of(frame, spacing_world, index as usize, foam, (i / foamy.len()) as u64)
        })
        .collect()
}

fn drop_of(
    frame: &ParticleFrame,
    spacing_world: f32,
    index: usize,
    foam: Foaminess,
    number: u64,
) -> FoamDrop {
    let mut dice = Dice(frame.id(index).wrapping_mul(DROPS as u64).wrapping_add(number));
    let size = frame.size(index);
    // What is spray as well as trapped air looks like spray.
    let [cloud, radius, depth] = [0, 1, 2].map(|k| TRAPPED[k] + (SPRAY[k] - TRAPPED[k]) * foam.spray);
    // Denser in the middle: the cube root would spread them evenly over the ball.
    let reach = cloud * spacing_world * size * dice.roll().sqrt();
    let height = 2.0 * dice.roll() - 1.0;
    let (sine, cosine) = (std::f32::consts::TAU * dice.roll()).sin_cos();
    let across = (1.0 - height * height).sqrt();
    let center =
        Vec3::from(frame.positions[index]) + reach * Vec3::new(across * cosine, across * sine, height);
    let varied = 0.6 + 0.8 * dice.roll();
    FoamDrop::new(center.to_array(), radius * varied * size, depth * foam.total())
}

/// How many of `drops` are drawn where a `share` (0 to 1) of the detail is wanted: whole rounds of all particles, at least one.
pub fn prefix(drops: usize, share: f32) -> usize {
    drops / DROPS * rounds(share)
}

/// Factor on the radius of the drops of that prefix, which makes up in area for those left out.
pub fn widening(share: f32) -> f32 {
    (DROPS as f32 / rounds(share) as f32).sqrt()
}

fn rounds(share: f32) -> usize {
    ((share * DROPS as f32).ceil() as usize).clamp(1, DROPS)
}

/// Random numbers of one drop (Steele et al., SplitMix, 2014).
struct Dice(u64);

impl Dice {
    /// 0 up to, not including, 1.
    fn roll(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ x >> 31) >> 40) as f32 / (1u64 << 24) as f32
    }
}
