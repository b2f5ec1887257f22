//! Films: one picture after the other, at a constant rate.

mod avi;
mod boxes;
mod even;
mod ffmpeg;
mod h264;
mod mp4;
mod planes;
mod spool;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use self::avi::AviFilm;
use self::ffmpeg::FfmpegFilm;
use self::mp4::Mp4Film;
use crate::{ExportError, Format, FrameRate};

/// Quality of films, 1 to 100, unless something else is asked for: hardly to be told from the pictures.
pub const DEFAULT_FILM_QUALITY: u8 = 85;

/// Who encodes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Encoder {
    /// What is built in: H.264 in `.mp4`, Motion JPEG in `.avi`.
    #[default]
    BuiltIn,
    /// The program `ffmpeg`, as it is installed.
    Ffmpeg {
        /// Its name for the codec; `None`: the usual one of the container.
        codec: Option<String>,
    },
}

/// What a film is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmOptions {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Pictures per second.
    pub rate: FrameRate,
    /// Pictures that will follow, at least as many as come.
    pub pictures: u64,
    /// 1 to 100, the same for all pictures.
    pub quality: u8,
    /// Bits per second to keep to instead of a quality, where the encoder can.
    pub bits_per_second: Option<u32>,
    /// Who encodes.
    pub encoder: Encoder,
}

/// A film being written. Dropped before it is finished, nothing of it is left.
pub trait Film {
    /// Appends a picture: sRGB, red in the lowest byte, row by row from the top left, of the film's size. Alpha is ignored.
    ///
    /// # Errors
    /// The encoder's or the system's. What was appended before is still good for [`Self::finish`].
    fn push(&mut self, pixels: &[u32]) -> Result<(), ExportError>;

    /// Completes the film with what was appended and gives it the name `path`: its own, or another one where it is not all
    /// that was wanted.
    ///
    /// # Errors
    /// The system's; nothing is left of the film then.
    fn finish(self: Box<Self>, path: &Path) -> Result<FinishedFilm, ExportError>;
}

/// What became of a film.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FinishedFilm {
    /// Its file.
    pub path: PathBuf,
    /// Pictures in it.
    pub pictures: u64,
}

/// Begins a film that will lie at `path`, of the kind that its name ends in. Missing folders are made.
///
/// # Errors
/// [`ExportError::Unsuitable`] for what the encoder cannot do, [`ExportError::NoFfmpeg`], or the system's.
pub fn open_film(path: &Path, options: &FilmOptions) -> Result<Box<dyn Film>, ExportError> {
    let unsuitable = |message: String| ExportError::Unsuitable { path: path.to_owned(), message };
    let format = Format::of(path)?;
    match (format, &options.encoder) {
        (Format::Png | Format::Jpeg | Format::Exr, _) => {
            Err(unsuitable("this is a format of single pictures; films are .mp4 and .avi".into()))
        }
        (_, Encoder::Ffmpeg { codec }) => {
            Ok(Box::new(FfmpegFilm::open(path, format, codec.as_deref(), options)?))
        }
        (Format::Mp4, Encoder::BuiltIn) => Ok(Box::new(Mp4Film::open(path, options)?)),
        (Format::Avi, Encoder::BuiltIn) if options.bits_per_second.is_some() => {
            Err(unsuitable("Motion JPEG has a quality, no bit rate; give --quality, or make an .mp4".into()))
        }
        (Format::Avi, Encoder::BuiltIn) => Ok(Box::new(AviFilm::open(path, options)?)),
        (Format::Mkv | Format::Mov | Format::Webm, Encoder::BuiltIn) => Err(unsuitable(
            "only ffmpeg writes this kind of film; add --encoder ffmpeg, or make an .mp4".into(),
        )),
    }
}

/// Width and height that a film of this format has in the end.
pub fn film_size(format: Format, options: &FilmOptions) -> [u32; 2] {
    match (format, &options.encoder) {
        (Format::Avi, Encoder::BuiltIn) => options.size,
        _ => even::even(options.size),
    }
}

/// What a quality from 1 to 100 is on the scale of H.264's quantiser: 45 for the least, 12 for the best, 17 for the default.
fn quantiser(quality: u8) -> u8 {
    (45.0 - f64::from(quality) * 0.33).round() as u8
}
