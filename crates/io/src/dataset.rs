//! A particle file as a list of pieces with arrays that are read on demand.

use std::path::Path;

use meniscus_core::Cancel;

use crate::array::{CheckedArray, DataArray};
use crate::format::{Opened, parallel};
use crate::input_file::InputFile;
use crate::scalar::{ToF64, ToU64};
use crate::{Error, IoMode};

/// What the cells of a piece say about its points.
#[derive(Clone, Debug)]
pub(crate) enum Cells {
    /// No cells, or vertex cells among them: particles.
    Particles,
    /// Only faces, lines or volumes.
    Mesh,
    /// To be found from the types of the cells.
    Types(DataArray),
}

/// Points with their attributes in one file.
#[derive(Clone)]
pub(crate) struct Piece {
    pub file: InputFile,
    pub points: usize,
    /// Three components, `points` tuples. `None` only without points.
    pub positions: Option<DataArray>,
    /// Each with `points` tuples.
    pub attributes: Vec<DataArray>,
    pub cells: Cells,
    /// Flags of the cells that mark ghosts.
    pub cell_ghosts: Option<CellGhosts>,
}

/// Ghost flags of cells, and which points the cells have: cell `c` those of `connectivity` before its end `offsets[c]`, from
/// the end of the cell before it. There are as many points in cells as there are cells.
#[derive(Clone, Debug)]
pub(crate) struct CellGhosts {
    pub flags: DataArray,
    pub connectivity: DataArray,
    pub offsets: DataArray,
}

/// The array that marks ghosts, and its bits: copies of another process' points or cells, and hidden ones
/// (`vtkDataSetAttributes::PointGhostTypes`, `CellGhostTypes`).
pub(crate) const GHOSTS: &str = "vtkGhostType";
const GHOST_POINT: u64 = 1 | 2;
const GHOST_CELL: u64 = 1 | 32;

/// Values looked at together.
const BLOCK: usize = 1 << 16;

/// VTK's numbers of cell types that hold single points.
const VERTEX_CELLS: [f64; 2] = [1.0, 2.0];

impl Piece {
    /// Whether the points are corners of a mesh, not particles.
    pub fn is_mesh(&self, cancel: &Cancel) -> Result<bool, Error> {
        match &self.cells {
            Cells::Particles => Ok(false),
            Cells::Mesh => Ok(true),
            Cells::Types(types) => {
                let types = types.check(&self.file)?;
                // Particle files say so at once.
                let mut start = 0;
                while start < types.tuples() {
                    let end = types.tuples().min(2 * start + 1024).min(start + BLOCK);
                    let block = types.tuples_in(start..end, &ToF64, cancel)?;
                    if block.iter().any(|ty| VERTEX_CELLS.contains(ty)) {
                        return Ok(false);
                    }
                    start = end;
                }
                Ok(types.tuples() > 0)
            }
        }
    }
}

impl Piece {
    fn point_ghosts(&self) -> Option<&DataArray> {
        self.attributes.iter().find(|a| a.name == GHOSTS && a.components == 1)
    }

    pub fn may_have_ghosts(&self) -> bool {
        self.point_ghosts().is_some() || self.cell_ghosts.is_some()
    }

    /// Which points are no ghosts: not marked themselves, and not only in cells that are.
    pub fn not_ghosts(&self, cancel: &Cancel) -> Result<Vec<bool>, Error> {
        let mut mask = vec![true; self.points];
        if let Some(flags) = self.point_ghosts() {
            let flags = flags.check(&self.file)?;
            for start in (0..self.points).step_by(BLOCK) {
                let end = self.points.min(start + BLOCK);
                let block = flags.tuples_in(start..end, &ToU64, cancel)?;
                std::iter::zip(&mut mask[start..end], block)
                    .for_each(|(taken, flags)| *taken = flags & GHOST_POINT == 0);
            }
        }
        if let Some(cells) = &self.cell_ghosts {
            self.mask_ghost_cells(cells, &mut mask, cancel)?;
        }
        Ok(mask)
    }

    fn mask_ghost_cells(&self, cells: &CellGhosts, mask: &mut [bool], cancel: &Cancel) -> Result<(), Error> {
        let (flags, points, ends) = (
            cells.flags.check(&self.file)?,
            cells.connectivity.check(&self.file)?,
            cells.offsets.check(&self.file)?,
        );
        let (mut in_ghost, mut in_real) = (vec![false; self.points], vec![false; self.points]);
        for first in (0..flags.tuples()).step_by(BLOCK) {
            let block = first..flags.tuples().min(first + BLOCK);
            let values = |array: &CheckedArray<'_>| array.tuples_in(block.clone(), &ToU64, cancel);
            let (flags, points, ends) = (values(&flags)?, values(&points)?, values(&ends)?);
            for (i, cell) in block.clone().enumerate() {
                // With as many points as cells, a cell of another number of points has those of others.
                let point = Some(points[i]).filter(|_| ends[i] == cell as u64 + 1);
                let marks = if flags[i] & GHOST_CELL == 0 { &mut in_real } else { &mut in_ghost };
                if let Some(mark) = point.and_then(|point| marks.get_mut(usize::try_from(point).ok()?)) {
                    *mark = true;
                }
            }
        }
        for (point, taken) in mask.iter_mut().enumerate() {
            *taken &= in_real[point] || !in_ghost[point];
        }
        Ok(())
    }
}

/// A particle file.
#[derive(Clone, Default)]
pub(crate) struct Dataset {
    pub pieces: Vec<Piece>,
    /// Simulation time stored in the file.
    pub time: Option<f64>,
}

impl Dataset {
    /// Finds the arrays of the file at `path`; follows the pieces of parallel files.
    pub fn open(path: &Path, mode: IoMode) -> Result<Self, Error> {
        match Opened::at(path, mode)? {
            Opened::Points(dataset) => Ok(dataset),
            Opened::Pieces(sources) => parallel::open_pieces(path, &sources, mode),
            Opened::Series => {
                Err(Error::unsupported(path, "a list of a series inside another series; give it on its own"))
            }
        }
    }
}
