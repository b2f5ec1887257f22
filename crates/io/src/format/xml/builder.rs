use std::ops::Range;
use std::str::FromStr;

use meniscus_core::Cancel;

use super::settings::Settings;
use super::{Attributes, CollectionEntry, Document};
use crate::Error;
use crate::array::{Content, DataArray};
use crate::dataset::{CellGhosts, Cells, Dataset, GHOSTS, Piece};
use crate::format::legacy::is_time;
use crate::forward::Forward;
use crate::input_file::{Bytes, InputFile};
use crate::scalar::{ScalarType, ToF64};

/// The part of a data set that an array belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Section {
    Field,
    PointData,
    CellData,
    Points,
    /// Of a grid, or the vertices of poly data, which come first.
    Cells,
    Other,
}

/// A `Piece` element as far as it was read.
#[derive(Default)]
struct OpenPiece {
    points: usize,
    cells: usize,
    faces: u64,
    verts: u64,
    positions: Option<Declared>,
    attributes: Vec<Declared>,
    types: Option<Declared>,
    connectivity: Option<Declared>,
    offsets: Option<Declared>,
    cell_ghosts: Option<Declared>,
}

/// A `DataArray` element.
struct Declared {
    section: Section,
    name: String,
    components: usize,
    ty: ScalarType,
    /// In the appended data; else in `text`.
    offset: Option<usize>,
    ascii: bool,
    text: ArrayText,
    /// There were blanks behind the text.
    blank_follows: bool,
    tuples: Option<usize>,
}

/// The text of a `DataArray` element.
enum ArrayText {
    /// Where it lies in the file.
    InFile(Range<usize>),
    /// Put together from what is not contiguous in the file.
    Copied(Vec<u8>),
}

impl ArrayText {
    fn is_empty(&self) -> bool {
        match self {
            Self::InFile(range) => range.is_empty(),
            Self::Copied(text) => text.is_empty(),
        }
    }

    fn bytes(self, file: &InputFile) -> Bytes {
        match self {
            Self::InFile(range) => Bytes::of(file, range),
            Self::Copied(text) => text.into(),
        }
    }
}

/// Where the appended data starts and ends.
struct Appended {
    range: Range<usize>,
    base64: bool,
}

/// Builds a document from the elements of a file.
pub(super) struct Builder<'a> {
    file: &'a InputFile,
    settings: Option<Settings>,
    piece: Option<OpenPiece>,
    pieces: Vec<OpenPiece>,
    field: Vec<Declared>,
    array: Option<Declared>,
    sources: Vec<String>,
    entries: Vec<CollectionEntry>,
    appended: Option<Appended>,
    has_appended_text: bool,
}

impl<'a> Builder<'a> {
    pub fn new(file: &'a InputFile) -> Self {
        Self {
            file,
            settings: None,
            piece: None,
            pieces: Vec::new(),
            field: Vec::new(),
            array: None,
            sources: Vec::new(),
            entries: Vec::new(),
            appended: None,
            has_appended_text: false,
        }
    }

    fn malformed(&self, place: &str, message: impl std::fmt::Display) -> Error {
        Error::malformed(self.file.path(), place, message)
    }

    /// An element opens below the elements `open`.
    pub fn start(
        &mut self,
        open: &[String],
        name: &str,
        attributes: &Attributes,
        at: u64,
    ) -> Result<(), Error> {
        let Some(settings) = &self.settings else {
            if name != "VTKFile" {
                return Err(Error::unsupported(
                    self.file.path(),
                    format_args!("an XML file that starts with <{name}>; expected <VTKFile>"),
                ));
            }
            self.settings = Some(Settings::read(self.file, attributes)?);
            return Ok(());
        };
        if open.is_empty() {
            return Err(self.malformed(&format!("byte {at}"), "a second root element"));
        }
        match name {
            "Piece" if settings.kind.starts_with('P') && attributes.get("source").is_some() => {
                self.sources.extend(attributes.get("source").map(str::to_owned));
            }
            "Piece" => {
                let count =
                    |name: &str| self.number(attributes, name, "Piece").map(Option::unwrap_or_default);
                self.piece = Some(OpenPiece {
                    points: count("numberofpoints")?,
                    cells: count("numberofcells")?,
                    verts: count("numberofverts")? as u64,
                    faces: (count("numberofpolys")? as u64)
                        .saturating_add(count("numberofstrips")? as u64)
                        .saturating_add(count("numberoflines")? as u64),
                    ..OpenPiece::default()
                });
            }
            "DataSet" if settings.kind == "Collection" => self.collection_entry(attributes)?,
            "DataArray" => self.open_array(open, attributes)?,
            _ => {}
        }
        Ok(())
    }

    fn number<T: FromStr>(
        &self,
        attributes: &Attributes,
        name: &str,
        element: &str,
    ) -> Result<Option<T>, Error> {
        let Some(text) = attributes.get(name) else { return Ok(None) };
        let message = format!("{name}={text:?}, expected a whole number that is not negative");
        text.parse().map(Some).map_err(|_| self.malformed(&format!("element {element}"), message))
    }

    fn collection_entry(&mut self, attributes: &Attributes) -> Result<(), Error> {
        let Some(file) = attributes.get("file") else {
            return Err(self.malformed("element DataSet", "no file attribute"));
        };
        let time = attributes.get("timestep").and_then(|time| time.parse().ok());
        let part = attributes.get("part").and_then(|part| part.parse().ok()).unwrap_or(0);
        self.entries.push(CollectionEntry { time, part, file: file.to_owned() });
        Ok(())
    }

    fn open_array(&mut self, open: &[String], attributes: &Attributes) -> Result<(), Error> {
        let section = match open.last().map(String::as_str) {
            Some("FieldData") => Section::Field,
            Some("PointData") => Section::PointData,
            Some("CellData") => Section::CellData,
            Some("Points") => Section::Points,
            Some("Cells" | "Verts") => Section::Cells,
            _ => Section::Other,
        };
        let name = attributes.get("name").unwrap_or_default().to_owned();
        let place = format!("DataArray {name:?}");
        // Arrays that are never read may be of any type; they are stepped over.
        let Some(ty) = attributes.get("type").and_then(ScalarType::from_xml) else {
            if section == Section::Points {
                let message = format!("type {:?}, expected Float32 or Float64", attributes.get("type"));
                return Err(self.malformed(&place, message));
            }
            return Ok(());
        };
        let format = attributes.get("format").unwrap_or("ascii").to_ascii_lowercase();
        if !["ascii", "binary", "appended"].contains(&format.as_str()) {
            let message = format!("format={format:?}, expected ascii, binary or appended");
            return Err(self.malformed(&place, message));
        }
        let offset = match format.as_str() {
            "appended" => Some(
                self.number(attributes, "offset", &place)?
                    .ok_or_else(|| self.malformed(&place, "appended data without an offset"))?,
            ),
            _ => None,
        };
        self.array = Some(Declared {
            section,
            components: self.number(attributes, "numberofcomponents", &place)?.unwrap_or(1),
            tuples: self.number(attributes, "numberoftuples", &place)?,
            name,
            ty,
            offset,
            ascii: format == "ascii",
            text: ArrayText::InFile(0..0),
            blank_follows: false,
        });
        Ok(())
    }

    /// Text outside of arrays at `range` of the file: the content of `AppendedData`, or blanks.
    pub fn text(&mut self, range: Range<usize>) {
        if std::mem::take(&mut self.has_appended_text)
            && let Some(appended) = &mut self.appended
        {
            appended.range.end = appended.range.end.min(range.end);
        }
    }

    /// Text of the open array at `range` of the file.
    pub fn array_text(&mut self, range: Range<usize>, is_blank: bool) -> Result<(), Error> {
        match &mut self.array {
            // Blanks around child elements and comments would only force a copy.
            Some(array) if is_blank => array.blank_follows |= !array.text.is_empty(),
            Some(array) if array.text.is_empty() => array.text = ArrayText::InFile(range),
            Some(_) => {
                let mut scratch = Vec::new();
                let text = self.file.get(range, &mut scratch)?.unwrap_or_default();
                self.owned_text(text)?;
            }
            None => {}
        }
        Ok(())
    }

    /// Text that is not contiguous in the file with the text before it.
    pub fn owned_text(&mut self, text: &[u8]) -> Result<(), Error> {
        let Some(array) = &mut self.array else { return Ok(()) };
        if let ArrayText::InFile(range) = &array.text {
            let mut scratch = Vec::new();
            let before = self.file.get(range.clone(), &mut scratch)?.unwrap_or_default();
            array.text = ArrayText::Copied(before.to_vec());
        }
        if let ArrayText::Copied(whole) = &mut array.text {
            if std::mem::take(&mut array.blank_follows) {
                whole.push(b' ');
            }
            whole.extend_from_slice(text);
        }
        Ok(())
    }

    /// An element closes.
    pub fn end(&mut self, name: &str) -> Result<(), Error> {
        match name {
            "DataArray" => {
                let Some(array) = self.array.take() else { return Ok(()) };
                match (array.section, &mut self.piece) {
                    (Section::Field, _) => self.field.push(array),
                    (Section::PointData, Some(piece)) => piece.attributes.push(array),
                    (Section::Points, Some(piece)) => piece.positions = Some(array),
                    (Section::CellData, Some(piece)) if array.name == GHOSTS && array.components == 1 => {
                        piece.cell_ghosts = Some(array);
                    }
                    (Section::Cells, Some(piece)) => match array.name.as_str() {
                        "types" => piece.types = Some(array),
                        "connectivity" => piece.connectivity = Some(array),
                        "offsets" => piece.offsets = Some(array),
                        _ => {}
                    },
                    _ => {}
                }
            }
            // Of many empty pieces one says what all do.
            "Piece" => {
                let has_points = |piece: &OpenPiece| piece.points > 0;
                let is_needed = |piece: &OpenPiece| has_points(piece) || self.pieces.is_empty();
                let piece = self.piece.take().filter(is_needed);
                self.pieces.extend(piece);
            }
            _ => {}
        }
        Ok(())
    }

    /// The `AppendedData` element starts, its content at `place`; whether it is raw.
    pub fn appended(&mut self, attributes: &Attributes, place: &mut Forward<'_>) -> Result<bool, Error> {
        let base64 = match attributes.get("encoding") {
            Some("raw") => false,
            Some("base64") | None => true,
            Some(other) => {
                let message = format!("encoding={other:?}, expected raw or base64");
                return Err(self.malformed("element AppendedData", message));
            }
        };
        place.skip_blanks()?;
        let start = place.position();
        if place.peek(1)?.first() != Some(&b'_') {
            let place = format!("byte {start}");
            return Err(self.malformed(&place, "expected an underscore before the appended data"));
        }
        self.appended = Some(Appended { range: start + 1..self.file.len(), base64 });
        self.has_appended_text = base64;
        Ok(!base64)
    }

    /// The document, when all elements are read.
    pub fn finish(mut self) -> Result<Document, Error> {
        let Some(settings) = self.settings.clone() else {
            return Err(self.malformed("byte 0", "no element; expected <VTKFile>"));
        };
        match settings.kind.as_str() {
            "Collection" => return Ok(Document::Collection(self.entries)),
            kind if kind.starts_with('P') && kind != "PolyData" => {
                return Ok(Document::Parallel(self.sources));
            }
            _ => {}
        }
        let mut dataset = Dataset { pieces: Vec::with_capacity(self.pieces.len()), time: None };
        for array in std::mem::take(&mut self.field) {
            if array.components == 1 && array.tuples == Some(1) && is_time(&array.name) {
                let array = self.resolve(&settings, array, 1)?;
                let value = array.check(self.file)?.collect(&ToF64, &Cancel::default())?[0];
                dataset.time = Some(value).filter(|time| time.is_finite());
            }
        }
        for piece in std::mem::take(&mut self.pieces) {
            dataset.pieces.push(self.finish_piece(&settings, piece)?);
        }
        Ok(Document::Dataset(dataset))
    }

    fn finish_piece(&self, settings: &Settings, piece: OpenPiece) -> Result<Piece, Error> {
        let points = piece.points;
        if points == 0 {
            // Only the names are of interest; whatever else is wrong with arrays of nothing does not matter.
            let attributes = piece.attributes.into_iter().filter(|array| array.components > 0);
            let attributes = attributes.filter_map(|array| self.resolve(settings, array, 0).ok()).collect();
            return Ok(Piece {
                file: self.file.clone(),
                points,
                positions: None,
                attributes,
                cells: Cells::Particles,
                cell_ghosts: None,
            });
        }
        let Some(positions) = piece.positions else {
            return Err(self.malformed("element Piece", format_args!("{points} points, but no Points array")));
        };
        if positions.components != 3 {
            let message = format!("{} components, expected 3", positions.components);
            return Err(self.malformed("element Points", message));
        }
        let positions = self.resolve(settings, positions, points)?;
        let attributes = piece
            .attributes
            .into_iter()
            .filter(|array| array.components > 0)
            .map(|array| self.resolve(settings, array, points))
            .collect::<Result<_, _>>()?;
        let cell_ghosts = match (piece.cell_ghosts, piece.connectivity, piece.offsets) {
            // Only where every cell is a single vertex: in a mesh, points of ghost cells may be points of real ones elsewhere.
            (Some(flags), Some(connectivity), Some(offsets)) => {
                let cells = if settings.kind == "PolyData" { piece.verts as usize } else { piece.cells };
                Some(CellGhosts {
                    flags: self.resolve(settings, flags, cells)?,
                    connectivity: self.resolve(settings, connectivity, cells)?,
                    offsets: self.resolve(settings, offsets, cells)?,
                })
            }
            _ => None,
        };
        let cells = match piece.types {
            _ if piece.verts > 0 => Cells::Particles,
            _ if piece.faces > 0 => Cells::Mesh,
            Some(types) => Cells::Types(self.resolve(settings, types, piece.cells)?),
            None => Cells::Particles,
        };
        let positions = Some(positions);
        Ok(Piece { file: self.file.clone(), points, positions, attributes, cells, cell_ghosts })
    }

    fn resolve(&self, settings: &Settings, array: Declared, tuples: usize) -> Result<DataArray, Error> {
        let place = format!("DataArray {:?}", array.name);
        if let (Some(name), false) = (&settings.unknown_compressor, array.ascii) {
            return Err(Error::unsupported(
                self.file.path(),
                format_args!("compressor {name:?}; expected zlib, LZ4, LZMA or none"),
            ));
        }
        let (bytes, base64) = match (array.offset, &self.appended) {
            (None, _) => (array.text.bytes(self.file), true),
            (Some(_), None) => {
                return Err(self.malformed(&place, "appended data, but no AppendedData element"));
            }
            (Some(offset), Some(Appended { range, base64 })) => {
                let start =
                    range.start.checked_add(offset).filter(|&start| start <= range.end).ok_or_else(|| {
                        let (there, end) = (range.end - range.start, range.end);
                        self.malformed(
                            &place,
                            format_args!(
                                "offset {offset} is beyond the {there} bytes of data up to byte {end}"
                            ),
                        )
                    })?;
                (Bytes::of(self.file, start..range.end), *base64)
            }
        };
        let content = if array.ascii {
            Content::Text { bytes, unit_colours: false, pieces: None, columns: None }
        } else {
            Content::Framed {
                bytes,
                base64,
                compressor: settings.compressor,
                wide_header: settings.wide_header,
                big: settings.big,
            }
        };
        Ok(DataArray { name: array.name, components: array.components, tuples, ty: array.ty, content })
    }
}
