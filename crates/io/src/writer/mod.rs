//! Writes particles as VTK files that VTK, ParaView and this crate read.
//!
//! Every particle becomes a vertex cell, so that ParaView draws it. A file is written beside its place and renamed at the
//! end: a program that watches the folder never meets half a file.

mod collection;
mod inline;
mod legacy;
mod text;
mod vtu;

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use crate::Error;
use crate::codec::blocks::Compressor;

pub use collection::write_pvd;

/// A kind of file, and how the numbers are stored in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// `.vtk`, version 5.1, as text.
    LegacyAscii,
    /// `.vtk`, version 5.1, big-endian numbers.
    LegacyBinary,
    /// `.vtu`, an unstructured grid.
    Vtu(Encoding),
    /// `.vtp`, poly data.
    Vtp(Encoding),
}

/// How an XML file stores numbers. All but text are little endian with 64-bit sizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Text, with as many digits as it takes to read the same numbers.
    Ascii,
    /// Base64 where the array is declared.
    Base64,
    /// As they are in memory, behind the markup: the fastest to read.
    Raw,
    /// Blocks compressed with zlib, behind the markup: what VTK writes unless told otherwise.
    Zlib,
    /// Blocks compressed with LZ4, behind the markup: larger and faster than zlib.
    Lz4,
    /// Blocks compressed with LZMA, behind the markup: the smallest and slowest.
    Lzma,
}

/// Writes `particles` to `path`.
///
/// # Errors
/// [`Error::Io`] when the system refuses, [`Error::Usage`] when an attribute does not fit the number of particles.
pub fn write(path: &Path, particles: &WriteParticles<'_>, format: Format) -> Result<(), Error> {
    particles.validate()?;
    let kind = if matches!(format, Format::Vtp(_)) { XmlKind::PolyData } else { XmlKind::Grid };
    match format {
        Format::LegacyAscii => legacy::write(path, particles, false),
        Format::LegacyBinary => legacy::write(path, particles, true),
        Format::Vtu(encoding) | Format::Vtp(encoding) => match encoding {
            Encoding::Ascii => inline::write(path, particles, kind, true),
            Encoding::Base64 => inline::write(path, particles, kind, false),
            Encoding::Raw => vtu::write(path, particles, kind, None),
            Encoding::Zlib => vtu::write(path, particles, kind, Some(Compressor::Zlib)),
            Encoding::Lz4 => vtu::write(path, particles, kind, Some(Compressor::Lz4)),
            Encoding::Lzma => vtu::write(path, particles, kind, Some(Compressor::Lzma)),
        },
    }
}

/// [`write()`] as [`Format::LegacyBinary`].
///
/// # Errors
/// As [`write()`].
pub fn write_legacy_binary(path: &Path, particles: &WriteParticles<'_>) -> Result<(), Error> {
    write(path, particles, Format::LegacyBinary)
}

/// [`write()`] as `.vtu` with [`Encoding::Raw`].
///
/// # Errors
/// As [`write()`].
pub fn write_vtu_raw(path: &Path, particles: &WriteParticles<'_>) -> Result<(), Error> {
    write(path, particles, Format::Vtu(Encoding::Raw))
}

/// [`write()`] as `.vtu` with [`Encoding::Zlib`].
///
/// # Errors
/// As [`write()`].
pub fn write_vtu_zlib(path: &Path, particles: &WriteParticles<'_>) -> Result<(), Error> {
    write(path, particles, Format::Vtu(Encoding::Zlib))
}

/// Which kind of data set the particles are written as.
#[derive(Clone, Copy, PartialEq)]
enum XmlKind {
    Grid,
    PolyData,
}

impl XmlKind {
    /// Name of the data set.
    fn name(self) -> &'static str {
        if self == Self::Grid { "UnstructuredGrid" } else { "PolyData" }
    }

    /// The `Piece` element that `count` particles open.
    fn piece(self, count: usize) -> String {
        let cells = if self == Self::Grid { "NumberOfCells" } else { "NumberOfVerts" };
        format!("<Piece NumberOfPoints=\"{count}\" {cells}=\"{count}\">")
    }

    /// Name of the element with the vertex cells.
    fn cells(self) -> &'static str {
        if self == Self::Grid { "Cells" } else { "Verts" }
    }
}

/// VTK's number of the vertex cell.
const VERTEX: u8 = 1;

/// The numbers of an attribute.
#[derive(Clone, Copy, Debug)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Values<'a> {
    F32(&'a [f32]),
    F64(&'a [f64]),
    I8(&'a [i8]),
    U8(&'a [u8]),
    I16(&'a [i16]),
    U16(&'a [u16]),
    I32(&'a [i32]),
    U32(&'a [u32]),
    I64(&'a [i64]),
    U64(&'a [u64]),
}

/// Runs `$body` with `$slice` bound to the slice of whichever type `$values` holds.
macro_rules! with_slice {
    ($values:expr, $slice:ident => $body:expr) => {
        match $values {
            Values::F32($slice) => $body,
            Values::F64($slice) => $body,
            Values::I8($slice) => $body,
            Values::U8($slice) => $body,
            Values::I16($slice) => $body,
            Values::U16($slice) => $body,
            Values::I32($slice) => $body,
            Values::U32($slice) => $body,
            Values::I64($slice) => $body,
            Values::U64($slice) => $body,
        }
    };
}

impl Values<'_> {
    fn len(&self) -> usize {
        with_slice!(self, slice => slice.len())
    }

    /// Bytes per number.
    fn size(&self) -> usize {
        with_slice!(self, slice => size_of_val(*slice).checked_div(slice.len()).unwrap_or(1))
    }

    /// Appends the numbers of `range` to `out`.
    fn append(&self, range: std::ops::Range<usize>, big: bool, out: &mut Vec<u8>) {
        with_slice!(self, slice => for value in &slice[range] {
            out.extend_from_slice(&if big { value.to_be_bytes() } else { value.to_le_bytes() });
        });
    }

    /// VTK's names, in XML and in legacy files.
    fn type_names(&self) -> (&'static str, &'static str) {
        match self {
            Self::F32(_) => ("Float32", "float"),
            Self::F64(_) => ("Float64", "double"),
            Self::I8(_) => ("Int8", "char"),
            Self::U8(_) => ("UInt8", "unsigned_char"),
            Self::I16(_) => ("Int16", "short"),
            Self::U16(_) => ("UInt16", "unsigned_short"),
            Self::I32(_) => ("Int32", "int"),
            Self::U32(_) => ("UInt32", "unsigned_int"),
            Self::I64(_) => ("Int64", "vtktypeint64"),
            Self::U64(_) => ("UInt64", "vtktypeuint64"),
        }
    }
}

/// A named attribute of the particles.
#[derive(Clone, Copy, Debug)]
pub struct WriteAttribute<'a> {
    /// Its name; any text.
    pub name: &'a str,
    /// Numbers per particle, > 0.
    pub components: usize,
    /// `components` numbers per particle, particle after particle.
    pub values: Values<'a>,
}

/// What is written.
#[derive(Clone, Copy, Debug, Default)]
pub struct WriteParticles<'a> {
    /// Coordinates, file space.
    pub positions: &'a [[f64; 3]],
    /// Attributes, in this order.
    pub attributes: &'a [WriteAttribute<'a>],
    /// Simulation time, as the field `TimeValue`.
    pub time: Option<f64>,
}

impl WriteParticles<'_> {
    fn validate(&self) -> Result<(), Error> {
        for attribute in self.attributes {
            let (found, per_point) = (attribute.values.len(), attribute.components);
            if per_point == 0 || Some(found) != per_point.checked_mul(self.positions.len()) {
                return Err(Error::usage(format_args!(
                    "attribute {:?} has {found} numbers, expected {per_point} (more than 0) for each of {} particles",
                    attribute.name,
                    self.positions.len()
                )));
            }
        }
        Ok(())
    }
}

/// Writes `path` through `fill`: to a temporary file in the same folder, renamed when complete, removed otherwise.
fn write_beside(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&mut File>) -> std::io::Result<()>,
) -> Result<(), Error> {
    let io = |e: std::io::Error| Error::io(path, &e);
    // Renamed over, a pipe would lose its reader and `/dev/null` would be gone.
    if path.metadata().is_ok_and(|there| !there.is_file()) {
        return Err(io(std::io::Error::other(
            "it is there already and no regular file; choose another name",
        )));
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or_else(|| ".".as_ref());
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As for any new file; the user's mask takes away what it takes away.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.prefix(".writing-").tempfile_in(folder).map_err(io)?;
    let mut writer = BufWriter::with_capacity(1 << 20, file.as_file_mut());
    fill(&mut writer).and_then(|()| writer.flush()).map_err(io)?;
    drop(writer);
    file.persist(path).map_err(|e| io(e.error))?;
    Ok(())
}

/// Numbers handled at a time.
const PIECE: usize = 1 << 16;

/// Consecutive numbers from `start`, piece by piece, as connectivity and offsets need them.
fn counting(start: usize, count: usize) -> impl Iterator<Item = Vec<i64>> {
    (0..count).step_by(PIECE).map(move |first| {
        let last = (first + PIECE).min(count);
        (start + first..start + last).map(|i| i as i64).collect()
    })
}

/// Writes all numbers of `values`.
fn write_values(writer: &mut impl Write, values: Values<'_>, big: bool) -> std::io::Result<()> {
    let mut buffer = Vec::with_capacity(PIECE * 8);
    for first in (0..values.len()).step_by(PIECE) {
        buffer.clear();
        values.append(first..(first + PIECE).min(values.len()), big, &mut buffer);
        writer.write_all(&buffer)?;
    }
    Ok(())
}
