//! Houdini's classic `.bgeo` (version 5), which SPlisHSPlasH, splashsurf and partio write for particles: big endian, one record
//! of four coordinates and all attributes per point (partio's `BGEO.cpp` is its only public description).

use std::fmt::Display;

use crate::Error;
use crate::array::{Content, DataArray};
use crate::dataset::{Cells, Dataset, Piece};
use crate::format::records;
use crate::forward::Forward;
use crate::input_file::InputFile;
use crate::scalar::ScalarType;

pub(crate) const MAGIC: &[u8] = b"BgeoV";

/// Bytes of a coordinate, a number of an attribute, or an index.
const WORD: usize = 4;

/// x, y, z and a weight.
const COORDINATES: usize = 4;

struct Attribute {
    name: String,
    components: usize,
    ty: ScalarType,
}

/// Finds the points and attributes of `file`. What it has besides, such as the outlines of a surface, is left aside.
pub(crate) fn parse(file: &InputFile) -> Result<Dataset, Error> {
    let mut header = Header { place: Forward::new(file, MAGIC.len()) };
    let version = header.count("the version")?;
    if version != 5 {
        let message = format_args!("a .bgeo file of version {version}; expected version 5");
        return Err(Error::unsupported(file.path(), message));
    }
    let points = header.count("the number of points")?;
    for what in ["primitives", "groups of points", "groups of primitives"] {
        header.count(what)?;
    }
    let count = header.count("the number of point attributes")?;
    for what in ["vertex", "primitive", "detail"] {
        header.count(what)?;
    }
    // Not as many as the file says are made room for: it may lie.
    let mut attributes = Vec::new();
    for _ in 0..count {
        attributes.push(header.attribute()?);
    }
    let words = COORDINATES + attributes.iter().map(|attribute| attribute.components).sum::<usize>();
    let records = records(file, header.place.position(), points, words * WORD)?;
    let array = |name: String, components, ty, offset| DataArray {
        name,
        components,
        tuples: points,
        ty,
        content: Content::Records { bytes: records.clone(), stride: words * WORD, offset, big: true },
    };
    let mut offset = COORDINATES * WORD;
    let mut arrays = Vec::new();
    for Attribute { name, components, ty } in attributes {
        if components > 0 {
            arrays.push(array(name, components, ty, offset));
        }
        offset += components * WORD;
    }
    let piece = Piece {
        file: file.clone(),
        points,
        positions: Some(array("P".into(), 3, ScalarType::F32, 0)),
        attributes: arrays,
        // Primitives of particle files are particle systems; a surface's corners cannot be told from them without reading all.
        cells: Cells::Particles,
        cell_ghosts: None,
    };
    Ok(Dataset { pieces: vec![piece], time: None })
}

struct Header<'a> {
    place: Forward<'a>,
}

impl Header<'_> {
    fn malformed(&self, message: impl Display) -> Error {
        Error::malformed(self.place.file().path(), format_args!("byte {}", self.place.position()), message)
    }

    fn bytes<const N: usize>(&mut self, what: &str) -> Result<[u8; N], Error> {
        let there = self.place.peek(N)?;
        let Some(bytes) = there.first_chunk::<N>().copied() else {
            return Err(self.malformed(format_args!("the file ends, expected {what}")));
        };
        self.place.advance(N);
        Ok(bytes)
    }

    /// A 32-bit number that counts something.
    fn count(&mut self, what: &str) -> Result<usize, Error> {
        let number = i32::from_be_bytes(self.bytes(what)?);
        usize::try_from(number)
            .map_err(|_| self.malformed(format_args!("{what} is {number}, expected 0 or more")))
    }

    /// A 16-bit size.
    fn short(&mut self, what: &str) -> Result<usize, Error> {
        Ok(usize::from(u16::from_be_bytes(self.bytes(what)?)))
    }

    fn text(&mut self, what: &str) -> Result<String, Error> {
        let length = self.short(what)?;
        let there = self.place.peek(length)?;
        let Some(text) = there.get(..length).map(|text| String::from_utf8_lossy(text).into_owned()) else {
            return Err(self.malformed(format_args!("the file ends, expected {length} bytes of {what}")));
        };
        self.place.advance(length);
        Ok(text)
    }

    /// What an attribute is; its default is stepped over.
    fn attribute(&mut self) -> Result<Attribute, Error> {
        let name = self.text("an attribute's name")?;
        let components = self.short("an attribute's size")?;
        let ty = match self.count("an attribute's type")? {
            // A float, a vector.
            0 | 5 => ScalarType::F32,
            1 => ScalarType::I32,
            // The number of one of the strings that follow here.
            4 => {
                for _ in 0..self.count("the number of strings")? {
                    self.text("a string")?;
                }
                return Ok(Attribute { name, components, ty: ScalarType::I32 });
            }
            other => {
                let message = format_args!(
                    "point attribute {name:?} has the unknown type {other}; expected 0, 1, 4 or 5 (numbers, vectors, \
                     string indices)"
                );
                return Err(Error::unsupported(self.place.file().path(), message));
            }
        };
        for _ in 0..components {
            self.bytes::<WORD>("an attribute's default")?;
        }
        Ok(Attribute { name, components, ty })
    }
}
