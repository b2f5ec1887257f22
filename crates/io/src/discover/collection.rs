use serde::Deserialize;

use super::TimeStep;
use crate::Error;
use crate::format;
use crate::format::xml::CollectionEntry;
use crate::input_file::InputFile;

/// ParaView's `.series` file.
#[derive(Deserialize)]
struct SeriesFile {
    files: Vec<SeriesEntry>,
}

#[derive(Deserialize)]
struct SeriesEntry {
    name: String,
    time: Option<f64>,
}

pub(super) fn from_json(file: &InputFile) -> Result<Vec<TimeStep>, Error> {
    let text = file.head(file.len())?;
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&text);
    let series: SeriesFile = serde_json::from_slice(text).map_err(|e| {
        Error::malformed(
            file.path(),
            format_args!("line {}, column {}", e.line(), e.column()),
            format_args!("not a .series file ({e})"),
        )
    })?;
    let entries: Vec<CollectionEntry> = series
        .files
        .into_iter()
        .map(|entry| CollectionEntry { time: entry.time, part: 0, file: entry.name })
        .collect();
    from_entries(file, &entries)
}

/// Steps in the order of time; entries of the same time are its parts, as are all entries without a time.
pub(super) fn from_entries(file: &InputFile, entries: &[CollectionEntry]) -> Result<Vec<TimeStep>, Error> {
    let folder = file.path().parent().unwrap_or_else(|| "".as_ref());
    let mut entries: Vec<&CollectionEntry> = entries.iter().collect();
    let finite = |entry: &CollectionEntry| entry.time.filter(|time| time.is_finite());
    // No time sorts first; the sort is stable, so parts with equal numbers keep the order of the file.
    entries.sort_by(|a, b| {
        let key = |entry: &CollectionEntry| finite(entry).unwrap_or(f64::NEG_INFINITY);
        key(a).total_cmp(&key(b)).then(a.part.cmp(&b.part))
    });
    let mut steps: Vec<TimeStep> = Vec::new();
    for entry in entries {
        let path = format::listed(folder, &entry.file);
        if path.file_name() == file.path().file_name() && path.parent() == file.path().parent() {
            return Err(Error::malformed(file.path(), "its list of files", "the file names itself"));
        }
        match steps.last_mut().filter(|step| step.time == finite(entry)) {
            Some(step) => step.files.push(path),
            None => steps.push(TimeStep { time: finite(entry), files: vec![path] }),
        }
    }
    if steps.is_empty() {
        return Err(Error::Empty {
            file: file.path().to_owned(),
            message: "the series lists no file".into(),
        });
    }
    Ok(steps)
}
