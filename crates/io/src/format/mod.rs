//! File formats: what a file is by its first bytes, and where its arrays lie.

mod bgeo;
mod gzip;
pub(crate) mod legacy;
pub(crate) mod parallel;
mod ply;
mod table;
mod vectors;
pub(crate) mod xml;

use std::path::{Path, PathBuf};

use crate::codec::text::OddRow;
use crate::dataset::Dataset;
use crate::format::xml::Document;
use crate::forward::Forward;
use crate::input_file::{Bytes, InputFile};
use crate::{Error, IoMode};

/// What a file is, by its content; names lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Legacy,
    Xml,
    SeriesJson,
    Bgeo,
    Ply,
    Table,
    /// Packed, a `.bgeo` file perhaps.
    Gzip,
}

/// Extensions of particle files, without those of lists of series.
pub(crate) const PARTICLE_FILES: [&str; 9] =
    ["vtk", "vtu", "vtp", "pvtu", "pvtp", "bgeo", "ply", TABLES[0], TABLES[1]];

/// Those that hold something else as often.
pub(crate) const TABLES: [&str; 2] = ["csv", "xyz"];

/// What is read, for messages.
pub(crate) const EXPECTED: &str =
    ".vtk, .vtu, .vtp, .pvtu, .pvtp, .pvd, .series, .bgeo, .ply, or a table of x, y, z in text: .csv, .xyz";

/// Most numbers beside one another in a row of text. To find those of one column all are counted, so that reading all columns takes
/// the square of their number; particles have some dozens.
const MOST_COLUMNS: usize = 1000;

/// What was found in a file.
pub(crate) enum Opened {
    Points(Dataset),
    /// Names of files that have the points, relative to its folder.
    Pieces(Vec<String>),
    /// Names of files for times.
    Series,
}

impl Opened {
    /// Finds what is in the file at `path`.
    pub fn at(path: &Path, mode: IoMode) -> Result<Self, Error> {
        let file = InputFile::open(path, mode)?;
        Ok(match Format::sniff(&file)? {
            Format::Legacy => Self::Points(legacy::parse(&file)?),
            Format::Bgeo => Self::Points(bgeo::parse(&file)?),
            Format::Gzip => Self::Points(bgeo::parse(&gzip::unpack(&file)?)?),
            Format::Ply => Self::Points(ply::parse(&file)?),
            Format::Table => Self::Points(table::parse(&file)?),
            Format::Xml => match xml::parse(&file)? {
                Document::Dataset(dataset) => Self::Points(dataset),
                Document::Parallel(sources) => Self::Pieces(sources),
                Document::Collection(_) => Self::Series,
            },
            Format::SeriesJson => Self::Series,
        })
    }
}

impl Format {
    /// Looks at the first bytes.
    pub fn sniff(file: &InputFile) -> Result<Self, Error> {
        let unsupported = |what: &str| {
            Err(Error::unsupported(
                file.path(),
                format_args!("{what}; expected a particle file ({EXPECTED})"),
            ))
        };
        let mut place = Forward::new(file, 0);
        skip_mark(&mut place)?;
        let head: Vec<u8> = place.peek(64)?.iter().copied().take(64).collect();
        match &head[..] {
            [] => Err(Error::malformed(
                file.path(),
                "byte 0",
                format_args!("the file is empty; expected a particle file ({EXPECTED})"),
            )),
            text if starts_with_ignore_case(text, b"# vtk datafile") => Ok(Self::Legacy),
            [b'<', ..] => Ok(Self::Xml),
            [b'{', ..] => Ok(Self::SeriesJson),
            [0x1f, 0x8b, ..] => Ok(Self::Gzip),
            text if text.starts_with(bgeo::MAGIC) => Ok(Self::Bgeo),
            [b'p', b'l', b'y', b'\r' | b'\n', ..] => Ok(Self::Ply),
            [0x7f, b'N', b'S', b'J', ..] => unsupported(
                "Houdini's new .bgeo, which is not read; write it in the classic form (.bhclassic)",
            ),
            [0x89, b'H', b'D', b'F', ..] => unsupported(
                "HDF5 (.vtkhdf), which is not read; write it as .vtu or .vtp, for example with ParaView",
            ),
            [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => unsupported("UTF-16 text; save it as UTF-8"),
            _ if table::is_table(&mut place)? => Ok(Self::Table),
            _ => unsupported("neither a VTK file, legacy or XML, nor .bgeo, .ply or a table"),
        }
    }
}

/// Steps over a byte order mark and blanks.
pub(crate) fn skip_mark(place: &mut Forward<'_>) -> Result<(), Error> {
    if place.peek(3)?.starts_with(b"\xef\xbb\xbf") {
        place.advance(3);
    }
    place.skip_blanks()
}

/// The `count` records of `stride` bytes from byte `start` of `file` on.
pub(crate) fn records(file: &InputFile, start: usize, count: usize, stride: usize) -> Result<Bytes, Error> {
    let there = file.len().saturating_sub(start);
    let length = count.checked_mul(stride).filter(|&length| length <= there).ok_or_else(|| {
        let message = format_args!(
            "{count} points of {stride} bytes are declared, more than the {there} bytes left in the file; it is cut off or \
             the count is wrong"
        );
        Error::malformed(file.path(), format_args!("byte {start}"), message)
    })?;
    Ok(Bytes::of(file, start..start + length))
}

/// What is wrong with a row of a table that starts at byte `start` of `file`, of `per_row` values.
fn odd_row(file: &InputFile, start: usize, per_row: usize, odd: &OddRow) -> Error {
    let message = format_args!(
        "a row of {} values, expected {per_row}; every row needs all of them, without empty fields",
        odd.found
    );
    Error::malformed(file.path(), format_args!("the line at byte {}", start + odd.start), message)
}

/// The file that a list in `folder` calls `name`. Lists written on Windows have backslashes, which elsewhere are letters like
/// any other; they are taken for separators where there is no such file.
pub(crate) fn listed(folder: &Path, name: &str) -> PathBuf {
    let path = folder.join(name);
    let other = name.contains('\\').then(|| folder.join(name.replace('\\', "/")));
    other.filter(|other| !path.exists() && other.exists()).unwrap_or(path)
}

pub(crate) fn starts_with_ignore_case(text: &[u8], prefix: &[u8]) -> bool {
    text.get(..prefix.len()).is_some_and(|head| head.eq_ignore_ascii_case(prefix))
}
