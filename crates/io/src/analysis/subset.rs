//! Some of many positions, without a copy of them.

use rayon::prelude::*;

/// Marks counted together.
const BLOCK: usize = 512;

/// Positions, of which all or those marked are meant; each has a rank among them.
pub(crate) struct Subset<'a> {
    positions: &'a [[f32; 3]],
    marks: Option<Marks>,
}

struct Marks {
    taken: Vec<bool>,
    /// How many are taken before each block, and of all.
    before: Vec<usize>,
}

impl<'a> Subset<'a> {
    /// All of `positions`.
    pub fn all(positions: &'a [[f32; 3]]) -> Self {
        Self { positions, marks: None }
    }

    /// Those of `positions` that `is_taken` is true for, given their index.
    pub fn those(positions: &'a [[f32; 3]], is_taken: impl Fn(usize) -> bool) -> Self {
        let taken: Vec<bool> = (0..positions.len()).map(is_taken).collect();
        let mut before = vec![0];
        for block in taken.chunks(BLOCK) {
            before.push(before[before.len() - 1] + block.iter().filter(|taken| **taken).count());
        }
        Self { positions, marks: Some(Marks { taken, before }) }
    }

    pub fn len(&self) -> usize {
        self.marks.as_ref().map_or(self.positions.len(), |marks| marks.before[marks.before.len() - 1])
    }

    /// The one of rank `rank`, less than [`Self::len`].
    pub fn get(&self, rank: usize) -> [f32; 3] {
        let Some(Marks { taken, before }) = &self.marks else { return self.positions[rank] };
        let block = before.partition_point(|&before| before <= rank) - 1;
        let marked = taken.iter().enumerate().skip(block * BLOCK).filter(|(_, taken)| **taken);
        let index = marked.map(|(index, _)| index).nth(rank - before[block]);
        self.positions[index.unwrap_or_default()]
    }

    pub fn iter(&self) -> impl Iterator<Item = [f32; 3]> + '_ {
        (0..self.positions.len()).filter(|i| self.has(*i)).map(|i| self.positions[i])
    }

    /// All of them in blocks: the tight loop that many positions need.
    pub fn par_blocks(&self) -> impl ParallelIterator<Item = impl Iterator<Item = [f32; 3]> + '_> + '_ {
        self.positions.par_chunks(BLOCK).enumerate().map(|(block, positions)| {
            let marks = self.marks.as_ref().map(|marks| &marks.taken[block * BLOCK..]);
            let is_in = move |(i, _): &(usize, &[f32; 3])| marks.is_none_or(|marks| marks[*i]);
            positions.iter().enumerate().filter(is_in).map(|(_, position)| *position)
        })
    }

    fn has(&self, index: usize) -> bool {
        self.marks.as_ref().is_none_or(|marks| marks.taken[index])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_those_of_a_copy() {
        let positions: Vec<[f32; 3]> = (0..5000).map(|i| [i as f32; 3]).collect();
        for is_taken in [|i: usize| i % 7 == 3, |i: usize| (900..2100).contains(&i), |_: usize| true] {
            let copy: Vec<[f32; 3]> = (0..5000).filter(|i| is_taken(*i)).map(|i| positions[i]).collect();
            let subset = Subset::those(&positions, is_taken);
            assert_eq!(subset.len(), copy.len());
            assert!((0..copy.len()).all(|rank| subset.get(rank) == copy[rank]));
            assert_eq!(subset.iter().collect::<Vec<_>>(), copy);
            assert_eq!(subset.par_blocks().flat_map_iter(|block| block).collect::<Vec<_>>(), copy);
        }
        assert_eq!(Subset::those(&positions, |_| false).len(), 0);
    }
}
