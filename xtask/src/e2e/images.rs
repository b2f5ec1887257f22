//! What `image-cases` leaves in `images.json`. It is a program of its own so that xtask builds without the pipeline.

use std::path::Path;

use serde::Deserialize;

use crate::error::{Error, Result};

/// How a case ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    Passed,
    Failed,
    /// What is expected was replaced.
    Updated,
}

/// A value beside its limit.
#[derive(Debug, Clone, Deserialize)]
pub struct Metric {
    pub name: String,
    /// JSON has no word for what is not a number: `None` then.
    pub value: Option<f64>,
    pub limit: f64,
    pub reason: String,
    pub more_is_better: bool,
    pub passed: bool,
}

impl Metric {
    /// The value in four decimals, as far as it is a number.
    pub fn shown(&self) -> String {
        self.value.map_or("not a number".to_owned(), |value| format!("{value:.4}"))
    }
}

/// Names of files beside `images.json`.
#[derive(Debug, Clone, Default, Deserialize)]
pub struct Pictures {
    pub ours: Option<String>,
    pub expected: Option<String>,
    pub flip: Option<String>,
}

/// Time of a pass.
#[derive(Debug, Clone, Deserialize)]
pub struct StageTime {
    pub name: String,
    pub ms: f64,
}

/// What made an expected image.
#[derive(Debug, Clone, Deserialize)]
pub struct Origin {
    pub driver: String,
    pub version: String,
    pub commit: String,
    pub date: String,
}

/// A drawn and compared picture.
#[derive(Debug, Clone, Deserialize)]
pub struct Case {
    pub name: String,
    pub why: String,
    pub commands: [String; 2],
    pub status: Status,
    pub problem: Option<String>,
    pub metrics: Vec<Metric>,
    pub pictures: Pictures,
    pub stages: Vec<StageTime>,
    pub made_by: Option<Origin>,
    pub same_driver: bool,
    pub elapsed_s: f64,
}

/// All of them.
#[derive(Debug, Clone, Deserialize)]
pub struct Images {
    pub driver: String,
    pub version: String,
    pub commit: String,
    pub cases: Vec<Case>,
    /// Expected files that belong to no case.
    pub stale: Vec<String>,
}

/// Name of the file.
pub const FILE: &str = "images.json";

impl Images {
    /// Reads what the run left in `folder`.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(FILE);
        let text =
            std::fs::read_to_string(&path).map_err(|source| Error::File { path: path.clone(), source })?;
        serde_json::from_str(&text).map_err(|source| Error::Json { path, source })
    }

    /// Cases whose expected images were replaced.
    pub fn updated(&self) -> usize {
        self.cases.iter().filter(|case| case.status == Status::Updated).count()
    }

    /// Passed or updated cases; failed ones and stale files.
    pub fn counts(&self) -> (usize, usize) {
        let failed = self.cases.iter().filter(|case| case.status == Status::Failed).count();
        (self.cases.len() - failed, failed + self.stale.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stale_expectations_count_as_failures() {
        let json = r#"{"driver": "d", "version": "v", "commit": "c", "stale": ["old.png"], "cases": []}"#;
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(FILE), json).unwrap();
        assert_eq!(Images::read(folder.path()).unwrap().counts(), (0, 1));
    }

    #[test]
    fn what_is_not_the_file_is_an_error_with_its_path() {
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(Images::read(folder.path()), Err(Error::File { .. })));
        std::fs::write(folder.path().join(FILE), "{}").unwrap();
        assert!(Images::read(folder.path()).unwrap_err().to_string().contains("images.json"));
    }
}
