use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use super::{NOTE_KEY, exr, jpeg};
use crate::{ExportError, Format};

/// Reads a display image back with 8 bits per channel, alpha included, and its size: what a film is joined from. PNG and JPEG.
///
/// # Errors
/// [`ExportError::Unreadable`] when it is missing, not whole, or of another format.
pub fn read_still(path: &Path) -> Result<([u32; 2], Vec<u32>), ExportError> {
    let unreadable = |message: String| ExportError::Unreadable { path: path.to_owned(), message };
    if !matches!(Format::of(path)?, Format::Png | Format::Jpeg) {
        return Err(unreadable("films are joined from .png and .jpg".into()));
    }
    let image = image::open(path).map_err(|e| unreadable(e.to_string()))?.into_rgba8();
    let size = [image.width(), image.height()];
    Ok((size, image.pixels().map(|p| u32::from_le_bytes(p.0)).collect()))
}

/// The note in the picture at `path`, if that is whole and of `size` pixels.
pub fn note_of(path: &Path, size: [u32; 2]) -> Option<String> {
    let note = match Format::of(path).ok()? {
        Format::Png => png_note(path),
        Format::Jpeg => jpeg::whole_with_comment(&std::fs::read(path).ok()?),
        Format::Exr => exr::note(path),
        _ => None,
    }?;
    // Whole is what can be decoded to the end.
    let image = image::open(path).ok()?;
    ([image.width(), image.height()] == size).then_some(note)
}

fn png_note(path: &Path) -> Option<String> {
    let reader = png::Decoder::new(BufReader::new(File::open(path).ok()?)).read_info().ok()?;
    let texts = &reader.info().uncompressed_latin1_text;
    texts.iter().find(|chunk| chunk.keyword == NOTE_KEY).map(|chunk| chunk.text.clone())
}
