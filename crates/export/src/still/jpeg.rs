use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError};

use super::{EncodeError, Sink, Still, channels};

/// Markers of the image's start and end and of a comment segment (ITU-T T.81, table B.1).
const START: [u8; 2] = [0xff, 0xd8];
const END: [u8; 2] = [0xff, 0xd9];
const COMMENT: [u8; 2] = [0xff, 0xfe];

/// Writes display pixels; alpha is left out.
pub(super) fn encode(
    mut file: impl Sink,
    still: &Still<'_>,
    pixels: &[u32],
    quality: u8,
) -> Result<(), EncodeError> {
    let mut bytes = compress(still.size, pixels, quality)?;
    if !still.note.is_empty() {
        let comment = comment(still.note)?;
        bytes.splice(START.len()..START.len(), comment);
    }
    Ok(file.write_all(&bytes)?)
}

/// The bytes of a baseline JPEG file.
pub(crate) fn compress(size: [u32; 2], pixels: &[u32], quality: u8) -> Result<Vec<u8>, EncodeError> {
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, quality)
        .write_image(&channels(pixels, false), size[0], size[1], ExtendedColorType::Rgb8)
        .map_err(|error| match error {
            ImageError::IoError(source) => EncodeError::Io(source),
            other => EncodeError::Encoder(other.to_string()),
        })?;
    Ok(bytes)
}

/// A comment segment with `note`, whose length counts itself.
fn comment(note: &str) -> Result<Vec<u8>, EncodeError> {
    let length = u16::try_from(note.len() + 2)
        .map_err(|_| EncodeError::Encoder("a comment has at most 65533 bytes".into()))?;
    Ok([&COMMENT, &length.to_be_bytes()[..], note.as_bytes()].concat())
}

/// The first comment of a JPEG file of these bytes, if it has its end: decoders fill up what is missing.
pub(super) fn whole_with_comment(bytes: &[u8]) -> Option<String> {
    let mut rest = bytes.strip_prefix(&START)?.strip_suffix(&END)?;
    loop {
        let ([marker @ .., high, low], after) = rest.split_first_chunk::<4>()?;
        let length = usize::from(u16::from_be_bytes([*high, *low])).checked_sub(2)?;
        let content = after.get(..length)?;
        if *marker == COMMENT {
            return String::from_utf8(content.to_vec()).ok();
        }
        // Behind the header of the scan come the pixels.
        if marker[0] != 0xff || marker[1] == 0xda {
            return None;
        }
        rest = &after[length..];
    }
}
