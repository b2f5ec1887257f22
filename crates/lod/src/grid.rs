//! Cells of a few spacings along a space-filling curve: the order that puts neighbours next to each other, and the grid that finds
//! particles without neighbours.

use glam::{IVec3, UVec3, Vec3};
use rayon::prelude::*;

use crate::hilbert::Curve;

/// Edge of a cell in spacings. Two and a half: a lattice whose spacing is up to a quarter off still has two particles of
/// every row in every cell, so that a cell inside the fluid is never mistaken for one at its surface.
const CELL_SPACINGS: f32 = 2.5;

/// Positions looked at to place the grid.
const SAMPLES: usize = 4096;

/// The grid's origin moves in steps of this many cells, so that the cells of a series line up from frame to frame.
const ANCHOR_CELLS: f32 = 256.0;

/// Cubic cells around the bulk of a particle set. What lies beyond the outermost cell counts as in it, so that one escaped
/// particle does not coarsen the cells of all others.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    anchor: Vec3,
    edge: f32,
    bits: u32,
}

impl Grid {
    fn around(positions: &[[f32; 3]], spacing_world: f32, bits: u32) -> Self {
        let stride = positions.len().div_ceil(SAMPLES).max(1);
        let mut center = Vec3::ZERO;
        let mut extent = 0.0f32;
        for axis in 0..3 {
            let mut sample: Vec<f32> = positions.iter().step_by(stride).map(|p| p[axis]).collect();
            sample.sort_unstable_by(f32::total_cmp);
            let at = |fraction: f32| sample[((sample.len() - 1) as f32 * fraction) as usize];
            let (low, high) = if sample.is_empty() { (0.0, 0.0) } else { (at(0.01), at(0.99)) };
            center[axis] = low * 0.5 + high * 0.5;
            // Twice, because a splash reaches out of the bulk and the anchor is not at the centre.
            extent = extent.max((high - low) * 2.0);
        }
        let cells = (1u32 << bits) as f32;
        let wanted = spacing_world * CELL_SPACINGS;
        let mut edge = if wanted.is_normal() && wanted > 0.0 { wanted } else { extent / cells };
        // Doubled rather than stretched, so that the edge does not follow every change of the extent.
        while extent / edge > cells && edge < f32::MAX / ANCHOR_CELLS {
            edge *= 2.0;
        }
        if !edge.is_normal() {
            edge = 1.0;
        }
        let step = edge * ANCHOR_CELLS;
        let snapped = (center / step).round() * step;
        Self { anchor: if snapped.is_finite() { snapped } else { center }, edge, bits }
    }

    /// Position in cells from the grid's lowest corner. The anchor is a third up the grid: a third is never on a border,
    /// at any level of halving, so that the walls of a tank that starts at the origin, and the particles that leak by a hair
    /// through them, do not fall into chunks of their own that wrap the tank.
    fn in_cells(&self, position: Vec3) -> Vec3 {
        (position - self.anchor) / self.edge + (1u32 << self.bits) as f32 / 3.0
    }

    /// Edge of a cell, world units.
    pub(crate) fn edge_world(&self) -> f32 {
        self.edge
    }

    /// The cell that a position lies in.
    pub(crate) fn cell_of(&self, position: Vec3) -> UVec3 {
        self.cell(self.in_cells(position))
    }

    /// Place on the curve of a block of `2^coarser` cells a side, `None` outside of the grid.
    pub(crate) fn block_code(&self, block: IVec3, coarser: u32) -> Option<u64> {
        let bits = self.bits - coarser;
        let inside = block.cmpge(IVec3::ZERO).all() && block.max_element() < 1 << bits;
        inside.then(|| Curve::get().place(block.as_uvec3(), bits))
    }

    fn cell(&self, in_cells: Vec3) -> UVec3 {
        let last = (1u32 << self.bits) - 1;
        // The casts saturate, far positions included, and round down what is not negative.
        in_cells.as_uvec3().min(UVec3::splat(last))
    }

    /// The 2 x 2 x 2 cells whose common corner is nearest, the position's own first: they reach at least 1.25, at most 3.75
    /// spacings from the position along each axis, 2.5 on average. Cells outside the grid are left out.
    pub(crate) fn nearest_cells(&self, position: Vec3) -> impl Iterator<Item = UVec3> {
        let at = self.in_cells(position);
        let own = self.cell(at);
        let side = at - at.floor();
        let last = (1u32 << self.bits) - 1;
        (0..8u32).filter_map(move |corner| {
            let mut cell = own;
            for axis in 0..3 {
                if corner >> axis & 1 == 1 {
                    cell[axis] = if side[axis] < 0.5 { own[axis].checked_sub(1)? } else { own[axis] + 1 };
                }
            }
            (cell.max_element() <= last).then_some(cell)
        })
    }
}

/// The particles of a frame along a Hilbert curve: one word per particle, cell above, index below, sorted in place.
pub(crate) struct CellOrder {
    grid: Grid,
    index_bits: u32,
    words: Vec<u64>,
}

impl CellOrder {
    /// Sorts `positions` (world) by cell, equal cells by index. Independent of the number of threads: no two words agree.
    /// O(n log n), near O(n) where the file is in this order already; 8 bytes per particle.
    pub(crate) fn new(positions: &[[f32; 3]], spacing_world: f32) -> Self {
        let index_bits = (positions.len().max(2) - 1).ilog2() + 1;
        let bits = ((64 - index_bits) / 3).min(21);
        let grid = Grid::around(positions, spacing_world, bits);
        let curve = Curve::get();
        let mut words: Vec<u64> = positions
            .par_iter()
            .enumerate()
            .map(|(index, &p)| curve.place(grid.cell_of(p.into()), bits) << index_bits | index as u64)
            .collect();
        words.par_sort_unstable();
        Self { grid, index_bits, words }
    }

    /// Index in the frame of the particle at `slot` of the curve.
    pub(crate) fn index(&self, slot: usize) -> u32 {
        (self.words[slot] & ((1 << self.index_bits) - 1)) as u32
    }

    /// Number of particles.
    pub(crate) fn len(&self) -> usize {
        self.words.len()
    }

    /// The grid whose cells are ordered.
    pub(crate) fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Place on the curve of the cell of the particle at `slot`.
    pub(crate) fn cell_code(&self, slot: usize) -> u64 {
        self.words[slot] >> self.index_bits
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_points_stay_in_file_order() {
        let order = CellOrder::new(&[[3.0; 3]; 1000], 0.1);
        assert!((0..1000).all(|slot| order.index(slot) == slot as u32));
    }

    #[test]
    fn an_escaped_particle_does_not_coarsen_the_grid() {
        let mut positions: Vec<[f32; 3]> =
            (0..1000).map(|i| [i % 10, i / 10 % 10, i / 100].map(|c| c as f32)).collect();
        let edge = CellOrder::new(&positions, 1.0).grid.edge;
        assert_eq!(edge, CELL_SPACINGS);
        positions.push([1e30, -1e30, 0.0]);
        assert_eq!(CellOrder::new(&positions, 1.0).grid.edge, edge);
    }

    #[test]
    fn hopeless_spacings_still_give_an_order() {
        let positions: Vec<[f32; 3]> = (0..100).map(|i| [i as f32, 0.0, 0.0]).collect();
        for spacing in [0.0, -1.0, f32::NAN, f32::INFINITY, f32::MIN_POSITIVE, 1e30] {
            let order = CellOrder::new(&positions, spacing);
            let mut indices: Vec<u32> = (0..100).map(|slot| order.index(slot)).collect();
            indices.sort_unstable();
            assert_eq!(indices, (0..100).collect::<Vec<_>>(), "spacing {spacing}");
        }
    }
}
