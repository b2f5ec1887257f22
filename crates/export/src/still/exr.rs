use std::path::Path;

use exr::error::Error;
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, Text};
use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, WritableImage, f16};

use super::{EncodeError, NOTE_KEY, Sink, Still};

/// Writes linear pixels as half floats, other channels as floats. With alpha, colours are multiplied by it, as the format has it.
pub(super) fn encode(file: impl Sink, still: &Still<'_>, pixels: &[[f32; 4]]) -> Result<(), EncodeError> {
    let channel = |name: &str, value: &dyn Fn(&[f32; 4]) -> f32| {
        let samples = pixels.iter().map(|pixel| f16::from_f32(value(pixel))).collect();
        AnyChannel::new(name, FlatSamples::F16(samples))
    };
    let mut channels: Vec<AnyChannel<FlatSamples>> = ["R", "G", "B"]
        .iter()
        .enumerate()
        .map(|(i, name)| channel(name, &|pixel| pixel[i] * if still.with_alpha { pixel[3] } else { 1.0 }))
        .collect();
    if still.with_alpha {
        channels.push(channel("A", &|pixel| pixel[3]));
    }
    for extra in still.channels {
        // Distances need more digits than halves have.
        channels.push(AnyChannel::new(extra.name.as_str(), FlatSamples::F32(extra.values.clone())));
    }
    let size = still.size.map(|side| side as usize);
    let channels = AnyChannels::sort(channels.into());
    let mut image = Image::from_encoded_channels((size[0], size[1]), Encoding::FAST_LOSSLESS, channels);
    let note = AttributeValue::Text(Text::from(still.note));
    image.layer_data.attributes.other.insert(Text::from(NOTE_KEY), note);
    image.write().to_buffered(file).map_err(|error| match error {
        Error::Io(source) => EncodeError::Io(source),
        other => EncodeError::Encoder(other.to_string()),
    })
}

/// The note in the header of the file at `path`.
pub(super) fn note(path: &Path) -> Option<String> {
    let meta = MetaData::read_from_file(path, false).ok()?;
    match meta.headers.first()?.own_attributes.other.get(&Text::from(NOTE_KEY))? {
        AttributeValue::Text(text) => Some(text.to_string()),
        _ => None,
    }
}
