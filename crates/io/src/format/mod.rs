//! File formats: what a file is by its first bytes, and where its arrays lie.

pub(crate) mod legacy;
pub(crate) mod parallel;
pub(crate) mod xml;

use std::path::{Path, PathBuf};

use crate::Error;
use crate::forward::Forward;
use crate::input_file::InputFile;

/// What a file is, by its content; names lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Legacy,
    Xml,
    SeriesJson,
}

impl Format {
    /// Looks at the first bytes.
    pub fn sniff(file: &InputFile) -> Result<Self, Error> {
        let unsupported = |what: &str| {
            Err(Error::unsupported(
                file.path(),
                format_args!("{what}; expected a VTK file (.vtk, .vtu, .vtp, .pvtu, .pvtp, .pvd or .series)"),
            ))
        };
        let mut place = Forward::new(file, 0);
        skip_mark(&mut place)?;
        match place.peek(64)? {
            [] => Err(Error::malformed(file.path(), "byte 0", "the file is empty; expected a VTK file")),
            text if starts_with_ignore_case(text, b"# vtk datafile") => Ok(Self::Legacy),
            [b'<', ..] => Ok(Self::Xml),
            [b'{', ..] => Ok(Self::SeriesJson),
            [0x1f, 0x8b, ..] => unsupported("gzip data; unpack it with gunzip first"),
            [0x89, b'H', b'D', b'F', ..] => unsupported(
                "HDF5 (.vtkhdf), which is not read; write it as .vtu or .vtp, for example with ParaView",
            ),
            [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => unsupported("UTF-16 text; save it as UTF-8"),
            _ => unsupported("neither a legacy nor an XML VTK file"),
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
