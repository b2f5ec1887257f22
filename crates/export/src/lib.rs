//! Pictures, numbered sequences and films on disk. Every file is written beside its final name and renamed when it is complete,
//! so that a kill at any moment leaves no half file under the final name.
//!
//! A still is one call, [`write_still`]; a film takes one picture after the other ([`Film`]). What kind of file it becomes is
//! said by the ending of its name ([`Format`]).

mod beside;
mod error;
mod film;
mod format;
mod pattern;
mod rate;
mod still;
mod text;

pub use error::ExportError;
pub use film::{DEFAULT_FILM_QUALITY, Encoder, Film, FilmOptions, FinishedFilm, film_size, open_film};
pub use format::Format;
pub use pattern::OutputPattern;
pub use rate::FrameRate;
pub use still::{DEFAULT_JPEG_QUALITY, Still, StillOptions, note_of, read_still, write_still};
pub use text::write_text;
