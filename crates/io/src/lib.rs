//! Readers for particle files (VTK, `.bgeo`, `.ply`, tables in text) and their series, and a small writer.
//!
//! [`Series::open`] takes what users have: a file, a `.pvd` or `.series` file, a folder, a glob or a pattern. Files are
//! memory-mapped or read in blocks; only positions, identities and the attributes asked for are decoded, straight to the type
//! wanted.
//!
//! Layers, bottom first: `input_file` gives ranges of a file and `forward` walks through it, `codec` and `scalar` turn bytes
//! into numbers, `array` knows where an array's bytes lie, `format`
//! finds the arrays of a file, `dataset` and `frame_data` put pieces and parts together, `discover` finds the files of a
//! series, `analysis` finds out what users were not asked, and `series` is what everybody else sees.

#![forbid(unsafe_code)]

mod analysis;
mod array;
mod codec;
mod dataset;
mod discover;
mod error;
pub mod expression;
mod filter;
mod format;
mod forward;
mod frame_data;
mod info;
mod input_file;
mod options;
mod scalar;
mod series;
mod sink;
pub mod writer;

pub use error::Error;
pub use filter::Region;
pub use info::{AttributeSummary, FrameInfo, SetSummary, ValueCount};
pub use meniscus_map_guard as map_guard;
pub use options::{IoMode, SeriesOptions, SetSpec};
pub use series::{Follow, Series};
pub use sink::Sink;
