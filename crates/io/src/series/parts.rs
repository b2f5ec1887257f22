//! Parts of the files that are not drawn as water.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use meniscus_core::{Cancel, Choice};

use super::sets::{SetPlan, SetSource};
use super::survey::choice;
use super::view::View;
use crate::discover::{TimeStep, names};

/// Says which parts of `view` are surface meshes, unless a set draws them, with the flags that draw them as solids.
pub(super) fn describe(
    view: &View,
    steps: &[TimeStep],
    plans: &[SetPlan],
    choices: &mut Vec<Choice>,
    cancel: &Cancel,
) {
    // Cells that cannot be read do not matter to particles.
    if view.frame.is_mesh(cancel).unwrap_or(false) {
        let reason = "there are no vertex cells, only faces; is this a surface mesh?".into();
        choices.push(choice("particles", "the corners of a mesh".into(), reason, "INPUT"));
    }
    if view.frame.meshes.is_empty() {
        return;
    }
    let drawn: HashSet<PathBuf> = plans.iter().flat_map(own_files).map(|file| real(file)).collect();
    let left_out: Vec<&PathBuf> =
        view.frame.meshes.iter().filter(|file| !drawn.contains(&real(file))).collect();
    if left_out.is_empty() {
        return;
    }
    let names: Vec<String> = left_out.iter().map(|file| file_name(file)).collect();
    let flags: Vec<String> = left_out
        .iter()
        .map(|file| format!("--set \"{}={}:solid\"", set_name(file), pattern(file, steps)))
        .collect();
    let reason = "a surface mesh is not water".into();
    choices.push(choice("parts left out", names.join(", "), reason, &flags.join(" ")));
}

fn own_files(plan: &SetPlan) -> impl Iterator<Item = &PathBuf> {
    let steps: &[TimeStep] = if let SetSource::Files(steps) = &plan.source { steps } else { &[] };
    steps.iter().flat_map(|step| &step.files)
}

/// The same file by another way is the same file.
fn real(file: &Path) -> PathBuf {
    file.canonicalize().unwrap_or_else(|_| file.to_owned())
}

fn file_name(file: &Path) -> String {
    file.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// The letters before the number of `file`, as the name of a set.
fn set_name(file: &Path) -> String {
    let stem = names::stem(&file_name(file));
    let head = stem.split(['#', '.']).next().unwrap_or_default();
    let kept = |c: char| if c.is_alphanumeric() { c } else { '_' };
    let name: String = head.chars().map(kept).collect();
    match name.trim_matches('_') {
        "" | "water" => "part".into(),
        name => name.into(),
    }
}

/// What names `file`, and with it the files of the same name but another number that other `steps` have: ready for the shell
/// and for `--set`.
fn pattern(file: &Path, steps: &[TimeStep]) -> String {
    let stem = names::stem(&file_name(file));
    let varies = steps.iter().flat_map(|step| &step.files).any(|other| {
        other != file && other.parent() == file.parent() && names::stem(&file_name(other)) == stem
    });
    let folder = file.with_file_name("").to_string_lossy().into_owned();
    let text = if varies {
        let (head, tail) = stem.split_once('#').unwrap_or((&stem, ""));
        format!("{}*{}", plain(&(folder + head)), plain(tail))
    } else {
        plain(&file.to_string_lossy())
    };
    // Would be read as a selection.
    text.replace(" in", "?in")
}

/// `text` with a `?` for what the shell, the glob or `--set` would read in another way.
fn plain(text: &str) -> String {
    let special = |c: char| "<>=\"'$`!*?[]%".contains(c) || (c == '\\' && !cfg!(windows));
    text.chars().map(|c| if special(c) { '?' } else { c }).collect()
}
