//! `.ply` files (Turk 1994), text or binary: the vertices are the points, their properties attributes.

use std::fmt::Display;
use std::sync::Arc;

use crate::Error;
use crate::array::{Columns, Content, DataArray};
use crate::codec::text::{self, Separators};
use crate::dataset::{Cells, Dataset, Piece};
use crate::format::vectors::{Group, Property, groups};
use crate::format::{MOST_COLUMNS, odd_row, records};
use crate::forward::Forward;
use crate::input_file::{Bytes, InputFile};
use crate::scalar::ScalarType;

/// No line of a header that says anything is longer.
const MAX_LINE: usize = 4096;

#[derive(Clone, Copy, PartialEq)]
enum Encoding {
    Text,
    Binary { big: bool },
}

/// What the header says.
#[derive(Default)]
struct Header {
    encoding: Option<Encoding>,
    vertices: Option<usize>,
    properties: Vec<Property>,
    /// Whether faces or edges follow.
    has_cells: bool,
}

/// Finds the points and attributes of `file`.
pub(crate) fn parse(file: &InputFile) -> Result<Dataset, Error> {
    let mut place = Forward::new(file, 0);
    let header = Header::read(&mut place)?;
    let start = place.position();
    let malformed = |message: &dyn Display| Error::malformed(file.path(), "the header", message);
    let encoding =
        header.encoding.ok_or_else(|| malformed(&"expected a line `format ascii 1.0` or binary"))?;
    let points = header.vertices.ok_or_else(|| malformed(&"expected `element vertex`, the points"))?;
    let groups = groups(&header.properties);
    let place_of = |name: &str| groups.iter().position(|group| group.name == name);
    let positions = place_of("").ok_or_else(|| {
        let names: Vec<&str> = header.properties.iter().map(|property| property.name.as_str()).collect();
        malformed(&format_args!(
            "expected vertices with the properties x, y, z one after another and of one type, found {names:?}"
        ))
    })?;
    let contents = Contents::find(file, start, encoding, points, &header.properties)?;
    let mut arrays = Vec::with_capacity(groups.len());
    let mut offset = 0;
    for Group { name, members } in groups {
        arrays.push(DataArray {
            name,
            components: members.len(),
            tuples: points,
            ty: header.properties[members.start].ty,
            content: contents.of(members.start, offset, header.properties.len()),
        });
        offset += size_of(&header.properties[members]);
    }
    let positions = arrays.remove(positions);
    let piece = Piece {
        file: file.clone(),
        points,
        positions: Some(positions),
        attributes: arrays,
        cells: if header.has_cells { Cells::Mesh } else { Cells::Particles },
        cell_ghosts: None,
    };
    Ok(Dataset { pieces: vec![piece], time: None })
}

impl Header {
    fn read(place: &mut Forward<'_>) -> Result<Self, Error> {
        let mut header = Self::default();
        let mut in_vertices = false;
        loop {
            let start = place.position();
            let line = line(place)?;
            let file = place.file();
            let malformed =
                |message: &dyn Display| Error::malformed(file.path(), format_args!("byte {start}"), message);
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            match words[..] {
                [] | ["ply" | "comment" | "obj_info", ..] => {}
                ["format", encoding, _] => {
                    header.encoding = Some(match encoding {
                        "ascii" => Encoding::Text,
                        "binary_little_endian" => Encoding::Binary { big: false },
                        "binary_big_endian" => Encoding::Binary { big: true },
                        other => return Err(malformed(&format_args!("unknown format {other:?}"))),
                    });
                }
                ["element", name, count] => {
                    let count: usize = count.parse().map_err(|_| {
                        malformed(&format_args!("expected a number of elements, found {count:?}"))
                    })?;
                    in_vertices = name == "vertex";
                    if in_vertices && header.vertices.is_some() {
                        return Err(malformed(&"a second `element vertex`, expected one"));
                    }
                    if in_vertices {
                        header.vertices = Some(count);
                    } else if header.vertices.is_some() {
                        header.has_cells |= count > 0;
                    } else if count > 0 {
                        let message =
                            format_args!("element {name:?} comes before the vertices; write them first");
                        return Err(Error::unsupported(file.path(), message));
                    }
                }
                ["property", "list", ..] if in_vertices => {
                    let message = "vertices with lists as properties; write them without";
                    return Err(Error::unsupported(file.path(), message));
                }
                ["property", ty, name] if in_vertices => {
                    let ty = scalar_type(ty).ok_or_else(|| {
                        malformed(&format_args!("unknown type {ty:?}, expected float, int, ..."))
                    })?;
                    header.properties.push(Property { name: name.into(), ty });
                }
                ["property", ..] if !in_vertices => {}
                ["end_header"] => return Ok(header),
                _ => {
                    let shown: String = line.chars().take(60).collect();
                    return Err(malformed(&format_args!("expected a line of a PLY header, found {shown:?}")));
                }
            }
            if place.left() == 0 {
                return Err(malformed(&"the file ends, expected end_header"));
            }
        }
    }
}

/// The line that starts here; the place moves behind its end.
fn line(place: &mut Forward<'_>) -> Result<String, Error> {
    let there = place.peek(MAX_LINE)?;
    let there = &there[..there.len().min(MAX_LINE)];
    let end = memchr::memchr2(b'\n', b'\r', there).unwrap_or(there.len());
    let line = String::from_utf8_lossy(&there[..end]).into_owned();
    let ends_with = if there[end..].starts_with(b"\r\n") { 2 } else { 1 };
    place.advance(end + ends_with);
    Ok(line)
}

fn scalar_type(name: &str) -> Option<ScalarType> {
    Some(match name {
        "char" | "int8" => ScalarType::I8,
        "uchar" | "uint8" => ScalarType::U8,
        "short" | "int16" => ScalarType::I16,
        "ushort" | "uint16" => ScalarType::U16,
        "int" | "int32" => ScalarType::I32,
        "uint" | "uint32" => ScalarType::U32,
        "float" | "float32" => ScalarType::F32,
        "double" | "float64" => ScalarType::F64,
        _ => return None,
    })
}

/// Where the values of all properties are.
enum Contents {
    Text { bytes: Bytes, pieces: Arc<[text::Piece]> },
    Binary { records: Bytes, stride: usize, big: bool },
}

impl Contents {
    fn find(
        file: &InputFile,
        start: usize,
        encoding: Encoding,
        points: usize,
        properties: &[Property],
    ) -> Result<Self, Error> {
        match encoding {
            Encoding::Binary { big } => {
                let stride = size_of(properties);
                Ok(Self::Binary { records: records(file, start, points, stride)?, stride, big })
            }
            Encoding::Text => {
                if properties.len() > MOST_COLUMNS {
                    let message = format_args!(
                        "{} properties in text, more than {MOST_COLUMNS}; write it in binary",
                        properties.len()
                    );
                    return Err(Error::unsupported(file.path(), message));
                }
                let rest = Bytes::of(file, start..file.len());
                // Every number takes a byte and a blank.
                let wanted = points.checked_mul(properties.len()).filter(|&wanted| wanted <= rest.len());
                let pieces =
                    wanted.map_or(Ok(Vec::new()), |wanted| text::find(&rest, wanted, Separators::Blanks))?;
                let found: usize = pieces.iter().map(|piece| piece.count).sum();
                if Some(found) != wanted {
                    let columns = properties.len();
                    let message = format_args!(
                        "{points} vertices of {columns} numbers are declared, more than the rest of the file has; it is \
                         cut off or the count is wrong"
                    );
                    return Err(Error::malformed(file.path(), format_args!("byte {start}"), message));
                }
                // What is missing from a row would be taken from the next one, and at last from the faces.
                text::count_rows(&rest, properties.len(), points, Separators::Blanks)?
                    .map_err(|odd| odd_row(file, start, properties.len(), &odd))?;
                Ok(Self::Text { bytes: rest, pieces: pieces.into() })
            }
        }
    }

    /// The content of the array that starts with property `first` of `count`, which is `offset` bytes into a binary record.
    fn of(&self, first: usize, offset: usize, count: usize) -> Content {
        match self {
            Self::Text { bytes, pieces } => Content::Text {
                bytes: bytes.clone(),
                unit_colours: false,
                pieces: Some(pieces.clone()),
                columns: Some(Columns { per_row: count, first, separators: Separators::Blanks }),
            },
            Self::Binary { records, stride, big } => {
                Content::Records { bytes: records.clone(), stride: *stride, offset, big: *big }
            }
        }
    }
}

/// Bytes of the binary values of `properties`.
fn size_of(properties: &[Property]) -> usize {
    properties.iter().filter_map(|property| property.ty.size()).sum()
}
