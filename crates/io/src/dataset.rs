//! A particle file as a list of pieces with arrays that are read on demand.

use std::path::Path;

use meniscus_core::Cancel;

use crate::array::DataArray;
use crate::format::{Format, legacy, parallel, xml};
use crate::mapped::MappedFile;
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
    pub file: MappedFile,
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
/// the end of the cell before it.
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
                let is_vertex = |types: &[f64]| types.iter().any(|ty| VERTEX_CELLS.contains(ty));
                // Particle files say so at once.
                let mut head = vec![0.0; types.len().min(1024)];
                types.decode(&ToF64, head.as_mut_slice(), cancel)?;
                Ok(types.len() > 0 && !is_vertex(&head) && !is_vertex(&types.collect(&ToF64, cancel)?))
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
        let values = |array: &DataArray| array.check(&self.file)?.collect(&ToU64, cancel);
        let mut mask = match self.point_ghosts() {
            Some(flags) => values(flags)?.into_iter().map(|flags| flags & GHOST_POINT == 0).collect(),
            None => vec![true; self.points],
        };
        let Some(cells) = &self.cell_ghosts else { return Ok(mask) };
        let (flags, points, ends) =
            (values(&cells.flags)?, values(&cells.connectivity)?, values(&cells.offsets)?);
        let (mut in_ghost, mut in_real) = (vec![false; self.points], vec![false; self.points]);
        let mut start = 0;
        for (flags, end) in std::iter::zip(flags, ends) {
            let marks = if flags & GHOST_CELL == 0 { &mut in_real } else { &mut in_ghost };
            // Offsets and points that are out of range belong to no particle.
            let end = usize::try_from(end).unwrap_or(usize::MAX).min(points.len());
            for point in points.get(start..end).unwrap_or_default() {
                if let Some(mark) = usize::try_from(*point).ok().and_then(|point| marks.get_mut(point)) {
                    *mark = true;
                }
            }
            start = end;
        }
        for (point, taken) in mask.iter_mut().enumerate() {
            *taken &= in_real[point] || !in_ghost[point];
        }
        Ok(mask)
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
        let file = MappedFile::open(path, mode)?;
        match Format::sniff(&file)? {
            Format::Legacy => legacy::parse(&file),
            Format::Xml => match xml::parse(&file)? {
                xml::Document::Dataset(dataset) => Ok(dataset),
                xml::Document::Parallel(sources) => parallel::open_pieces(&file, &sources, mode),
                xml::Document::Collection(_) => Err(Error::unsupported(
                    path,
                    "a .pvd collection inside another series; give it on its own",
                )),
            },
            Format::SeriesJson => {
                Err(Error::unsupported(path, "a .series file inside another series; give it on its own"))
            }
        }
    }
}
