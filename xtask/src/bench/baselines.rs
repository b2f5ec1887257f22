//! Records of earlier runs: `target/bench/baselines/NAME/STAGE.jsonl`.

use std::{
    collections::BTreeMap,
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

    /// Keeps the records under `name`, in place of those that it had of the same stages.
    pub fn save(&self, name: &str, records: &[Record]) -> Result<()> {
        let mut stages: BTreeMap<&str, String> = BTreeMap::new();
        for record in records {
            let line = serde_json::to_string(record).expect("numbers and text");
            *stages.entry(&record.stage).or_default() += &(line + "\n");
        }
        for (stage, lines) in stages {
            let path = self.file(name, stage);
            let written = fs::create_dir_all(self.0.join(name)).and_then(|()| fs::write(&path, lines));
            written.map_err(|source| Error::File { path, source })?;
        }
        Ok(())
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
    use super::super::record::tests::record;
    use super::*;

    #[test]
    fn what_is_saved_is_loaded_and_what_is_not_is_an_error_that_names_what_is() {
        let folder = tempfile::tempdir().unwrap();
        let baselines = Baselines(folder.path().join("baselines"));
        let error = baselines.load("a", &["lod"]).unwrap_err().to_string();
        assert!(error.contains("saved: none"), "{error}");

        let lod = record(&[1.5, 2.5]);
        let shading = Record { stage: "shading".into(), ..lod.clone() };
        baselines.save("b", &[lod.clone(), shading.clone()]).unwrap();
        assert_eq!(baselines.load("b", &["io", "lod", "shading"]).unwrap(), [lod, shading.clone()]);
        let error = baselines.load("a", &["lod"]).unwrap_err().to_string();
        assert!(error.contains("saved: b"), "{error}");
        assert!(baselines.load("b", &["io"]).is_err(), "the stage was not measured");

        let faster = record(&[1.0]);
        baselines.save("b", std::slice::from_ref(&faster)).unwrap();
        assert_eq!(baselines.load("b", &["lod", "shading"]).unwrap(), [faster, shading], "only that stage");

        fs::write(baselines.file("b", "lod"), "{}").unwrap();
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
