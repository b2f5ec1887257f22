//! Flags about films and how pictures are written.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use meniscus_export::{DEFAULT_FILM_QUALITY, DEFAULT_JPEG_QUALITY, Encoder, FrameRate};

use crate::failure::Failure;
use crate::values::{BitRate, Shard};

/// Pictures per second of films, unless something else is asked for.
pub const DEFAULT_RATE: FrameRate = FrameRate::whole(24);

/// How pictures and films are encoded; shared by `render` and `join`.
#[derive(Clone, Debug, Args)]
pub struct EncodingArgs {
    /// Pictures per second of a film, like 24, 29.97 or 30000/1001 [default: 24].
    #[arg(long, value_name = "RATE")]
    pub fps: Option<FrameRate>,

    /// Quality of JPEG pictures and films, 1 to 100, the same for every picture [default: 92 for .jpg and .avi, 85 for others].
    #[arg(long, value_name = "1..100", value_parser = clap::value_parser!(u8).range(1..=100))]
    pub quality: Option<u8>,

    /// Bits per second of a film instead of a quality, like 8M.
    #[arg(long, value_name = "BITS", conflicts_with = "quality")]
    pub bitrate: Option<BitRate>,

    /// Who encodes films: what is built in (.mp4 with H.264 up to 3840x2160, .avi with Motion JPEG), or the program ffmpeg where
    /// it is installed (also .mkv, .mov, .webm, more codecs, any size).
    #[arg(long, value_enum, default_value_t = EncoderArg::Builtin)]
    pub encoder: EncoderArg,

    /// ffmpeg's name of the codec, like libx265 or prores_ks [default: that of the container].
    #[arg(long, value_name = "NAME")]
    pub codec: Option<String>,
}

/// `--encoder`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EncoderArg {
    /// What is built in.
    Builtin,
    /// The program ffmpeg.
    Ffmpeg,
}

impl EncodingArgs {
    /// Who encodes.
    pub fn encoder(&self) -> Result<Encoder, Failure> {
        match (self.encoder, &self.codec) {
            (EncoderArg::Ffmpeg, codec) => Ok(Encoder::Ffmpeg { codec: codec.clone() }),
            (EncoderArg::Builtin, None) => Ok(Encoder::BuiltIn),
            (EncoderArg::Builtin, Some(codec)) => Err(Failure::Usage(format!(
                "--codec {codec}: only ffmpeg has a choice; add --encoder ffmpeg"
            ))),
        }
    }

    /// Pictures per second.
    pub fn rate(&self) -> FrameRate {
        self.fps.unwrap_or(DEFAULT_RATE)
    }

    /// Quality of films, of Motion JPEG or another.
    pub fn film_quality(&self, is_jpeg: bool) -> u8 {
        self.quality.unwrap_or(if is_jpeg { DEFAULT_JPEG_QUALITY } else { DEFAULT_FILM_QUALITY })
    }

    /// Quality of JPEG pictures.
    pub fn still_quality(&self) -> u8 {
        self.quality.unwrap_or(DEFAULT_JPEG_QUALITY)
    }
}

/// Which moments are shown, and by whom they are drawn.
#[derive(Clone, Debug, Args)]
pub struct TimeArgs {
    /// Seconds of the simulation in a second of film [default: one picture for the usual step between frames]. With --fps, --speed
    /// or --interpolate, numbered pictures run on the time of the simulation as films do; else each frame is one.
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true, value_parser = crate::values::positive)]
    pub speed: Option<f64>,

    /// Between frames, move particles on curves by their ids and velocities instead of holding the nearest frame.
    #[arg(long)]
    pub interpolate: bool,

    /// Draw the i-th of n shares of the pictures, from 1: every n-th picture. Put together by `meniscus join`.
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,

    /// Leave out pictures that are there already, whole, of these settings and not older than their data.
    #[arg(long)]
    pub resume: bool,
}

/// Pictures that are the mean of several.
#[derive(Clone, Debug, Args)]
pub struct ExposureArgs {
    /// Draw every picture N times, parts of a pixel aside, and take the mean light: smooth edges in every format [default: 16 with
    /// --motion-blur or --aperture, else 1].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub samples: Option<u32>,

    /// Blur what moves, as a shutter does that is open for this share of the time between two pictures (0.5 is that of film
    /// cameras), with particles and camera on their way as with --interpolate.
    #[arg(long, value_name = "0..1", allow_negative_numbers = true, value_parser = crate::values::shutter)]
    pub motion_blur: Option<f64>,

    /// Blur what is out of focus, through a lens of this diameter in the file's unit.
    #[arg(long, value_name = "DIAMETER", allow_negative_numbers = true, value_parser = crate::values::positive)]
    pub aperture: Option<f64>,

    /// Distance from the eye that is in focus [default: that of the point looked at].
    #[arg(long, value_name = "DISTANCE", requires = "aperture", allow_negative_numbers = true, value_parser = crate::values::positive)]
    pub focus: Option<f64>,
}

/// How many pictures make one that is blurred, unless something else is asked for.
const BLUR_SAMPLES: u32 = 16;

impl ExposureArgs {
    /// How many pictures make one.
    pub fn samples(&self) -> u32 {
        let is_blurred = self.motion_blur.is_some() || self.aperture.is_some();
        self.samples.unwrap_or(if is_blurred { BLUR_SAMPLES } else { 1 })
    }
}

/// `meniscus join`.
#[derive(Debug, Args)]
pub struct JoinArgs {
    /// Numbered pictures (.png, .jpg): patterns like out_%04d.png, folders, or files; put in order by their numbers.
    #[arg(required = true, value_name = "PICTURES")]
    pub inputs: Vec<PathBuf>,

    /// Film to write.
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,

    /// How the film is encoded.
    #[command(flatten)]
    pub encoding: EncodingArgs,
}
