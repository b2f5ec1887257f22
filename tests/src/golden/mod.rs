//! Expected images: what the program drew when somebody looked at it and found it right.
//!
//! `cases.toml` lists what is drawn and why, `expected/` holds the pictures with their masks, `expected/manifest.toml` what
//! made them. Nothing here writes an expectation but [`Runner::update`].

mod case;
mod compare;
mod expected;
mod flicker;
mod metrics;
mod outcome;
mod runner;

pub use case::{Case, Cases};
pub use compare::{CompareError, Comparison, Criteria, Limit, Metric, compare};
pub use expected::{Expected, Manifest, Origin};
pub use flicker::{Flicker, flicker};
pub use metrics::{flip_map, heat_map, percentile, ssim_map};
pub use outcome::{CaseOutcome, Pictures, RunOutcome, StageTime, Status};
pub use runner::Runner;

use std::path::PathBuf;

/// Why the expected images could not be used.
#[derive(Debug, thiserror::Error)]
pub enum GoldenError {
    /// A file cannot be read or written.
    #[error("{}: {message}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// What happened, and what to do about it.
        message: String,
    },
    /// A case was asked for that does not exist.
    #[error("no case `{name}`; there are {known}")]
    NoSuchCase {
        /// What was asked for.
        name: String,
        /// All names.
        known: String,
    },
    /// The program did not draw.
    #[error("`{command}` ended with {code}: {message}")]
    Program {
        /// What was run.
        command: String,
        /// Its exit code.
        code: String,
        /// What it said.
        message: String,
    },
    /// Somebody would have to have looked at a picture first.
    #[error("no expected image; look at the picture, then `cargo xtask e2e --update {0}`")]
    NoReference(String),
    /// The pictures cannot be compared.
    #[error(transparent)]
    Compare(#[from] CompareError),
}
