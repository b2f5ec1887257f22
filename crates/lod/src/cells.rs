//! What lies around each cell of the grid: which particles nothing in front of them can be seen through to, which have no
//! neighbours. Independent of any camera, so that it is found once per frame, on a reader thread.

use std::ops::Range;

use glam::{IVec3, UVec3, Vec3};
use meniscus_core::ParticleFrame;
use rayon::prelude::*;

use crate::grid::CellOrder;

/// Share of the particles that a cell inside the fluid has, from which a cell counts as full. Half: the cells around a
/// buried one then hold more than a layer of particles, whatever the surface's place in them.
const FULL: f32 = 0.51;

/// Bricks of 8 x 8 x 8 cells are runs of the curve; their neighbourhood fits the first-level cache.
const BRICK_BITS: u32 = 3;
const BRICK: i32 = 1 << BRICK_BITS;
/// Side of a brick with the cells around it.
const APRON: usize = BRICK as usize + 2;

/// A cell that holds particles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    /// Place on the curve.
    pub(crate) code: u64,
    /// Its first particle's slot; the next cell's is its end.
    pub(crate) first_slot: u32,
    /// Whether it and the 26 cells around it are full: its particles then cannot be seen from outside of the fluid, but
    /// through cracks.
    pub(crate) is_buried: bool,
    /// Sum of the directions to the cells around it that are not full.
    pub(crate) outward: [i8; 3],
}

/// The cells of a frame along the curve.
pub(crate) struct Cells {
    pub(crate) cells: Vec<Cell>,
    /// Slots of the isolated particles, rising.
    pub(crate) isolated: Vec<u32>,
}

/// A run of cells.
struct Brick {
    code: u64,
    at: IVec3,
    first_cell: u32,
}

/// Where a cell is in its brick, and what it holds.
#[derive(Clone, Copy)]
struct Content {
    local: [u8; 3],
    is_full: bool,
    count: u16,
}

impl Cells {
    /// The cells of `order` of `frame`. A particle is isolated that has fewer than `isolated_below` others in the eight cells
    /// nearest to it, which cells need few particles larger than about three times the set's own size for; a cell is full by
    /// the volume of its particles, and where they are larger than the cell, those without a centre are not. Large particles
    /// are so at worst taken for isolated and for shell, which only costs speed. Deterministic for any number of threads; O(n), and at most 40 bytes per
    /// particle beside its result, a tenth of that in the bulk.
    pub(crate) fn of(
        order: &CellOrder,
        frame: &ParticleFrame,
        spacing_world: f32,
        isolated_below: u16,
    ) -> Self {
        let grid = order.grid();
        let begins_cell = |slot: &usize| *slot == 0 || order.cell_code(slot - 1) != order.cell_code(*slot);
        let cells: Vec<Cell> = (0..order.len())
            .into_par_iter()
            .filter(begins_cell)
            .map(|slot| Cell {
                code: order.cell_code(slot),
                first_slot: slot as u32,
                is_buried: false,
                outward: [0; 3],
            })
            .collect();
        let end_of = |cell: usize| cells.get(cell + 1).map_or(order.len(), |next| next.first_slot as usize);
        let position = |slot: usize| Vec3::from(frame.positions[order.index(slot) as usize]);
        // In particles of the set's own size.
        let volume = |slots: Range<usize>| -> f32 {
            if frame.sizes.is_empty() {
                return slots.len() as f32;
            }
            slots.map(|slot| frame.size(order.index(slot) as usize).powi(3)).sum()
        };
        let expected = (grid.edge_world() / spacing_world).powi(3);
        // A spacing that is no length finds no cell full, which only costs speed.
        let full_from = (FULL * expected).round().clamp(1.0, f32::from(u16::MAX));
        let contents: Vec<Content> = cells
            .par_iter()
            .enumerate()
            .map(|(index, cell)| {
                let slots = cell.first_slot as usize..end_of(index);
                let local = grid.cell_of(position(slots.start)) & UVec3::splat(BRICK as u32 - 1);
                Content {
                    local: local.to_array().map(|c| c as u8),
                    is_full: volume(slots.clone()) >= full_from,
                    count: slots.len().min(usize::from(u16::MAX)) as u16,
                }
            })
            .collect();
        let mut bricks: Vec<Brick> = Vec::new();
        for (index, cell) in cells.iter().enumerate() {
            let code = cell.code >> (3 * BRICK_BITS);
            if bricks.last().is_none_or(|last| last.code != code) {
                let at = grid.cell_of(position(cell.first_slot as usize)).as_ivec3() >> BRICK_BITS as i32;
                bricks.push(Brick { code, at, first_cell: index as u32 });
            }
        }

        let cells_of = |brick: usize| {
            let end = bricks.get(brick + 1).map_or(cells.len(), |next| next.first_cell as usize);
            bricks[brick].first_cell as usize..end
        };
        let around = |brick: &Brick| {
            let mut apron = Apron::default();
            for offset in neighbours() {
                let Some(code) = grid.block_code(brick.at + offset, BRICK_BITS) else { continue };
                let Ok(found) = bricks.binary_search_by_key(&code, |other| other.code) else { continue };
                contents[cells_of(found)].iter().for_each(|content| apron.add(offset, content));
            }
            apron
        };
        let surroundings: Vec<(Vec<Cell>, Vec<u32>)> = (0..bricks.len())
            .into_par_iter()
            .map(|brick| {
                let apron = around(&bricks[brick]);
                let mut isolated = Vec::new();
                let cells = cells_of(brick).map(|index| {
                    let (cell, content) = (cells[index], contents[index]);
                    if content.count <= isolated_below {
                        let corner = bricks[brick].at << BRICK_BITS as i32;
                        let slots = cell.first_slot as usize..end_of(index);
                        isolated.extend(slots.map(|slot| slot as u32).filter(|&slot| {
                            let near = grid.nearest_cells(position(slot as usize));
                            let held = near.map(|at| u32::from(apron.count(at.as_ivec3() - corner)));
                            held.sum::<u32>() <= u32::from(isolated_below)
                        }));
                    }
                    let (is_buried, outward) = apron.surroundings(content.local);
                    Cell { is_buried, outward, ..cell }
                });
                (cells.collect(), isolated)
            })
            .collect();
        let mut found = Self { cells: Vec::with_capacity(cells.len()), isolated: Vec::new() };
        for (cells, isolated) in surroundings {
            found.cells.extend(cells);
            found.isolated.extend(isolated);
        }
        found
    }

    /// Ends of runs of at most `largest` particles. Each is cut, in its second half, where the curve crosses the largest
    /// cell border, so that boxes are compact and cuts stay in place while particles move.
    pub(crate) fn cuts(&self, particles: usize, largest: usize) -> Vec<usize> {
        let largest = largest.max(1);
        let begins = |cell: usize| self.cells.get(cell).map(|cell| cell.first_slot as usize);
        let crossed = |cell: &usize| (self.cells[cell - 1].code ^ self.cells[*cell].code).ilog2();
        // The first cell from `cell` on that begins at `slot` or behind it.
        let from_slot = |cell: usize, slot: usize| {
            cell + (cell..).take_while(|&cell| begins(cell).is_some_and(|begin| begin < slot)).count()
        };
        let mut cuts = Vec::with_capacity(particles / largest * 3 / 2 + 1);
        let (mut start, mut cell) = (0, 0);
        while particles - start > largest {
            let first = from_slot(cell, start + largest.div_ceil(2));
            let end = from_slot(first, start + largest + 1);
            // The last of equals: the longest run.
            let border = (first.max(1)..end).max_by_key(crossed);
            start = border.and_then(begins).unwrap_or(start + largest);
            cell = border.unwrap_or(end);
            cuts.push(start);
        }
        if start < particles {
            cuts.push(particles);
        }
        cuts
    }

    /// The isolated among the particles of `slots`, counted from the first of them.
    pub(crate) fn isolated_in(&self, slots: Range<usize>) -> impl Iterator<Item = usize> {
        let first = self.isolated.partition_point(|&slot| (slot as usize) < slots.start);
        let in_range = self.isolated[first..].iter().map(|&slot| slot as usize);
        in_range.take_while(move |slot| *slot < slots.end).map(move |slot| slot - slots.start)
    }

    /// The cells that hold the particles of `slots`, each with those of its slots that are among them, counted from the first.
    pub(crate) fn in_slots(&self, slots: Range<usize>) -> impl Iterator<Item = (&Cell, Range<usize>)> {
        let first = self.cells.partition_point(|cell| cell.first_slot as usize <= slots.start) - 1;
        let start = slots.start;
        self.cells[first..]
            .iter()
            .enumerate()
            .take_while({
                let end = slots.end;
                move |(_, cell)| (cell.first_slot as usize) < end
            })
            .map(move |(index, cell)| {
                let next = self.cells.get(first + index + 1);
                let end = next.map_or(slots.end, |next| (next.first_slot as usize).min(slots.end));
                (cell, (cell.first_slot as usize).max(start) - start..end - start)
            })
    }
}

/// The offsets of a cell or brick and the 26 around it.
fn neighbours() -> impl Iterator<Item = IVec3> {
    (-1..=1).flat_map(|z| (-1..=1).flat_map(move |y| (-1..=1).map(move |x| IVec3::new(x, y, z))))
}

/// What a brick's cells and those around it hold.
struct Apron {
    counts: [u16; APRON * APRON * APRON],
    are_full: [bool; APRON * APRON * APRON],
}

impl Default for Apron {
    fn default() -> Self {
        Self { counts: [0; APRON * APRON * APRON], are_full: [false; APRON * APRON * APRON] }
    }
}

impl Apron {
    /// Place of a cell counted from the brick's lowest, -1 to 8 along each axis.
    fn place(at: IVec3) -> Option<usize> {
        let shifted = at + 1;
        let inside = shifted.cmpge(IVec3::ZERO).all() && shifted.max_element() < APRON as i32;
        inside.then(|| (shifted.x + APRON as i32 * (shifted.y + APRON as i32 * shifted.z)) as usize)
    }

    fn add(&mut self, brick_offset: IVec3, content: &Content) {
        let local = IVec3::from(content.local.map(i32::from));
        if let Some(place) = Self::place(local + brick_offset * BRICK) {
            self.counts[place] = content.count;
            self.are_full[place] = content.is_full;
        }
    }

    fn count(&self, at: IVec3) -> u16 {
        Self::place(at).map_or(0, |place| self.counts[place])
    }

    fn is_full(&self, at: IVec3) -> bool {
        Self::place(at).is_some_and(|place| self.are_full[place])
    }

    /// Whether the cell and all around it are full, and the sum of the directions to those that are not.
    fn surroundings(&self, local: [u8; 3]) -> (bool, [i8; 3]) {
        let at = IVec3::from(local.map(i32::from));
        let mut open = 0;
        let mut outward = IVec3::ZERO;
        for offset in neighbours() {
            if !self.is_full(at + offset) {
                open += 1;
                outward += offset;
            }
        }
        (open == 0, outward.to_array().map(|c| c as i8))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cuts(positions: Vec<[f32; 3]>, spacing: f32, largest: usize) -> Vec<usize> {
        let order = CellOrder::new(&positions, spacing);
        let frame = ParticleFrame { positions, ..Default::default() };
        Cells::of(&order, &frame, spacing, 4).cuts(frame.len(), largest)
    }

    #[test]
    fn cuts_are_within_half_and_the_whole_and_fall_on_the_largest_cell_border() {
        // 16 x 16 x 16 cells of one particle each, from the border of a block of 16: the origin lies in cell
        // 2^17 / 3 = 43690.67, and 43696 is divisible by 16.
        let positions: Vec<[f32; 3]> =
            (0..4096).map(|i| [i & 15, i >> 4 & 15, i >> 8].map(|c| c as f32 * 2.5 + 15.0)).collect();
        // Cubes of 8^3 = 512 cells are the largest that fit.
        assert_eq!(cuts(positions, 1.0, 600), (1..=8).map(|i| i * 512).collect::<Vec<_>>());
        assert_eq!(cuts(vec![], 1.0, 600), Vec::<usize>::new());
    }

    #[test]
    fn equal_points_make_full_runs() {
        assert_eq!(cuts(vec![[3.0; 3]; 1000], 0.1, 300), vec![300, 600, 900, 1000]);
    }

    #[test]
    fn cuts_are_those_of_looking_at_every_particle() {
        // Cells of very different numbers of particles.
        let at = |i: usize| ((i * i * 7919) % 1009) as f32 / 1009.0;
        let positions: Vec<[f32; 3]> =
            (0..3000).map(|i| [at(i).powi(6), at(i + 1).powi(3), at(i + 2)].map(|c| 40.0 * c)).collect();
        let order = CellOrder::new(&positions, 1.0);
        for largest in [1, 2, 7, 64, 512, 2999, 3000] {
            let (mut expected, mut start) = (Vec::new(), 0);
            while positions.len() - start > largest {
                let crossed = |at: &usize| {
                    (order.cell_code(at - 1) ^ order.cell_code(*at)).checked_ilog2().map_or(0, |bit| bit + 1)
                };
                start = (start + largest.div_ceil(2)..=start + largest).max_by_key(crossed).unwrap();
                expected.push(start);
            }
            expected.push(positions.len());
            assert_eq!(cuts(positions.clone(), 1.0, largest), expected, "{largest}");
        }
    }
}
