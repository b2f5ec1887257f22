//! Where there is air: what is empty and open to the sky, or to a side where no wall holds the water back. A body that has pushed
//! the water aside leaves an empty place, too, but a closed one.

use glam::{IVec3, UVec3};

/// A cell with no more particles than this, where the bulk has 16, is empty but for spray. The wake of a body is thinner than the
/// bulk, but no way for air.
const SPRAY_IN_A_CELL: usize = 1;
/// Most cells of the box around the water, in memory and in time; a larger box is looked at in coarser blocks.
const MOST_CELLS: u64 = 1 << 24;

/// The empty cells that the sky is reached from, within the box around the water.
pub(super) struct Air {
    low: IVec3,
    size: UVec3,
    up: usize,
    /// Whether there is a wall at the low and the high side of each axis.
    walls: [[bool; 2]; 3],
    /// Blocks have `2^shift` cells a side.
    shift: u32,
    is_open: Vec<bool>,
}

impl Air {
    /// `cells`: place and number of particles of the cells that have some; `up`: the axis against gravity; `held`: the cells in
    /// which walls stand, where water that ends next to them is held.
    pub(super) fn new(cells: impl Iterator<Item = (IVec3, usize)>, up: usize, held: [IVec3; 2]) -> Self {
        let filled: Vec<IVec3> =
            cells.filter(|(_, count)| *count > SPRAY_IN_A_CELL).map(|(at, _)| at).collect();
        let low = filled.iter().fold(IVec3::MAX, |low, at| low.min(*at));
        let high = filled.iter().fold(IVec3::MIN, |high, at| high.max(*at));
        if filled.is_empty() {
            let (low, size) = (IVec3::ZERO, UVec3::ZERO);
            return Self { low, size, up, walls: Default::default(), shift: 0, is_open: Vec::new() };
        }
        let [from, to] = held;
        let walls = std::array::from_fn(|axis| {
            if axis == up { [true, false] } else { [low[axis] <= from[axis] + 1, high[axis] >= to[axis] - 1] }
        });
        let blocks = |shift: u32| (((high - low) >> shift) + 1).as_uvec3();
        let is_small =
            |shift: &u32| blocks(*shift).to_array().map(u64::from).iter().product::<u64>() <= MOST_CELLS;
        let shift = (0..31).find(is_small).unwrap_or(31);
        let size = blocks(shift);
        let mut air = Self { low, size, up, walls, shift, is_open: Vec::new() };
        let mut is_filled = vec![false; size.to_array().map(|n| n as usize).iter().product()];
        for at in filled {
            is_filled[air.place(((at - low) >> shift).as_uvec3())] = true;
        }
        air.flood(&is_filled);
        air
    }

    fn place(&self, block: UVec3) -> usize {
        let [x, y, z] = block.to_array().map(|c| c as usize);
        x + self.size.x as usize * (y + self.size.y as usize * z)
    }

    /// Opens all that is not filled and touches the top or an open side, or what touches that; but nothing in the outermost layer
    /// at walls, which water fills in part.
    fn flood(&mut self, is_filled: &[bool]) {
        self.is_open = vec![false; is_filled.len()];
        let mut edge = Vec::new();
        for axis in 0..3 {
            let [across, along] = [1, 2].map(|turn| (axis + turn) % 3);
            for (side, _) in self.walls[axis].into_iter().enumerate().filter(|(_, is_wall)| !is_wall) {
                for i in 0..self.size[across] * self.size[along] {
                    let mut block = UVec3::ZERO;
                    block[axis] = side as u32 * (self.size[axis] - 1);
                    (block[across], block[along]) = (i % self.size[across], i / self.size[across]);
                    self.open(block, is_filled, &mut edge);
                }
            }
        }
        while let Some(block) = edge.pop() {
            for axis in 0..3 {
                for side in [block[axis].wrapping_sub(1), block[axis] + 1] {
                    let mut next = block;
                    next[axis] = side;
                    if side < self.size[axis] {
                        self.open(next, is_filled, &mut edge);
                    }
                }
            }
        }
    }

    fn open(&mut self, block: UVec3, is_filled: &[bool], edge: &mut Vec<UVec3>) {
        let place = self.place(block);
        let is_at_wall =
            (0..3).any(|axis| block[axis] == 0 || axis != self.up && block[axis] + 1 == self.size[axis]);
        if is_at_wall {
            return;
        }
        if !is_filled[place] && !std::mem::replace(&mut self.is_open[place], true) {
            edge.push(block);
        }
    }

    /// Whether there is air in a cell.
    pub(super) fn is_in(&self, cell: IVec3) -> bool {
        let block = (cell - self.low) >> self.shift;
        let size = self.size.as_ivec3();
        if block[self.up] >= size[self.up] {
            return true;
        }
        for axis in 0..3 {
            let outside = [block[axis] < 0, block[axis] >= size[axis]];
            if let Some(side) = outside.iter().position(|&is_outside| is_outside) {
                return !self.walls[axis][side];
            }
        }
        self.is_open[self.place(block.as_uvec3())]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Water of 9 x 9 x 6 cells with a shaft of 1 cell from the top down to 2, a hollow that the shaft does not reach, and spray.
    #[test]
    fn air_comes_from_above_and_into_no_closed_hollow() {
        let (shaft, hollow) = (IVec3::new(2, 2, 2), IVec3::new(6, 6, 3));
        // At one wall there is a gap as wide as a cell.
        let is_empty = |at: IVec3| {
            at == hollow || at.x == 0 && at.y > 0 || at.x == shaft.x && at.y == shaft.y && at.z >= shaft.z
        };
        let all = (0..9 * 9 * 6).map(|i| IVec3::new(i % 9, i / 9 % 9, i / 81));
        let water = all.filter(|at| !is_empty(*at)).map(|at| (at, 16));
        let spray = [(IVec3::new(2, 2, 4), 1), (IVec3::new(40, 1, 20), 1)];
        let air = Air::new(water.chain(spray), 2, [IVec3::splat(-1), IVec3::new(9, 20, 9)]);
        assert!(air.is_in(shaft) && air.is_in(IVec3::new(2, 2, 4)) && air.is_in(IVec3::new(4, 4, 6)));
        assert!(!air.is_in(hollow) && !air.is_in(IVec3::new(4, 4, 3)));
        // Beyond walls and floor; one side is open.
        assert!(air.is_in(IVec3::new(4, 9, 3)));
        assert!(
            !air.is_in(IVec3::new(-1, 4, 3))
                && !air.is_in(IVec3::new(9, 4, 3))
                && !air.is_in(IVec3::new(4, 4, -1))
        );
    }

    #[test]
    fn a_box_of_any_size_is_looked_at() {
        let far = IVec3::new(1 << 20, 1 << 20, 1 << 20);
        let air = Air::new([(IVec3::ZERO, 9), (far, 9)].into_iter(), 1, [IVec3::ZERO, far]);
        assert!(air.is_open.len() as u64 <= MOST_CELLS && air.is_in(far / 2));
        assert!(Air::new([(IVec3::ONE, 1)].into_iter(), 1, [IVec3::ZERO; 2]).is_in(IVec3::ONE));
    }
}
