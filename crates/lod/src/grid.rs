//! Cells of a few spacings along a space-filling curve: the order that puts neighbours next to each other, and the grid that finds
//! particles without neighbours.

use glam::{IVec3, UVec3, Vec3};
use rayon::prelude::*;

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
        inside.then(|| hilbert(block.as_uvec3(), bits))
    }

    fn cell(&self, in_cells: Vec3) -> UVec3 {
        let last = (1u32 << self.bits) - 1;
        // The casts saturate, far positions included.
        in_cells.floor().as_uvec3().min(UVec3::splat(last))
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

/// Place of a cell on the Hilbert curve through a cube of `2^bits` cells a side, `bits` at most 21 (Skilling, Programming
/// the Hilbert curve, AIP Conference Proceedings 707, 2004). Consecutive cells touch, so any run of the curve is compact.
fn hilbert(cell: UVec3, bits: u32) -> u64 {
    let mut x = cell.to_array();
    for bit in (1..bits).rev() {
        let below = (1u32 << bit) - 1;
        for axis in 0..3 {
            // Invert the first number's lower bits where the bit is set, else swap them with this axis's. In masks: a
            // branch would be mispredicted half the time.
            let set = (x[axis] >> bit & 1).wrapping_neg();
            let swap = (x[0] ^ x[axis]) & below & !set;
            x[0] ^= swap | below & set;
            x[axis] ^= swap;
        }
    }
    x[1] ^= x[0];
    x[2] ^= x[1];
    // Parity of the bits above each bit: a prefix sum modulo 2.
    let mut flip = x[2] >> 1;
    for shift in [1, 2, 4, 8, 16] {
        flip ^= flip >> shift;
    }
    interleave(x.map(|c| c ^ flip))
}

/// The low 21 bits of three numbers, bit by bit, the first number highest.
fn interleave(numbers: [u32; 3]) -> u64 {
    numbers.into_iter().fold(0, |code, number| {
        let mut x = u64::from(number) & 0x1f_ffff;
        x = (x | x << 32) & 0x001f_0000_0000_ffff;
        x = (x | x << 16) & 0x001f_0000_ff00_00ff;
        x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
        x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
        code << 1 | (x | x << 2) & 0x1249_2492_4924_9249
    })
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
        let mut words: Vec<u64> = positions
            .par_iter()
            .enumerate()
            .map(|(index, &p)| hilbert(grid.cell_of(p.into()), bits) << index_bits | index as u64)
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

    /// Ends of runs of at most `largest` particles. Each is cut, in its second half, where the curve crosses the largest
    /// cell border, so that boxes are compact and cuts stay in place while particles move.
    pub(crate) fn cuts(&self, largest: usize) -> Vec<usize> {
        let largest = largest.max(1);
        let mut cuts = Vec::with_capacity(self.words.len() / largest * 3 / 2 + 1);
        let mut start = 0;
        while start < self.words.len() {
            let end = if self.words.len() - start <= largest {
                self.words.len()
            } else {
                let crossed = |at: &usize| {
                    (self.cell_code(at - 1) ^ self.cell_code(*at)).checked_ilog2().map_or(0, |bit| bit + 1)
                };
                // The last of equals: the longest run.
                (start + largest.div_ceil(2)..=start + largest).max_by_key(crossed).unwrap_or(start + largest)
            };
            cuts.push(end);
            start = end;
        }
        cuts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_visits_every_cell_once_in_steps_of_one() {
        for bits in 1..=4 {
            let side = 1u32 << bits;
            let cell = |i: u32| UVec3::new(i % side, i / side % side, i / side / side);
            let mut curve: Vec<(u64, UVec3)> =
                (0..side.pow(3)).map(|i| (hilbert(cell(i), bits), cell(i))).collect();
            curve.sort_unstable_by_key(|at| at.0);
            assert!(curve.iter().map(|at| at.0).eq(0..u64::from(side.pow(3))));
            for pair in curve.windows(2) {
                let step = pair[0].1.as_ivec3() - pair[1].1.as_ivec3();
                assert_eq!(step.abs().element_sum(), 1, "{pair:?}");
            }
        }
        // The curve ends in the corner next to its start.
        let last = UVec3::new((1 << 21) - 1, 0, 0);
        assert_eq!(hilbert(last, 21), (1 << 63) - 1);
    }

    #[test]
    fn a_block_of_cells_is_a_run_of_the_curve() {
        let cell = UVec3::new(1234, 77, 4031);
        assert_eq!(hilbert(cell, 13) >> 9, hilbert(cell >> 3, 10));
    }

    #[test]
    fn cuts_are_within_half_and_the_whole_and_fall_on_the_largest_cell_border() {
        // 16 x 16 x 16 cells of one particle each, from the border of a block of 16: the origin lies in cell
        // 2^17 / 3 = 43690.67, and 43696 is divisible by 16.
        let positions: Vec<[f32; 3]> =
            (0..4096).map(|i| [i & 15, i >> 4 & 15, i >> 8].map(|c| c as f32 * 2.5 + 15.0)).collect();
        let order = CellOrder::new(&positions, 1.0);
        // Cubes of 8^3 = 512 cells are the largest that fit.
        assert_eq!(order.cuts(600), (1..=8).map(|i| i * 512).collect::<Vec<_>>());
        assert_eq!(CellOrder::new(&[], 1.0).cuts(600), Vec::<usize>::new());
    }

    #[test]
    fn equal_points_stay_in_file_order_in_full_runs() {
        let order = CellOrder::new(&[[3.0; 3]; 1000], 0.1);
        assert!((0..1000).all(|slot| order.index(slot) == slot as u32));
        assert_eq!(order.cuts(300), vec![300, 600, 900, 1000]);
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
