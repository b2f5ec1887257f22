use meniscus_core::Pixels;
use png::{BitDepth, ColorType, Compression, Encoder, EncodingError, Filter};

use super::{EncodeError, NOTE_KEY, Sink, Still, channels};

/// Writes display pixels of 8 or 16 bits.
pub(super) fn encode(file: impl Sink, still: &Still<'_>) -> Result<(), EncodeError> {
    let [width, height] = still.size;
    let mut encoder = Encoder::new(file, width, height);
    encoder.set_color(if still.with_alpha { ColorType::Rgba } else { ColorType::Rgb });
    // A sequence is written while the next picture waits: the fastest that still compresses.
    encoder.set_compression(Compression::Fast);
    encoder.set_filter(Filter::Adaptive);
    let bytes = match still.pixels {
        Pixels::Display16(pixels) => {
            encoder.set_depth(BitDepth::Sixteen);
            let taken = if still.with_alpha { 4 } else { 3 };
            pixels.iter().flat_map(|p| p[..taken].iter().flat_map(|c| c.to_be_bytes())).collect()
        }
        Pixels::Display8(pixels) => {
            encoder.set_depth(BitDepth::Eight);
            channels(pixels, still.with_alpha)
        }
        Pixels::Linear(_) => return Err(EncodeError::Encoder("linear pixels are no display image".into())),
    };
    if !still.note.is_empty() {
        encoder.add_text_chunk(NOTE_KEY.into(), still.note.into()).map_err(refused)?;
    }
    let mut writer = encoder.write_header().map_err(refused)?;
    writer.write_image_data(&bytes).map_err(refused)?;
    writer.finish().map_err(refused)
}

fn refused(error: EncodingError) -> EncodeError {
    match error {
        EncodingError::IoError(source) => EncodeError::Io(source),
        other => EncodeError::Encoder(other.to_string()),
    }
}
