//! H.264 by OpenH264, with colours as in BT.709.

use std::path::{Path, PathBuf};

use openh264::encoder::{
    BitRate, Complexity, EncodedBitStream, Encoder, EncoderConfig, FrameRate, FrameType, IntraFramePeriod,
    QpRange, RateControlMode, VuiConfig,
};
use openh264::formats::YUVSlices;
use openh264::{OpenH264API, Timestamp};
use openh264_sys2::{ENCODER_OPTION_TRACE_LEVEL, WELS_LOG_QUIET};

use super::boxes::Boxes;
use super::even::even;
use super::planes::Planes;
use super::{FilmOptions, quantiser};
use crate::ExportError;

/// The encoder refuses more, one way or the other.
const LARGEST: [u32; 2] = [3840, 2160];
/// And less: a macroblock.
const SMALLEST: u32 = 16;
/// Seconds between pictures that need no other, to which players can jump.
const SECONDS_BETWEEN_KEYS: f64 = 2.0;
/// With a constant quality the rate follows from it. The encoder still wants to hear one, from which it takes the level that it
/// writes into the film: old players refuse high ones. Water takes about a third of a bit a pixel.
const BITS_PER_PIXEL: f64 = 0.5;
/// What the highest level allows (ITU-T H.264, table A-1), bits per second.
const MOST_BITS: f64 = 240e6;

/// Types of NAL units (ITU-T H.264, table 7-1).
const SEQUENCE_PARAMETERS: u8 = 7;
const PICTURE_PARAMETERS: u8 = 8;

/// An encoder for pictures of one size.
pub(super) struct H264 {
    encoder: Encoder,
    planes: Planes,
    milliseconds: f64,
    time: f64,
    path: PathBuf,
}

/// A picture, encoded.
pub(super) struct AccessUnit {
    /// NAL units, each after its length in 32 bits; no parameter sets.
    pub bytes: Vec<u8>,
    /// Whether it needs no other picture.
    pub is_key: bool,
    /// With key pictures.
    pub parameters: Option<ParameterSets>,
}

/// What a decoder has to know before the first picture.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct ParameterSets {
    sequence: Vec<u8>,
    picture: Vec<u8>,
}

impl ParameterSets {
    /// Content of an `avcC` box (ISO/IEC 14496-15, 5.3.3.1).
    pub fn write(&self, avcc: &mut Boxes) {
        avcc.u8(1);
        // Profile, its constraints and level are the first bytes of the sequence's parameters, behind the type of the unit.
        avcc.raw(self.sequence.get(1..4).unwrap_or(&[66, 0, 30]));
        // Lengths of four bytes, one set of parameters each.
        avcc.u8(0xff).u8(0xe1).u16(self.sequence.len() as u16).raw(&self.sequence);
        avcc.u8(1).u16(self.picture.len() as u16).raw(&self.picture);
        if self.sequence.get(1).is_some_and(|profile| ![66, 77, 88].contains(profile)) {
            // 4:2:0 with 8 bits, no extensions.
            avcc.u8(0xfd).u8(0xf8).u8(0xf8).u8(0);
        }
    }
}

impl H264 {
    /// For the film at `path`.
    pub fn new(path: &Path, options: &FilmOptions) -> Result<Self, ExportError> {
        let size = even(options.size);
        let (longer, shorter) = (size[0].max(size[1]), size[0].min(size[1]));
        if longer > LARGEST[0] || shorter > LARGEST[1] || shorter < SMALLEST {
            return Err(ExportError::Unsuitable {
                path: path.to_owned(),
                message: format!(
                    "the built-in encoder takes pictures from {SMALLEST}x{SMALLEST} to {}x{}, not {}x{}; choose another --size, \
                     an .avi, or --encoder ffmpeg",
                    LARGEST[0], LARGEST[1], options.size[0], options.size[1]
                ),
            });
        }
        let quantiser = quantiser(options.quality);
        let pixels_per_second = f64::from(size[0]) * f64::from(size[1]) * options.rate.per_second();
        let likely_bits = (pixels_per_second * BITS_PER_PIXEL).clamp(1e5, MOST_BITS) as u32;
        let base = EncoderConfig::new()
            .skip_frames(false)
            .complexity(Complexity::High)
            // Both save bits where they think that nobody looks; still water is such a place.
            .adaptive_quantization(false)
            .background_detection(false)
            .max_frame_rate(FrameRate::from_hz(options.rate.per_second() as f32))
            .intra_frame_period(IntraFramePeriod::from_num_frames(
                (options.rate.per_second() * SECONDS_BETWEEN_KEYS).ceil() as u32,
            ))
            .vui(VuiConfig::bt709());
        let config = match options.bits_per_second {
            Some(bits) => base.rate_control_mode(RateControlMode::Bitrate).bitrate(BitRate::from_bps(bits)),
            None => base
                .rate_control_mode(RateControlMode::Quality)
                .bitrate(BitRate::from_bps(likely_bits))
                .qp(QpRange::new(quantiser, quantiser)),
        };
        let mut encoder = Encoder::with_api_config(OpenH264API::from_source(), config)
            .map_err(|error| refused(path, error))?;
        hush(&mut encoder);
        Ok(Self {
            encoder,
            planes: Planes::new(size),
            milliseconds: 1000.0 / options.rate.per_second(),
            time: 0.0,
            path: path.to_owned(),
        })
    }

    /// Encodes a picture of the film's even size.
    pub fn encode(&mut self, pixels: &[u32]) -> Result<AccessUnit, ExportError> {
        self.planes.convert(pixels);
        let Planes { size: [width, height], brightness, blueness, redness } = &self.planes;
        let strides = (*width, width / 2, width / 2);
        let source = YUVSlices::new((brightness, blueness, redness), (*width, *height), strides);
        let time = Timestamp::from_millis(self.time.round() as u64);
        self.time += self.milliseconds;
        let stream = self.encoder.encode_at(&source, time).map_err(|error| refused(&self.path, error))?;
        let unit = access_unit(&stream);
        if unit.bytes.is_empty() {
            return Err(refused(&self.path, "the encoder left a picture out"));
        }
        Ok(unit)
    }
}

/// The encoder warns on standard error, whatever it was told, that it does not leave out pictures to keep a rate. It should not.
fn hush(encoder: &mut Encoder) {
    let mut level = WELS_LOG_QUIET;
    // SAFETY: the encoder is alive, and reads a number of this type before the call returns.
    unsafe {
        encoder.raw_api().set_option(ENCODER_OPTION_TRACE_LEVEL, (&raw mut level).cast());
    }
}

fn access_unit(stream: &EncodedBitStream<'_>) -> AccessUnit {
    let mut unit = AccessUnit {
        bytes: Vec::new(),
        is_key: matches!(stream.frame_type(), FrameType::IDR),
        parameters: None,
    };
    let mut parameters = ParameterSets::default();
    for layer in (0..stream.num_layers()).filter_map(|index| stream.layer(index)) {
        for nal in (0..layer.nal_count()).filter_map(|index| layer.nal_unit(index)) {
            let content = without_start_code(nal);
            match content.first().map(|byte| byte & 0x1f) {
                Some(SEQUENCE_PARAMETERS) => parameters.sequence = content.to_vec(),
                Some(PICTURE_PARAMETERS) => parameters.picture = content.to_vec(),
                Some(_) => {
                    unit.bytes.extend((content.len() as u32).to_be_bytes());
                    unit.bytes.extend(content);
                }
                None => {}
            }
        }
    }
    unit.parameters = (parameters != ParameterSets::default()).then_some(parameters);
    unit
}

/// Units begin with zeros and a one (ITU-T H.264, annex B).
fn without_start_code(nal: &[u8]) -> &[u8] {
    nal.strip_prefix(&[0, 0, 0, 1]).or_else(|| nal.strip_prefix(&[0, 0, 1])).unwrap_or(nal)
}

fn refused(path: &Path, error: impl std::fmt::Display) -> ExportError {
    ExportError::Encode { path: path.to_owned(), message: error.to_string() }
}
