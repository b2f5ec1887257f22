//! Foam, spray and bubbles of data that has none of its own (`algorithms.md` 11): how foamy each particle is, and the drops that
//! are drawn for it. Found from one frame alone, whatever the camera, on the thread that read it.

mod air;
mod drops;
mod foaminess;
mod neighbours;

use meniscus_core::{Aabb, ParticleFrame, UpAxis};
use meniscus_gpu::role::FoamDrop;

pub use drops::{DROPS, prefix, widening};
pub use foaminess::Foaminess;

use crate::grid::CellOrder;

/// What foam is found by.
#[derive(Clone, Debug, PartialEq)]
pub struct FoamOptions {
    /// Name of the attribute with velocities, three numbers each. Without it (or where a frame does not have it) the number of
    /// neighbours alone decides.
    pub velocity: Option<String>,
    /// Speed at which neighbours run into each other in violent flow, the attribute's unit: what `closing` is counted in. Of 0 or
    /// what is no number, velocities do not count.
    pub speed: f32,
    /// Mean closing speed, in `speed`, at which foam begins and from which on all is foam.
    pub closing: [f32; 2],
    /// The axis against gravity: air comes from above.
    pub up: UpAxis,
    /// Walls that hold the water, world; infinite where there is none. Behind them there is no air. The bottom always holds it.
    pub walls: Aabb,
}

impl FoamOptions {
    /// Limits of the closing speed. A smooth flow that changes by `speed` over a water depth of at least 10 spacings stays
    /// below the first: neighbours at the mean weighted distance of 0.8 spacings differ by less than a tenth of it.
    pub const CLOSING: [f32; 2] = [0.1, 0.35];
}

/// How foamy each particle of `frame` is, in the frame's order.
pub fn foaminess(frame: &ParticleFrame, spacing_world: f32, options: &FoamOptions) -> Vec<Foaminess> {
    let order = CellOrder::new(&frame.positions, spacing_world);
    let mut found = vec![Foaminess::default(); frame.len()];
    for (slot, of_slot) in foaminess::of(&order, frame, spacing_world, options).into_iter().enumerate() {
        found[order.index(slot) as usize] = of_slot;
    }
    found
}

/// The drops of `frame`, whose particles `order` has sorted ([`prefix`] says in which order they come).
pub(crate) fn drops(
    order: &CellOrder,
    frame: &ParticleFrame,
    spacing_world: f32,
    options: &FoamOptions,
) -> Vec<FoamDrop> {
    drops::of(order, frame, spacing_world, &foaminess::of(order, frame, spacing_world, options))
}
