use std::path::PathBuf;

use crate::Format;

/// Why an output could not be made.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The output's ending names no format that can be written.
    #[error(
        "{}: cannot write this kind of file; expected a name that ends in {}, found {found}", path.display(), Format::endings()
    )]
    UnknownFormat {
        /// The path given.
        path: PathBuf,
        /// Its ending.
        found: String,
    },
    /// Several frames, one name.
    #[error(
        "{}: {frames} frames cannot go into one image; give a pattern such as {}, a film such as {}, or pick one with --frame N",
        path.display(), suggestion.display(), path.with_extension("mp4").display()
    )]
    NeedsPattern {
        /// The path given.
        path: PathBuf,
        /// Number of frames asked for.
        frames: usize,
        /// The path with `_%04d` in it.
        suggestion: PathBuf,
    },
    /// The pattern is not of the form that is understood.
    #[error("{}: expected one %d or %0Nd (N from 1 to 9) in the file name, found {found}; write a literal % as %%", path.display())]
    BadPattern {
        /// The path given.
        path: PathBuf,
        /// The part that is not understood.
        found: String,
    },
    /// The format cannot hold what was asked for.
    #[error("{}: {message}", path.display())]
    Unsuitable {
        /// The output.
        path: PathBuf,
        /// What does not fit, and what does.
        message: String,
    },
    /// The program that was asked to encode is not there.
    #[error(
        "{}: the program `ffmpeg` was not found; install it (Debian: apt-get install -y --no-install-recommends ffmpeg) or leave \
         out --encoder ffmpeg, which .mp4 and .avi do not need", path.display()
    )]
    NoFfmpeg {
        /// The output.
        path: PathBuf,
    },
    /// The system refused.
    #[error("{}: cannot be written: {source}; nothing is left under this name", path.display())]
    Io {
        /// The output.
        path: PathBuf,
        /// The system's words.
        source: std::io::Error,
    },
    /// The encoder refused.
    #[error("{}: cannot be encoded: {message}", path.display())]
    Encode {
        /// The output.
        path: PathBuf,
        /// The encoder's words.
        message: String,
    },
    /// A picture that was to be read back is none.
    #[error("{}: cannot be read as a picture: {message}", path.display())]
    Unreadable {
        /// The picture.
        path: PathBuf,
        /// Why.
        message: String,
    },
}

impl ExportError {
    /// The file at fault.
    pub fn path(&self) -> &PathBuf {
        match self {
            Self::UnknownFormat { path, .. }
            | Self::NeedsPattern { path, .. }
            | Self::BadPattern { path, .. }
            | Self::Unsuitable { path, .. }
            | Self::NoFfmpeg { path }
            | Self::Io { path, .. }
            | Self::Encode { path, .. }
            | Self::Unreadable { path, .. } => path,
        }
    }
}
