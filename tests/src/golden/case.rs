//! `cases.toml`.

use std::path::Path;

use serde::Deserialize;

use super::{Criteria, GoldenError};

/// What is drawn.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Name of the expected image, without ending.
    pub name: String,
    /// What would show here first if it broke.
    pub why: String,
    /// The made series, as `meniscus make` takes it: case, `--particles` and `--frames`.
    pub make: String,
    /// Frame of it.
    pub frame: usize,
    /// Further flags of `meniscus render`.
    #[serde(default)]
    pub flags: String,
    /// Whether `cargo xtask test` draws it too.
    #[serde(default)]
    pub smoke: bool,
}

impl Case {
    /// Folder of the series, inside of the one that the program runs in.
    pub fn folder(&self) -> String {
        self.make.split_whitespace().collect::<Vec<_>>().join("_").replace("--", "")
    }

    /// The arguments that make the series.
    pub fn make_arguments(&self) -> String {
        format!("make {} -o {} -q", self.make, self.folder())
    }

    /// The arguments that draw the picture.
    pub fn render_arguments(&self, size: &str) -> String {
        let line = format!("render {} --frame {} --size {size} {}", self.folder(), self.frame, self.flags);
        format!("{} -o {}.png", line.trim_end(), self.name)
    }
}

/// All cases and what they are judged by.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cases {
    /// Size of every picture, `WxH`.
    pub size: String,
    /// On the driver version that made the expected image.
    pub same_driver: Criteria,
    /// On any other.
    pub other_driver: Criteria,
    /// The cases.
    #[serde(rename = "case")]
    pub cases: Vec<Case>,
}

impl Cases {
    /// Reads the file.
    ///
    /// # Errors
    /// [`GoldenError::File`] with line and column; also when two cases share a name.
    pub fn read(path: &Path) -> Result<Self, GoldenError> {
        let error = |message: String| GoldenError::File { path: path.to_owned(), message };
        let text = std::fs::read_to_string(path).map_err(|e| error(e.to_string()))?;
        let cases: Self = toml::from_str(&text).map_err(|e| error(e.to_string()))?;
        let mut names: Vec<&str> = cases.cases.iter().map(|case| case.name.as_str()).collect();
        names.sort_unstable();
        match names.windows(2).find(|pair| pair[0] == pair[1]) {
            Some(pair) => Err(error(format!("two cases are called `{}`; rename one", pair[0]))),
            None => Ok(cases),
        }
    }

    /// Those with the given names, all if none are given.
    ///
    /// # Errors
    /// [`GoldenError::NoSuchCase`].
    pub fn choose(&self, names: &[String]) -> Result<Vec<&Case>, GoldenError> {
        if names.is_empty() {
            return Ok(self.cases.iter().collect());
        }
        let known = || self.cases.iter().map(|case| case.name.as_str()).collect::<Vec<_>>().join(", ");
        let find = |name: &String| {
            let found = self.cases.iter().find(|case| case.name == *name);
            found.ok_or_else(|| GoldenError::NoSuchCase { name: name.clone(), known: known() })
        };
        names.iter().map(find).collect()
    }
}
