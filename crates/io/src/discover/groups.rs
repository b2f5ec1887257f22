use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};

use meniscus_core::Choice;

use super::{Found, TimeStep, file, gaps, names};
use crate::Error;
use crate::format::{EXPECTED, PARTICLE_FILES, TABLES};

/// Words in a name that say that it holds the liquid, and that it holds something else.
const LIQUID_WORDS: [&str; 3] = ["fluid", "water", "liquid"];
const OTHER_WORDS: [&str; 9] = ["wall", "bound", "solid", "soil", "rigid", "sphere", "body", "mesh", "box"];

/// A series among several.
struct Candidate {
    name: String,
    /// A collection file, which knows the times.
    collection: bool,
    steps: Vec<TimeStep>,
}

impl Candidate {
    fn rank(&self) -> impl Ord + use<> {
        let lower = self.name.to_ascii_lowercase();
        let has = |words: &[&str]| words.iter().any(|word| lower.contains(word));
        let hint = i32::from(has(&LIQUID_WORDS)) - i32::from(has(&OTHER_WORDS));
        let several_parts = self.steps.iter().any(|step| step.files.len() > 1);
        // Before the number of frames: the pieces of parallel files look like a series with more of them.
        let parallel = self
            .steps
            .iter()
            .flat_map(|step| &step.files)
            .any(|file| names::extension(file).starts_with("pv"));
        // Logs and measurements are tables, too.
        let is_file =
            |step: &TimeStep| step.files.iter().all(|f| !TABLES.contains(&names::extension(f).as_str()));
        let particles = self.steps.iter().all(is_file);
        (particles, hint, parallel, self.steps.len(), self.collection, !several_parts)
    }

    fn describe(&self) -> String {
        let frames = self.steps.len();
        format!("{} ({frames} frame{})", self.name, if frames == 1 { "" } else { "s" })
    }
}

/// Sorts `files`, found at `place`, into series and chooses one; series are never mixed.
pub(super) fn choose(place: &Path, files: Vec<PathBuf>) -> Result<Found, Error> {
    let mut candidates = Vec::new();
    let mut groups: BTreeMap<(PathBuf, String), Vec<(String, PathBuf)>> = BTreeMap::new();
    for path in files {
        let Some(name) = path.file_name().map(|name| name.to_string_lossy().into_owned()) else { continue };
        let extension = names::extension(&path);
        if extension == "pvd" || extension == "series" {
            // A broken collection does not hide the files beside it.
            if let Ok(found) = file(&path) {
                candidates.push(Candidate { name, collection: true, steps: found.steps });
            }
        } else if PARTICLE_FILES.contains(&extension.as_str()) {
            let folder = path.parent().map(Path::to_owned).unwrap_or_default();
            groups.entry((folder, names::stem(&name))).or_default().push((name, path));
        }
    }
    for ((_, stem), mut group) in groups {
        group.sort_by(|a, b| names::natural(&a.0, &b.0));
        let name = if group.len() == 1 { group[0].0.clone() } else { stem.replace('#', "*") };
        let steps = group.into_iter().map(|(_, path)| TimeStep { time: None, files: vec![path] }).collect();
        candidates.push(Candidate { name, collection: false, steps });
    }
    // Pieces of parallel files and files of a collection are series of their own here; the rank puts the collection first.
    candidates.sort_by(|a, b| b.rank().cmp(&a.rank()).then_with(|| names::natural(&a.name, &b.name)));
    let mut candidates = candidates.into_iter();
    let Some(chosen) = candidates.next() else {
        return Err(Error::Empty {
            file: place.to_owned(),
            message: format!("no particle file here; expected {EXPECTED}"),
        });
    };
    // What the chosen collection lists is not left out.
    let listed: HashSet<&PathBuf> = chosen.steps.iter().flat_map(|step| &step.files).collect();
    let left_out = |candidate: &Candidate| {
        candidate.steps.iter().flat_map(|step| &step.files).any(|f| !listed.contains(f))
    };
    let others: Vec<String> = candidates.filter(left_out).map(|candidate| candidate.describe()).collect();
    let mut choices = Vec::new();
    if !others.is_empty() {
        choices.push(Choice {
            what: "series".into(),
            value: chosen.describe(),
            reason: format!("not mixed with the others here: {}", others.join(", ")),
            flag: "INPUT, the name of one of them".into(),
        });
    }
    if !chosen.collection {
        choices.extend(gaps::describe(&chosen.steps));
    }
    Ok(Found { steps: chosen.steps, choices })
}
