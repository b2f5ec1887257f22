//! A particle file as a list of pieces with arrays that are read on demand.

use std::path::Path;

use meniscus_core::Cancel;

use crate::Error;
use crate::array::DataArray;
use crate::format::{Format, legacy, parallel, xml};
use crate::mapped::MappedFile;
use crate::scalar::ToF64;

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
}

/// VTK's numbers of cell types that hold single points.
const VERTEX_CELLS: [f64; 2] = [1.0, 2.0];

impl Piece {
    /// Whether the points are corners of a mesh, not particles.
    pub fn is_mesh(&self, cancel: &Cancel) -> Result<bool, Error> {
        match &self.cells {
            Cells::Particles => Ok(false),
            Cells::Mesh => Ok(true),
            Cells::Types(types) => {
                let types = types.check(&self.file)?.collect(&ToF64, cancel)?;
                Ok(!types.is_empty() && !types.iter().any(|ty| VERTEX_CELLS.contains(ty)))
            }
        }
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
    pub fn open(path: &Path) -> Result<Self, Error> {
        let file = MappedFile::open(path)?;
        match Format::sniff(&file)? {
            Format::Legacy => legacy::parse(&file),
            Format::Xml => match xml::parse(&file)? {
                xml::Document::Dataset(dataset) => Ok(dataset),
                xml::Document::Parallel(sources) => parallel::open_pieces(&file, &sources),
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
