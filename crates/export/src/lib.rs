//! Images and numbered image sequences on disk. Every file is written beside its final name and renamed when it is
//! complete, so that a kill at any moment leaves no half file under the final name.

mod pattern;
mod png;
mod text;

pub use pattern::OutputPattern;
pub use png::write_png;
pub use text::write_text;

use std::path::PathBuf;

/// Why an output could not be made.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The output's ending names no format that can be written.
    #[error("{}: cannot write this kind of file; expected a name that ends in .png, found {found}", path.display())]
    UnknownFormat {
        /// The path given.
        path: PathBuf,
        /// Its ending.
        found: String,
    },
    /// Several frames, one name.
    #[error(
        "{}: {frames} frames cannot go into one image; give a pattern such as {}, or pick one with --frame N",
        path.display(), suggestion.display()
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
}
