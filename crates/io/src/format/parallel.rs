//! Parallel files: a list of piece files.

use crate::dataset::Dataset;
use crate::format::xml::{self, Document};
use crate::format::{Format, legacy, listed};
use crate::input_file::InputFile;
use crate::{Error, IoMode};

/// Opens the pieces that `file` names, relative to its folder.
pub(crate) fn open_pieces(file: &InputFile, sources: &[String], mode: IoMode) -> Result<Dataset, Error> {
    let folder = file.path().parent().unwrap_or_else(|| "".as_ref());
    let mut whole = Dataset::default();
    for (i, source) in sources.iter().enumerate() {
        let path = listed(folder, source);
        let piece = InputFile::open(&path, mode).and_then(|piece| match Format::sniff(&piece)? {
            Format::Legacy => legacy::parse(&piece),
            Format::Xml => match xml::parse(&piece)? {
                Document::Dataset(dataset) => Ok(dataset),
                Document::Parallel(_) | Document::Collection(_) => {
                    Err(Error::unsupported(&path, "a list of files where a piece with points is expected"))
                }
            },
            Format::SeriesJson => Err(Error::unsupported(&path, "a series where a piece is expected")),
        });
        let piece =
            piece.map_err(|e| Error::malformed(file.path(), format_args!("piece {i} ({source})"), e))?;
        whole.time = whole.time.or(piece.time);
        whole.pieces.extend(piece.pieces);
    }
    Ok(whole)
}
