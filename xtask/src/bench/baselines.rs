//! Records of earlier runs: `target/bench/baselines/NAME/STAGE.jsonl`.

use std::{
    fs,
    path::{Path, PathBuf},
};

use super::record::Record;
use crate::error::{Error, Result};

/// The folder of all baselines.
pub struct Baselines(pub PathBuf);

impl Baselines {
    fn file(&self, name: &str, stage: &str) -> PathBuf {
        self.0.join(name).join(format!("{stage}.jsonl"))
    }

    /// The names of the saved ones, sorted.
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).into_iter().flatten().flatten();
        let folders = entries.filter(|entry| entry.path().is_dir());
        let mut names: Vec<_> = folders.map(|e| e.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// The records of `stages` saved as `name`. Stages that were not measured then have none, but some must have been.
    pub fn load(&self, name: &str, stages: &[&str]) -> Result<Vec<Record>> {
        let files: Vec<_> =
            stages.iter().map(|stage| self.file(name, stage)).filter(|path| path.is_file()).collect();
        if files.is_empty() {
            let saved = self.names();
            return Err(Error::NoBaseline {
                name: name.to_owned(),
                stages: stages.join(", "),
                saved: if saved.is_empty() { "none".to_owned() } else { saved.join(", ") },
            });
        }
        files.iter().map(|path| read(path)).collect::<Result<Vec<_>>>().map(|all| all.concat())
    }

    /// Keeps the records in the file `run` as those of `stage` under `name`.
    pub fn save(&self, name: &str, stage: &str, run: &Path) -> Result<()> {
        let path = self.file(name, stage);
        let file_error = |source| Error::File { path: path.clone(), source };
        fs::create_dir_all(self.0.join(name)).map_err(file_error)?;
        fs::copy(run, &path).map_err(file_error).map(|_| ())
    }
}

/// Reads a file of records.
pub fn read(path: &Path) -> Result<Vec<Record>> {
    let text = fs::read_to_string(path).map_err(|source| Error::File { path: path.to_owned(), source })?;
    Record::read_all(&text).map_err(|(line, source)| Error::Record { path: path.to_owned(), line, source })
}

/// A name becomes a folder, here and at criterion's.
pub fn name(text: &str) -> std::result::Result<String, String> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if text.chars().all(is_plain) && text.starts_with(|c: char| c.is_ascii_alphanumeric()) {
        return Ok(text.to_owned());
    }
    Err("expected letters, digits, '-', '_' and '.', as in before-culling".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINE: &str = r#"{"stage":"lod","bench":"b","view":"v","device":"CPU","bytes":null,"copy_gb_per_s":1.0,"samples":[]}"#;

    #[test]
    fn what_is_saved_is_loaded_and_what_is_not_is_an_error_that_names_what_is() {
        let folder = tempfile::tempdir().unwrap();
        let baselines = Baselines(folder.path().join("baselines"));
        let error = baselines.load("a", &["lod"]).unwrap_err().to_string();
        assert!(error.contains("saved: none"), "{error}");

        let run = folder.path().join("run");
        fs::write(&run, LINE).unwrap();
        baselines.save("b", "lod", &run).unwrap();
        assert_eq!(baselines.load("b", &["io", "lod"]).unwrap().len(), 1);
        let error = baselines.load("a", &["lod"]).unwrap_err().to_string();
        assert!(error.contains("saved: b"), "{error}");
        assert!(baselines.load("b", &["io"]).is_err(), "the stage was not measured");

        fs::write(&run, "{}").unwrap();
        baselines.save("b", "lod", &run).unwrap();
        assert!(matches!(baselines.load("b", &["lod"]), Err(Error::Record { line: 1, .. })));
    }

    #[test]
    fn names_cannot_leave_the_folder() {
        assert!(name("main-2026.11").is_ok());
        for wrong in ["", ".", "..", "../x", "a/b", "-x", "a b"] {
            assert!(name(wrong).is_err(), "{wrong:?}");
        }
    }
}
