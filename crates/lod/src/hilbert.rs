//! The Hilbert curve through a cube of cells. Consecutive cells touch, so any run of the curve is compact.

use std::sync::LazyLock;

use glam::UVec3;

/// Levels of halving that one step of the larger table takes.
const LEVELS: u32 = 2;

/// The curve of Skilling (Programming the Hilbert curve, AIP Conference Proceedings 707, 2004) as an automaton: the curve through an octant
/// is that through the cube, turned and mirrored in one of a few ways, which are the states. A place takes a look-up for every two levels,
/// which makes cutting a frame a fifth faster than Skilling's bit operations did (benches/RESULTS.md).
pub(crate) struct Curve {
    /// Of each state and octant: the octant's place in the state's curve in the low bits, above them the state inside of it.
    octants: Vec<[u16; 8]>,
    /// The same for two levels at once.
    pairs: Vec<[u16; 64]>,
}

impl Curve {
    /// The tables.
    pub(crate) fn get() -> &'static Self {
        static CURVE: LazyLock<Curve> = LazyLock::new(Curve::new);
        &CURVE
    }

    fn new() -> Self {
        // Ways to run through a cube, by the order of its octants; an example of a cell of each and its level.
        let mut states: Vec<([u16; 8], UVec3, u32)> = vec![(order_in(UVec3::ZERO, 0), UVec3::ZERO, 0)];
        let mut octants = Vec::new();
        while let Some(&(order, cell, level)) = states.get(octants.len()) {
            octants.push(std::array::from_fn(|octant| {
                let inner = child(cell, octant);
                let inner_order = order_in(inner, level + 1);
                let state =
                    states.iter().position(|(known, ..)| *known == inner_order).unwrap_or_else(|| {
                        states.push((inner_order, inner, level + 1));
                        states.len() - 1
                    });
                (state as u16) << 3 | order[octant]
            }));
        }
        let pairs = octants
            .iter()
            .map(|of_state: &[u16; 8]| {
                std::array::from_fn(|both| {
                    let outer = of_state[both >> 3];
                    let inner = octants[usize::from(outer >> 3)][both & 7];
                    (inner >> 3) << 6 | (outer & 7) << 3 | inner & 7
                })
            })
            .collect();
        Self { octants, pairs }
    }

    /// Place of a cell on the curve through a cube of `2^bits` cells a side, `bits` at most 21.
    pub(crate) fn place(&self, cell: UVec3, bits: u32) -> u64 {
        let path = interleave(cell.to_array());
        let mut level = bits;
        let (mut state, mut place) = (0, 0);
        if level % LEVELS == 1 {
            level -= 1;
            let step = self.octants[state][(path >> (3 * level)) as usize & 7];
            (state, place) = (usize::from(step >> 3), u64::from(step & 7));
        }
        while level > 0 {
            level -= LEVELS;
            let step = self.pairs[state][(path >> (3 * level)) as usize & 63];
            (state, place) = (usize::from(step >> 6), place << 6 | u64::from(step & 63));
        }
        place
    }
}

/// The cell's octant with this number, as [`interleave`] counts: the first axis in the highest bit.
fn child(cell: UVec3, octant: usize) -> UVec3 {
    cell * 2 + UVec3::from([2, 1, 0].map(|bit| octant as u32 >> bit & 1))
}

/// Places of the octants of a cell of this level in the curve through the cell.
fn order_in(cell: UVec3, level: u32) -> [u16; 8] {
    std::array::from_fn(|octant| (by_bits(child(cell, octant), level + 1) & 7) as u16)
}

/// Place of a cell on the curve, bit by bit (Skilling): what the tables are made from.
fn by_bits(cell: UVec3, bits: u32) -> u64 {
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_curve_visits_every_cell_once_in_steps_of_one() {
        for bits in 1..=4 {
            let side = 1u32 << bits;
            let cell = |i: u32| UVec3::new(i % side, i / side % side, i / side / side);
            let mut curve: Vec<(u64, UVec3)> =
                (0..side.pow(3)).map(|i| (place(cell(i), bits), cell(i))).collect();
            curve.sort_unstable_by_key(|at| at.0);
            assert!(curve.iter().map(|at| at.0).eq(0..u64::from(side.pow(3))));
            for pair in curve.windows(2) {
                let step = pair[0].1.as_ivec3() - pair[1].1.as_ivec3();
                assert_eq!(step.abs().element_sum(), 1, "{pair:?}");
            }
        }
        // The curve ends in the corner next to its start.
        let last = UVec3::new((1 << 21) - 1, 0, 0);
        assert_eq!(place(last, 21), (1 << 63) - 1);
    }

    #[test]
    fn a_block_of_cells_is_a_run_of_the_curve() {
        let cell = UVec3::new(1234, 77, 4031);
        assert_eq!(place(cell, 13) >> 9, place(cell >> 3, 10));
    }

    #[test]
    fn a_cube_is_run_through_in_as_many_ways_as_it_can_be_turned() {
        assert_eq!(Curve::get().octants.len(), 24);
    }

    proptest! {
        #[test]
        fn the_tables_are_the_curve(x: u32, y: u32, z: u32, bits in 1u32..=21) {
            let cell = UVec3::new(x, y, z) & UVec3::splat((1 << bits) - 1);
            prop_assert_eq!(place(cell, bits), by_bits(cell, bits));
        }
    }

    fn place(cell: UVec3, bits: u32) -> u64 {
        Curve::get().place(cell, bits)
    }
}
