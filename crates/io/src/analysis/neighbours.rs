//! Neighbours of a few sampled particles among many, in one pass over all of them.

use std::collections::HashMap;

use rayon::prelude::*;

/// Bits of the filter that tells in one look whether a cell is near no sample.
const FILTER_BITS: usize = 1 << 20;

type Cell = [i32; 3];

/// All particles in the cells around the samples.
pub(super) struct Neighbourhood {
    reach: f32,
    cells: HashMap<Cell, Vec<[f32; 3]>>,
}

fn cell_of(point: &[f32; 3], reach: f32) -> Cell {
    point.map(|c| (c / reach).floor() as i32)
}

/// Teschner et al. 2003, the usual spatial hash.
fn hash(cell: Cell) -> usize {
    let [x, y, z] = cell.map(|c| c as u32);
    let mixed = x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791);
    mixed as usize % FILTER_BITS
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
    /// Collects the particles of `points` within `reach` of any of `samples`, and some more.
    pub fn collect(points: &[[f32; 3]], samples: &[[f32; 3]], reach: f32) -> Self {
        let mut filter = vec![false; FILTER_BITS];
        let mut cells: HashMap<Cell, Vec<[f32; 3]>> = HashMap::new();
        for cell in samples.iter().flat_map(|sample| around(cell_of(sample, reach))) {
            filter[hash(cell)] = true;
            cells.entry(cell).or_default();
        }
        let near: Vec<(Cell, [f32; 3])> = points
            .par_iter()
            .filter_map(|point| {
                let cell = cell_of(point, reach);
                (filter[hash(cell)] && cells.contains_key(&cell)).then_some((cell, *point))
            })
            .collect();
        for (cell, point) in near {
            if let Some(members) = cells.get_mut(&cell) {
                members.push(point);
            }
        }
        Self { reach, cells }
    }

    /// Offsets from `sample` to the particles within `radius` (at most the reach), itself included.
    pub fn offsets(&self, sample: [f32; 3], radius: f32) -> impl Iterator<Item = [f32; 3]> + '_ {
        around(cell_of(&sample, self.reach))
            .filter_map(|cell| self.cells.get(&cell))
            .flatten()
            .map(move |point| std::array::from_fn(|axis| point[axis] - sample[axis]))
            .filter(move |offset: &[f32; 3]| offset.iter().map(|c| c * c).sum::<f32>() < radius * radius)
    }
}
