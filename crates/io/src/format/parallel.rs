//! Parallel files: a list of piece files.

use std::path::Path;

use crate::dataset::Dataset;
use crate::format::{Opened, listed};
use crate::{Error, IoMode};

/// Opens the pieces that `file` names, relative to its folder.
pub(crate) fn open_pieces(file: &Path, sources: &[String], mode: IoMode) -> Result<Dataset, Error> {
    let folder = file.parent().unwrap_or_else(|| "".as_ref());
    let mut whole = Dataset::default();
    for (i, source) in sources.iter().enumerate() {
        let path = listed(folder, source);
        let piece = Opened::at(&path, mode).and_then(|content| match content {
            Opened::Points(dataset) => Ok(dataset),
            Opened::Pieces(_) | Opened::Series => {
                Err(Error::unsupported(&path, "a list of files where a piece with points is expected"))
            }
        });
        let piece = piece.map_err(|e| Error::malformed(file, format_args!("piece {i} ({source})"), e))?;
        whole.time = whole.time.or(piece.time);
        whole.pieces.extend(piece.pieces);
    }
    Ok(whole)
}
