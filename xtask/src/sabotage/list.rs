//! The committed list of sabotages, `tests/sabotage/*.toml`, and what must hold for it to mean anything.

use std::{
    collections::HashSet,
    path::{Component, Path},
};

use serde::Deserialize;

use crate::error::{Error, Result};

/// A deliberate mistake and the tests that must notice it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sabotage {
    /// Lower-case words joined by hyphens, unique.
    pub name: String,
    /// What goes wrong, in a sentence.
    pub breaks: String,
    /// What to run, as one would type it after `cargo test`.
    pub checks: Vec<String>,
    #[serde(rename = "edit")]
    pub edits: Vec<Edit>,
}

/// A piece of a file and what takes its place.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Edit {
    /// Path from the root of the workspace.
    pub file: String,
    /// Exact text that is in the file exactly once.
    pub find: String,
    pub replace: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ListFile {
    sabotage: Vec<Sabotage>,
}

/// The list of the workspace at `root`: its files in the order of their names, so that mistakes in the same crate follow each
/// other and little is compiled from one to the next.
pub fn load(root: &Path) -> Result<Vec<Sabotage>> {
    let folder = root.join("tests/sabotage");
    let error = |path: &Path, source| Error::File { path: path.to_owned(), source };
    let mut paths = std::fs::read_dir(&folder)
        .and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect::<std::io::Result<Vec<_>>>())
        .map_err(|source| error(&folder, source))?;
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    paths.sort();
    let mut list = Vec::new();
    for path in paths {
        let text = std::fs::read_to_string(&path).map_err(|source| error(&path, source))?;
        let file: ListFile =
            toml::from_str(&text).map_err(|source| Error::Toml { path, source: Box::new(source) })?;
        list.extend(file.sabotage);
    }
    Ok(list)
}

/// Everything that is wrong with `list` for the workspace at `root`, one sentence each.
pub fn faults(list: &[Sabotage], root: &Path) -> Vec<String> {
    let mut names = HashSet::new();
    let mut faults = Vec::new();
    for sabotage in list {
        let mut fault = |what: String| faults.push(format!("{}: {what}", sabotage.name));
        let is_word = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        if sabotage.name.is_empty() || !sabotage.name.chars().all(is_word) {
            fault("a name is lower-case words joined by hyphens".to_owned());
        }
        if !names.insert(&sabotage.name) {
            fault("the name is taken twice".to_owned());
        }
        if sabotage.breaks.trim().is_empty() || sabotage.edits.is_empty() || sabotage.checks.is_empty() {
            fault("a sabotage says what it breaks and has an edit and a check".to_owned());
        }
        sabotage.checks.iter().filter_map(|check| check_fault(check)).for_each(&mut fault);
        sabotage.edits.iter().filter_map(|edit| edit_fault(edit, root)).for_each(&mut fault);
    }
    faults
}

/// Only the package and target at stake are compiled, and options for the test binary are the runner's.
fn check_fault(check: &str) -> Option<String> {
    let words: Vec<&str> = check.split_whitespace().collect();
    let has_target = ["--lib", "--bin", "--bins", "--test"].iter().any(|target| words.contains(target));
    (words.first() != Some(&"-p") || !has_target || words.contains(&"--"))
        .then(|| format!("check {check:?}; expected `-p PACKAGE --lib|--bins|--test NAME [FILTER]`"))
}

fn edit_fault(edit: &Edit, root: &Path) -> Option<String> {
    let Edit { file, find, replace } = edit;
    if Path::new(file).components().any(|part| !matches!(part, Component::Normal(_))) {
        return Some(format!("{file} leaves the workspace"));
    }
    if find == replace {
        return Some(format!("{file}: the replacement changes nothing"));
    }
    match std::fs::read_to_string(root.join(file)) {
        Err(error) => Some(format!("{file}: {error}")),
        Ok(text) => match text.matches(find.as_str()).count() {
            1 => None,
            count => Some(format!("{file} has {count} places with {find:?}, expected 1")),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sabotage(name: &str, check: &str, find: &str, replace: &str) -> Sabotage {
        let edit = Edit { file: "a.txt".into(), find: find.into(), replace: replace.into() };
        let breaks = "Something.".to_owned();
        Sabotage { name: name.into(), breaks, checks: vec![check.into()], edits: vec![edit] }
    }

    /// Code moves on; a sabotage that no longer finds its place must not just vanish.
    #[test]
    fn the_committed_list_fits_the_present_code() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let list = load(root).unwrap();
        assert!(list.len() >= 25, "only {} sabotages", list.len());
        assert_eq!(faults(&list, root), Vec::<String>::new());
    }

    #[test]
    fn lists_that_cannot_work_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.txt"), "one two two").unwrap();
        let good = sabotage("a-b", "-p x --lib", "one", "1");
        assert_eq!(faults(std::slice::from_ref(&good), folder.path()), Vec::<String>::new());
        for (bad, expected) in [
            (sabotage("a", "-p x --lib", "two", "2"), "2 places"),
            (sabotage("a", "-p x --lib", "three", "3"), "0 places"),
            (sabotage("a", "-p x --lib", "one", "one"), "changes nothing"),
            (sabotage("A b", "-p x --lib", "one", "1"), "lower-case"),
            (sabotage("a-b", "-p x --lib", "one", "1"), "taken twice"),
            (sabotage("a", "-p x", "one", "1"), "expected `-p"),
            (sabotage("a", "--lib", "one", "1"), "expected `-p"),
            (sabotage("a", "-p x --lib -- --ignored", "one", "1"), "expected `-p"),
        ] {
            let faults = faults(&[good.clone(), bad], folder.path());
            assert!(faults.len() == 1 && faults[0].contains(expected), "{expected}: {faults:?}");
        }
        let mut outside = good;
        outside.edits[0].file = "../a.txt".into();
        assert!(faults(&[outside], folder.path())[0].contains("leaves the workspace"));
    }
}
