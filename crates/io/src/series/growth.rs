//! What becomes of a series on disk after it was opened.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::PathBuf;
use std::sync::Arc;

use super::times;
use crate::Error;
use crate::discover::{Found, TimeStep, discover};

/// Where a series is found.
pub(super) struct Place {
    pub input: PathBuf,
    /// Time between frames that state none.
    pub time_step: Option<f64>,
}

impl Place {
    /// The series as it is on disk now.
    pub fn look(&self) -> Result<Found, Error> {
        let mut found = discover(&self.input)?;
        if let Some(time_step) = self.time_step {
            times::apply(&mut found.steps, time_step);
        }
        Ok(found)
    }
}

/// What of `found` comes after the last of `known`. Nothing where that is not found again: then it is another series, or a
/// collection file that is just being written.
pub(super) fn added(known: &[Arc<TimeStep>], mut found: Vec<TimeStep>) -> Vec<TimeStep> {
    let Some(last) = known.last() else { return found };
    match found.iter().position(|step| step.files == last.files && step.time == last.time) {
        Some(place) => found.split_off(place + 1),
        None => Vec::new(),
    }
}

/// A number that changes when one of `files` is written to, replaced, removed or made.
pub(super) fn version(files: &[PathBuf]) -> u64 {
    let mut hasher = DefaultHasher::new();
    for file in files {
        let metadata = std::fs::metadata(file).ok();
        metadata.map(|metadata| (metadata.len(), metadata.modified().ok())).hash(&mut hasher);
    }
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(names: &[&str]) -> Vec<TimeStep> {
        names.iter().map(|name| TimeStep { time: None, files: vec![name.into()] }).collect()
    }

    fn added_to(known: &[&str], found: &[&str]) -> Vec<TimeStep> {
        let known: Vec<_> = steps(known).into_iter().map(Arc::new).collect();
        added(&known, steps(found))
    }

    #[test]
    fn only_what_comes_behind_is_added() {
        assert_eq!(added_to(&["a", "b"], &["a", "b", "c", "d"]), steps(&["c", "d"]));
        assert_eq!(added_to(&["a", "c"], &["a", "b", "c"]), []);
        assert_eq!(added_to(&["b"], &["a", "b"]), []);
        assert_eq!(added_to(&["a", "b"], &["x", "y", "z"]), [], "another series");
        let timed = vec![TimeStep { time: Some(0.5), files: vec!["a".into()] }];
        assert_eq!(added(&[Arc::new(steps(&["a"]).remove(0))], timed), [], "a collection instead of files");
    }
}
