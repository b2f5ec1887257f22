//! The particles around a particle, out of the cells of the grid.

use std::collections::HashMap;
use std::ops::Range;

use glam::{IVec3, Vec3};
use meniscus_core::ParticleFrame;
use rayon::prelude::*;

use crate::grid::CellOrder;

/// Most particles of a cell that are looked at, spread over it: four times what the bulk has. Data in which all particles are
/// in one place would take forever otherwise.
const MOST_OF_A_CELL: usize = 64;

/// Particles along the curve, with the cells they are in.
pub(super) struct Neighbours {
    positions: Vec<Vec3>,
    /// Of all particles, or of none.
    velocities: Vec<Vec3>,
    /// Where each cell is, and its first slot.
    cells: Vec<(IVec3, usize)>,
    by_place: HashMap<IVec3, u32>,
}

/// Particles that may be near those of one cell, coordinate by coordinate so that distances are found several at a time.
#[derive(Default)]
pub(super) struct Candidates {
    slots: Vec<usize>,
    positions: [Vec<f32>; 3],
    squares: Vec<f32>,
}

impl Neighbours {
    pub(super) fn new(order: &CellOrder, frame: &ParticleFrame, velocity: Option<&[f32]>) -> Self {
        let slots = || (0..order.len()).into_par_iter();
        let of_slot = |values: &[f32], slot: usize| {
            let first = 3 * order.index(slot) as usize;
            Vec3::from_slice(&values[first..first + 3])
        };
        let positions: Vec<Vec3> =
            slots().map(|slot| frame.positions[order.index(slot) as usize].into()).collect();
        let velocities =
            velocity.map_or_else(Vec::new, |values| slots().map(|slot| of_slot(values, slot)).collect());
        let mut cells = Vec::new();
        let mut last_code = None;
        for (slot, &position) in positions.iter().enumerate() {
            let code = order.cell_code(slot);
            if last_code != Some(code) {
                cells.push((order.grid().cell_of(position).as_ivec3(), slot));
                last_code = Some(code);
            }
        }
        let by_place = cells.iter().enumerate().map(|(index, &(at, _))| (at, index as u32)).collect();
        Self { positions, velocities, cells, by_place }
    }

    /// The cells that hold particles: where they are, and how many they hold.
    pub(super) fn cells(&self) -> impl ExactSizeIterator<Item = (IVec3, usize)> {
        self.cells.iter().enumerate().map(|(cell, &(at, _))| (at, self.slots_of(cell).len()))
    }

    pub(super) fn place_of(&self, cell: usize) -> IVec3 {
        self.cells[cell].0
    }

    pub(super) fn slots_of(&self, cell: usize) -> Range<usize> {
        self.cells[cell].1..self.cells.get(cell + 1).map_or(self.positions.len(), |next| next.1)
    }

    pub(super) fn velocity(&self, slot: usize) -> Vec3 {
        self.velocities[slot]
    }

    pub(super) fn position(&self, slot: usize) -> Vec3 {
        self.positions[slot]
    }

    /// Gathers what may be near the particles of `cell`: those of it and of the 26 cells around it.
    pub(super) fn around(&self, cell: usize, candidates: &mut Candidates) {
        let Candidates { slots, positions, .. } = candidates;
        slots.clear();
        positions.iter_mut().for_each(Vec::clear);
        let at = self.cells[cell].0;
        for offset in (0..27).map(|k| IVec3::new(k % 3, k / 3 % 3, k / 9) - 1) {
            let Some(&found) = self.by_place.get(&(at + offset)) else { continue };
            let of_cell = self.slots_of(found as usize);
            let step = of_cell.len().div_ceil(MOST_OF_A_CELL);
            slots.extend(of_cell.step_by(step));
        }
        for (axis, coordinates) in positions.iter_mut().enumerate() {
            coordinates.extend(slots.iter().map(|&slot| self.positions[slot][axis]));
        }
    }
}

impl Candidates {
    /// Calls `look` with slot and squared distance of each candidate within `reach` of `position`, but not of `slot`, which is there.
    pub(super) fn near(&mut self, slot: usize, position: Vec3, reach: f32, mut look: impl FnMut(usize, f32)) {
        let [xs, ys, zs] = &self.positions;
        self.squares.clear();
        self.squares.extend(std::iter::zip(xs, std::iter::zip(ys, zs)).map(|(x, (y, z))| {
            let (dx, dy, dz) = (x - position.x, y - position.y, z - position.z);
            dx * dx + dy * dy + dz * dz
        }));
        let within = reach * reach;
        for (&other, &square) in std::iter::zip(&self.slots, &self.squares) {
            if square < within && other != slot {
                look(other, square);
            }
        }
    }
}
