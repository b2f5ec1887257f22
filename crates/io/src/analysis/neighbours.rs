//! Neighbours of a few sampled particles among many, in one pass over all of them.

use std::cmp::Ordering;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use rayon::prelude::*;

use super::subset::Subset;

/// Bits of the filter that tells in one look that a cell is near no sample.
const FILTER_BITS: u64 = 1 << 20;

/// Particles in a cell beyond which equal ones count once: a hundred times those of a liquid, and every sample near them
/// would look at each.
const PILE: usize = 4096;

type Cell = [i32; 3];

/// The spatial hash of Teschner et al. 2003 with its bits mixed, because the standard map looks at the highest ones.
#[derive(Default)]
struct CellHasher(u64);

impl Hasher for CellHasher {
    fn finish(&self) -> u64 {
        (self.0 ^ self.0 >> 29).wrapping_mul(0x9e37_79b9_7f4a_7c15)
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.write_i32(byte.into()));
    }

    fn write_i32(&mut self, value: i32) {
        self.0 = (self.0 ^ u64::from(value as u32)).wrapping_mul(73_856_093).rotate_left(21);
    }

    fn write_usize(&mut self, _length: usize) {}
}

/// All particles in the cells around the samples.
pub(super) struct Neighbourhood {
    reach: f32,
    index: HashMap<Cell, u32, BuildHasherDefault<CellHasher>>,
    members: Vec<Vec<[f32; 3]>>,
}

fn cell_of(point: &[f32; 3], reach: f32) -> Cell {
    point.map(|c| (c / reach).floor() as i32)
}

fn filter_bit(cell: Cell) -> usize {
    let [x, y, z] = cell.map(|c| c as u32 as u64);
    let mixed = x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791);
    (mixed % FILTER_BITS) as usize
}

fn around(cell: Cell) -> impl Iterator<Item = Cell> {
    (-1..=1).flat_map(move |z| {
        (-1..=1).flat_map(move |y| {
            (-1..=1).map(move |x| {
                [cell[0].saturating_add(x), cell[1].saturating_add(y), cell[2].saturating_add(z)]
            })
        })
    })
}

impl Neighbourhood {
    /// Collects the particles of `points` within `reach` of any of `samples`, and some more. Where very many share a cell,
    /// those at the same place count once.
    pub fn collect(points: &Subset<'_>, samples: &[[f32; 3]], reach: f32) -> Self {
        let mut filter = vec![false; FILTER_BITS as usize];
        let mut index = HashMap::default();
        for cell in samples.iter().flat_map(|sample| around(cell_of(sample, reach))) {
            filter[filter_bit(cell)] = true;
            let next = index.len() as u32;
            index.entry(cell).or_insert(next);
        }
        // In lists as they come: put together, they would be in memory twice.
        let near: Vec<Vec<(u32, [f32; 3])>> = points
            .par_blocks()
            .fold(Vec::new, |mut list, block| {
                for point in block {
                    let cell = cell_of(&point, reach);
                    if filter[filter_bit(cell)]
                        && let Some(&cell) = index.get(&cell)
                    {
                        list.push((cell, point));
                    }
                }
                list
            })
            .collect();
        let mut members = vec![Vec::new(); index.len()];
        for (cell, point) in near.into_iter().flatten() {
            members[cell as usize].push(point);
        }
        for pile in members.iter_mut().filter(|members| members.len() > PILE) {
            pile.sort_unstable_by(|a, b| {
                a.iter()
                    .zip(b)
                    .map(|(a, b)| a.total_cmp(b))
                    .find(|order| order.is_ne())
                    .unwrap_or(Ordering::Equal)
            });
            pile.dedup();
        }
        Self { reach, index, members }
    }

    /// Offsets from `sample` to the particles within `radius` (at most the reach), itself included.
    pub fn offsets(&self, sample: [f32; 3], radius: f32) -> impl Iterator<Item = [f32; 3]> + '_ {
        around(cell_of(&sample, self.reach))
            .filter_map(|cell| self.index.get(&cell))
            .flat_map(|&cell| &self.members[cell as usize])
            .map(move |point| std::array::from_fn(|axis| point[axis] - sample[axis]))
            .filter(move |offset: &[f32; 3]| offset.iter().map(|c| c * c).sum::<f32>() < radius * radius)
    }
}
