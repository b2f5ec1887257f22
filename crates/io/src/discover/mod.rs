//! Which files make a series, and in which order.

mod collection;
mod gaps;
mod groups;
pub(crate) mod names;

use std::path::{Path, PathBuf};

use meniscus_core::Choice;

use crate::format::Format;
use crate::format::xml::{self, Document};
use crate::input_file::InputFile;
use crate::{Error, IoMode};

/// One time of a series.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TimeStep {
    pub time: Option<f64>,
    /// Its parts; at least one.
    pub files: Vec<PathBuf>,
}

/// A series and the choices made on the way.
pub(crate) struct Found {
    pub steps: Vec<TimeStep>,
    pub choices: Vec<Choice>,
}

/// Finds the series that `input` means: a particle file, a collection, a folder, a glob, or a printf-like pattern.
pub(crate) fn discover(input: &Path) -> Result<Found, Error> {
    if input.is_dir() {
        return folder(input);
    }
    if input.exists() {
        return file(input);
    }
    let text = input.to_string_lossy();
    if let Some(pattern) = names::NumberPattern::parse(input) {
        return numbered(input, &pattern);
    }
    if text.contains(['*', '?', '[']) {
        return glob(input, &text);
    }
    Err(Error::NotFound { file: input.to_owned() })
}

fn file(path: &Path) -> Result<Found, Error> {
    // Little of it is looked at, whatever it is; nothing is gained by a map.
    let file = InputFile::open(path, IoMode::Read)?;
    let steps = match Format::sniff(&file)? {
        Format::SeriesJson => collection::from_json(&file)?,
        Format::Xml if looks_like_collection(&file)? => match xml::parse(&file)? {
            Document::Collection(entries) => collection::from_entries(&file, &entries)?,
            _ => vec![TimeStep { time: None, files: vec![path.to_owned()] }],
        },
        // Of packed files only those with points are read.
        Format::Xml | Format::Legacy | Format::Bgeo | Format::Ply | Format::Table | Format::Gzip => {
            vec![TimeStep { time: None, files: vec![path.to_owned()] }]
        }
    };
    Ok(Found { steps, choices: Vec::new() })
}

/// Whether the root element speaks of a collection; a data set is not scanned to its end just to be opened.
fn looks_like_collection(file: &InputFile) -> Result<bool, Error> {
    Ok(file.head(1024)?.windows(10).any(|word| word == b"Collection"))
}

fn list(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let io = |e: std::io::Error| Error::io(folder, &e);
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io)? {
        let path = entry.map_err(io)?.path();
        if path.is_file() {
            files.push(path);
        }
    }
    Ok(files)
}

fn folder(folder: &Path) -> Result<Found, Error> {
    groups::choose(folder, list(folder)?)
}

fn glob(input: &Path, pattern: &str) -> Result<Found, Error> {
    let paths = glob::glob(pattern)
        .map_err(|e| Error::usage(format_args!("the pattern {pattern:?} cannot be understood: {e}")))?;
    let files = paths.filter_map(Result::ok).filter(|path| path.is_file()).collect();
    groups::choose(input, files)
}

fn numbered(input: &Path, pattern: &names::NumberPattern) -> Result<Found, Error> {
    let folder = input.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or_else(|| ".".as_ref());
    let mut files: Vec<(u64, PathBuf)> = list(folder)?
        .into_iter()
        .filter_map(|path| {
            let number = pattern.number_of(&path.file_name()?.to_string_lossy())?;
            Some((number, path))
        })
        .collect();
    files.sort();
    if files.is_empty() {
        return Err(Error::Empty {
            file: input.to_owned(),
            message: "no file fits this pattern; expected e.g. frame_0001.vtu for frame_%04d.vtu".into(),
        });
    }
    let steps: Vec<_> =
        files.into_iter().map(|(_, path)| TimeStep { time: None, files: vec![path] }).collect();
    let choices = gaps::describe(&steps).into_iter().collect();
    Ok(Found { steps, choices })
}
