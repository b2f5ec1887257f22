//! The committed pictures and what made them.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::GoldenError;
use crate::{Mask, Pixels};

/// What made an expected image.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Origin {
    /// Name of the case.
    pub name: String,
    /// The arguments of `meniscus`.
    pub command: String,
    /// Adapter and driver with its version.
    pub driver: String,
    /// Version of the program.
    pub version: String,
    /// Commit of the source; `-dirty` where it was not what is committed.
    pub commit: String,
    /// Day, UTC.
    pub date: String,
}

/// `manifest.toml`: the origins of all expected images.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Sorted by name.
    #[serde(default, rename = "image")]
    pub images: Vec<Origin>,
}

/// The folder of expected images.
pub struct Expected {
    folder: PathBuf,
}

const MANIFEST: &str = "manifest.toml";

impl Expected {
    /// The expectations in `folder`.
    pub fn new(folder: PathBuf) -> Self {
        Self { folder }
    }

    /// Where the picture of a case lies.
    pub fn picture(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{name}.png"))
    }

    /// Where its mask lies: white where water is seen.
    pub fn mask(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{name}.mask.png"))
    }

    /// Picture, mask and origin of a case.
    ///
    /// # Errors
    /// [`GoldenError::NoReference`] when one of the three is missing; [`GoldenError::File`] when one is damaged.
    pub fn load(&self, name: &str) -> Result<(Pixels, Mask, Origin), GoldenError> {
        let origin = self.manifest()?.images.into_iter().find(|origin| origin.name == name);
        let origin = origin.ok_or_else(|| GoldenError::NoReference(name.to_owned()))?;
        let read = |path: PathBuf| match path.is_file() {
            true => Pixels::try_read(&path).map_err(|message| GoldenError::File { path, message }),
            false => Err(GoldenError::NoReference(name.to_owned())),
        };
        let (picture, mask) = (read(self.picture(name))?, read(self.mask(name))?);
        let water = mask.rgba.iter().map(|p| p[0] >= 128).collect();
        Ok((picture, Mask::new(mask.size, water), origin))
    }

    /// Replaces the expectation of one case.
    ///
    /// # Errors
    /// [`GoldenError::File`].
    pub fn store(&self, picture: &Pixels, mask: &Mask, origin: Origin) -> Result<(), GoldenError> {
        std::fs::create_dir_all(&self.folder).map_err(|e| self.error(e.to_string()))?;
        let mut manifest = self.manifest()?;
        picture.write(&self.picture(&origin.name)).map_err(|e| self.error(e))?;
        mask.picture().write(&self.mask(&origin.name)).map_err(|e| self.error(e))?;
        manifest.images.retain(|other| other.name != origin.name);
        manifest.images.push(origin);
        manifest.images.sort_by(|a, b| a.name.cmp(&b.name));
        let body = toml::to_string(&manifest).map_err(|e| self.error(e.to_string()))?;
        let text = format!("# What made each expected image. Written by `image-cases --update`.\n\n{body}");
        std::fs::write(self.folder.join(MANIFEST), text).map_err(|e| self.error(e.to_string()))
    }

    /// Files and manifest entries that belong to none of the cases `names`.
    ///
    /// # Errors
    /// [`GoldenError::File`] when the folder cannot be read.
    pub fn stale(&self, names: &[&str]) -> Result<Vec<String>, GoldenError> {
        if !self.folder.exists() {
            return Ok(Vec::new());
        }
        let entries = std::fs::read_dir(&self.folder).map_err(|e| self.error(e.to_string()))?;
        let mut files: Vec<String> =
            entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        files.sort();
        let belongs = |file: &String| {
            let name = file.strip_suffix(".png").map(|name| name.strip_suffix(".mask").unwrap_or(name));
            file == MANIFEST || name.is_some_and(|name| names.contains(&name))
        };
        files.retain(|file| !belongs(file));
        let unknown = self.manifest()?.images.into_iter().filter(|o| !names.contains(&o.name.as_str()));
        files.extend(unknown.map(|origin| format!("{} in {MANIFEST}", origin.name)));
        Ok(files)
    }

    fn manifest(&self) -> Result<Manifest, GoldenError> {
        let path = self.folder.join(MANIFEST);
        if !path.is_file() {
            return Ok(Manifest::default());
        }
        let text = std::fs::read_to_string(&path).map_err(|e| self.error(e.to_string()))?;
        toml::from_str(&text).map_err(|e| self.error(e.to_string()))
    }

    fn error(&self, message: String) -> GoldenError {
        GoldenError::File { path: Path::to_owned(&self.folder), message }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stored(folder: &Path) -> Expected {
        let expected = Expected::new(folder.to_owned());
        let text = String::new;
        let origin = Origin {
            name: "dam".into(),
            command: text(),
            driver: "a driver".into(),
            version: text(),
            commit: text(),
            date: text(),
        };
        let picture = Pixels { size: [2, 1], rgba: vec![[1, 2, 3, 255], [4, 5, 6, 255]] };
        expected.store(&picture, &Mask::new([2, 1], vec![true, false]), origin).unwrap();
        expected
    }

    #[test]
    fn what_is_stored_comes_back_and_what_is_missing_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let expected = stored(folder.path());
        let (picture, mask, origin) = expected.load("dam").unwrap();
        assert_eq!((picture.rgba[1], mask.area(), origin.driver.as_str()), ([4, 5, 6, 255], 1, "a driver"));
        assert!(matches!(expected.load("flood"), Err(GoldenError::NoReference(_))));
        for file in [expected.mask("dam"), expected.picture("dam"), folder.path().join(MANIFEST)] {
            let kept = std::fs::read(&file).unwrap();
            std::fs::remove_file(&file).unwrap();
            assert!(matches!(expected.load("dam"), Err(GoldenError::NoReference(_))), "{}", file.display());
            assert!(!file.exists(), "nothing is written unasked");
            std::fs::write(&file, kept).unwrap();
        }
    }

    #[test]
    fn files_of_no_case_are_stale() {
        let folder = tempfile::tempdir().unwrap();
        let expected = stored(folder.path());
        assert_eq!(expected.stale(&["dam"]).unwrap(), [""; 0]);
        std::fs::write(folder.path().join("notes.txt"), "").unwrap();
        assert_eq!(expected.stale(&["dam"]).unwrap(), ["notes.txt"]);
        let all = ["dam.mask.png", "dam.png", "notes.txt", "dam in manifest.toml"];
        assert_eq!(expected.stale(&[]).unwrap(), all);
    }
}
