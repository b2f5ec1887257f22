//! Everything that ends a command early.

use std::{io, path::PathBuf};

/// Why a command did not succeed. Each is printed once, by `main`.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error("`{command}` could not be started: {source}; is `{program}` installed and on PATH?")]
    Start { command: String, program: String, source: io::Error },

    #[error("`{command}` failed ({status})")]
    Failed { command: String, status: String },

    #[error("the workspace could not be read with `cargo metadata`: {0}")]
    Metadata(#[from] cargo_metadata::Error),

    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: io::Error },

    #[error("the output of `{command}` could not be read: {source}")]
    Output { command: String, source: io::Error },

    #[error("{missing}\ninstall with:\n    {install}\nor let this command do it: add --install")]
    Missing { missing: String, install: String },

    #[error(
        "{variable} is set, so only the drivers it names are used, and none of them is there: correct or unset it"
    )]
    NoSuchDriver { variable: &'static str },

    #[error("{0} is still missing after the installation; see the output of apt-get above")]
    StillMissing(String),

    #[error("{failed} of {total} checks failed: {names}")]
    Checks { failed: usize, total: usize, names: String },

    #[error("{}: was to be written, but is missing or empty", path.display())]
    NotWritten { path: PathBuf },

    #[error("{}: {source}", path.display())]
    Toml { path: PathBuf, source: Box<toml::de::Error> },

    #[error("{}: {source}", path.display())]
    Json { path: PathBuf, source: serde_json::Error },

    #[error("cargo built no program `{0}`; is it still in tests/Cargo.toml?")]
    NoProgram(&'static str),

    #[error("the sabotages cannot be tried:\n  {0}")]
    Sabotages(String),

    #[error("no bench measures a stage called '{name}'; there are: {stages}")]
    NoSuchStage { name: String, stages: String },

    #[error(
        "no baseline '{name}' of {stages}; saved: {saved}. Save one with `cargo xtask bench --save {name}` first"
    )]
    NoBaseline { name: String, stages: String, saved: String },

    #[error("{}, line {line}: {source}; the file is from another version, measure and save it again", path.display())]
    Record { path: PathBuf, line: usize, source: serde_json::Error },

    #[error(
        "{package} left no record of what it measured; its benches have to go through `bench_views::Stage` as '{stage}'"
    )]
    NothingMeasured { package: String, stage: String },

    #[error("{0}")]
    NoPeer(String),

    #[error("{}: the tools read different numbers of points: {}", file.display(), points.iter().map(u64::to_string).collect::<Vec<_>>().join(", "))]
    UnlikePeers { file: PathBuf, points: Vec<u64> },

    #[error("the output of `{command}` is not the JSON that was expected: {source}")]
    Unexpected { command: String, source: serde_json::Error },

    /// The report has said so already, and its last line is to stay the last.
    #[error("tests failed")]
    TestsReported,
}

/// What every command returns.
pub type Result<T> = std::result::Result<T, Error>;
