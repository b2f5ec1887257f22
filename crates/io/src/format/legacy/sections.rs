use meniscus_core::Cancel;

use super::cursor::Cursor;
use super::grid::Grid;
use crate::Error;
use crate::array::{Content, DataArray};
use crate::dataset::{Cells, Dataset, Piece};
use crate::scalar::{ScalarType, ToF64};

/// Letters of data that are shown where a keyword was expected.
const MAX_QUOTED: usize = 24;

/// What the attribute sections that follow belong to.
#[derive(Clone, Copy, PartialEq)]
enum Owner {
    /// The whole data set.
    Dataset,
    /// Points, with their number.
    Points(usize),
    /// Cells, with their number.
    Cells(usize),
}

/// The walk over the sections of a legacy file and what it has found.
pub(super) struct Sections<'a> {
    cursor: Cursor<'a>,
    owner: Owner,
    points: Option<DataArray>,
    grid: Grid,
    attributes: Vec<DataArray>,
    time: Option<f64>,
    /// The last section was POINTS.
    is_behind_points: bool,
    has_vertices: bool,
    has_faces: bool,
    cell_types: Option<DataArray>,
}

impl<'a> Sections<'a> {
    pub fn new(cursor: Cursor<'a>) -> Self {
        Self {
            cursor,
            owner: Owner::Dataset,
            points: None,
            grid: Grid::default(),
            attributes: Vec::new(),
            time: None,
            is_behind_points: false,
            has_vertices: false,
            has_faces: false,
            cell_types: None,
        }
    }

    pub fn walk(mut self) -> Result<Dataset, Error> {
        let keyword = self.cursor.word("DATASET")?;
        if keyword == "field" {
            return Err(Error::unsupported(
                self.cursor.file().path(),
                "a FIELD without points; expected a data set",
            ));
        }
        if keyword != "dataset" {
            return Err(self.cursor.malformed(format_args!("expected DATASET, found {keyword:?}")));
        }
        let kind = self.cursor.word("the kind of data set")?;
        match kind.as_str() {
            "polydata" | "unstructured_grid" | "structured_grid" => {}
            "structured_points" => self.grid.is_regular = true,
            "rectilinear_grid" => self.grid.is_rectilinear = true,
            other => {
                let message =
                    format!("DATASET {other:?}; expected POLYDATA or UNSTRUCTURED_GRID with particles");
                return Err(Error::unsupported(self.cursor.file().path(), message));
            }
        }
        while self.section()? {}
        self.finish()
    }

    /// Reads the next section; `false` at the end of what is understood.
    fn section(&mut self) -> Result<bool, Error> {
        let start = self.cursor.place.position();
        let keyword = String::from_utf8_lossy(&self.cursor.raw_word()?).to_ascii_lowercase();
        if keyword.is_empty() {
            return Ok(false);
        }
        let is_behind_points = std::mem::replace(&mut self.is_behind_points, keyword == "points");
        match keyword.as_str() {
            "points" => self.read_points()?,
            "vertices" => self.has_vertices |= self.skip_cells()?,
            "lines" | "polygons" | "triangle_strips" => self.has_faces |= self.skip_cells()?,
            "cells" => {
                self.skip_cells()?;
            }
            "cell_types" => {
                let count = self.cursor.number("the number of cell types")?;
                self.cell_types = Some(self.cursor.array("cell types".into(), 1, count, ScalarType::I32)?);
            }
            "point_data" => self.owner = Owner::Points(self.cursor.number("the number of points")?),
            "cell_data" => self.owner = Owner::Cells(self.cursor.number("the number of cells")?),
            "field" => self.read_field()?,
            _ => {
                let known = self.attribute(&keyword)? || self.grid.section(&keyword, &mut self.cursor)?;
                if !known && self.points.is_none() {
                    self.cursor.place.go_to(start);
                    return Err(self
                        .cursor
                        .malformed(format_args!("unknown section {keyword:?} before POINTS")));
                }
                if !known && is_behind_points {
                    self.cursor.place.go_to(start);
                    return Err(self.more_points_than_said(&keyword));
                }
                return Ok(known);
            }
        }
        Ok(true)
    }

    fn read_points(&mut self) -> Result<(), Error> {
        let count = self.cursor.number("the number of points")?;
        let ty = self.cursor.scalar_type()?;
        let points = self.cursor.array("POINTS".into(), 3, count, ty)?;
        if self.points.replace(points).is_some() {
            return Err(self.cursor.malformed("a second POINTS section; expected one"));
        }
        Ok(())
    }

    /// What follows the points is no section: mostly more points, of which nothing would be drawn.
    fn more_points_than_said(&self, found: &str) -> Error {
        let found: String = found.chars().take(MAX_QUOTED).collect();
        let count = self.points.as_ref().map_or(0, |points| points.tuples);
        self.cursor.malformed(format_args!(
            "expected a section such as POINT_DATA or the end behind POINTS {count}, found {found:?}; correct the number of points"
        ))
    }

    /// Steps over cells; says whether there are any.
    fn skip_cells(&mut self) -> Result<bool, Error> {
        let count: usize = self.cursor.number("the number of cells")?;
        let size: usize = self.cursor.number("the size of the cell list")?;
        // Since 5.1 offsets and connectivity are two typed arrays; told by the word, because 5.0 files are written either way.
        if !self.cursor.accept("OFFSETS")? {
            self.cursor.array("cells".into(), 1, size, ScalarType::I32)?;
            return Ok(count > 0);
        }
        let ty = self.cursor.scalar_type()?;
        self.cursor.array("cell offsets".into(), 1, count, ty)?;
        if !self.cursor.accept("CONNECTIVITY")? {
            return Err(self.cursor.malformed("expected CONNECTIVITY after OFFSETS"));
        }
        let ty = self.cursor.scalar_type()?;
        self.cursor.array("cell connectivity".into(), 1, size, ty)?;
        Ok(count > 1)
    }

    fn read_field(&mut self) -> Result<(), Error> {
        self.cursor.name()?;
        let count: usize = self.cursor.number("the number of arrays")?;
        for _ in 0..count {
            let name = self.cursor.name()?;
            let components = self.cursor.number("the number of components")?;
            let tuples: usize = self.cursor.number("the number of tuples")?;
            let ty = self.cursor.word("a type")?;
            if matches!(ty.as_str(), "string" | "utf8_string") {
                let count = tuples
                    .checked_mul(components)
                    .ok_or_else(|| self.cursor.malformed("the number of strings overflows"))?;
                self.cursor.skip_strings(count)?;
                self.cursor.skip_metadata(components)?;
                continue;
            }
            let ty = self.cursor.numeric(&ty)?;
            let array = self.cursor.array(name, components, tuples, ty)?;
            self.keep(array)?;
        }
        Ok(())
    }

    /// Reads an attribute section that starts with `keyword`; `false` when it is none.
    fn attribute(&mut self, keyword: &str) -> Result<bool, Error> {
        let fixed = match keyword {
            "vectors" | "normals" => Some(3),
            "tensors" => Some(9),
            "tensors6" => Some(6),
            "global_ids" | "pedigree_ids" | "edge_flags" => Some(1),
            "scalars" | "color_scalars" | "texture_coordinates" | "lookup_table" => None,
            _ => return Ok(false),
        };
        let name = self.cursor.name()?;
        if keyword == "lookup_table" {
            let count = self.cursor.number("the size of the table")?;
            let ty = if self.cursor.binary { ScalarType::U8 } else { ScalarType::F32 };
            self.cursor.array(name, 4, count, ty)?;
            return Ok(true);
        }
        let tuples = match self.owner {
            Owner::Points(count) | Owner::Cells(count) => count,
            Owner::Dataset => {
                return Err(self.cursor.malformed("an attribute before POINT_DATA or CELL_DATA"));
            }
        };
        if keyword == "color_scalars" {
            let components = self.cursor.number("the number of components")?;
            let mut array = self.cursor.array(name, components, tuples, ScalarType::U8)?;
            if let Content::Text { unit_colours, .. } = &mut array.content {
                *unit_colours = true;
            }
            self.keep(array)?;
            return Ok(true);
        }
        let (components, ty) = match (keyword, fixed) {
            ("texture_coordinates", _) => {
                let components = self.cursor.number("the number of components")?;
                (components, self.cursor.scalar_type()?)
            }
            ("scalars", _) => {
                let ty = self.cursor.scalar_type()?;
                let given = self.cursor.line_goes_on()?;
                let components = if given { self.cursor.number("the number of components")? } else { 1 };
                if self.cursor.accept("LOOKUP_TABLE")? {
                    self.cursor.name()?;
                }
                (components, ty)
            }
            (_, fixed) => (fixed.unwrap_or(1), self.cursor.scalar_type()?),
        };
        let array = self.cursor.array(name, components, tuples, ty)?;
        self.keep(array)?;
        Ok(true)
    }

    fn keep(&mut self, mut array: DataArray) -> Result<(), Error> {
        match self.owner {
            Owner::Points(_) if array.components > 0 => {
                if array.name.is_empty() {
                    array.name = "unknown".into();
                }
                self.attributes.push(array);
            }
            Owner::Dataset if array.components == 1 && array.tuples == 1 && is_time(&array.name) => {
                let value = array.check(self.cursor.file())?.collect(&ToF64, &Cancel::default())?[0];
                self.time = Some(value).filter(|time| time.is_finite());
            }
            _ => {}
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Dataset, Error> {
        let file = self.cursor.file();
        let positions = match self.points.take() {
            Some(points) => points,
            None => match self.grid.points(file)? {
                Some((tuples, coordinates)) => DataArray {
                    name: "grid points".into(),
                    components: 3,
                    tuples,
                    ty: ScalarType::F64,
                    content: Content::Binary { bytes: coordinates.into(), big: false },
                },
                None => {
                    return Err(self.cursor.malformed("the file ends without POINTS; expected particles"));
                }
            },
        };
        let points = positions.tuples;
        if let Owner::Points(count) = self.owner
            && count != points
        {
            return Err(self
                .cursor
                .malformed(format_args!("POINT_DATA {count} in a file with {points} points")));
        }
        self.attributes.retain(|array| array.tuples == points);
        let cells = match self.cell_types {
            Some(types) => Cells::Types(types),
            None if self.has_faces && !self.has_vertices => Cells::Mesh,
            None => Cells::Particles,
        };
        let piece = Piece {
            file: file.clone(),
            points,
            positions: Some(positions),
            attributes: self.attributes,
            cells,
            cell_ghosts: None,
        };
        Ok(Dataset { pieces: vec![piece], time: self.time })
    }
}

/// Whether a field array of this name holds the simulation time.
pub(crate) fn is_time(name: &str) -> bool {
    ["TimeValue", "TIME"].iter().any(|time| name.eq_ignore_ascii_case(time))
}
