//! Can the tests fail? Makes deliberate mistakes, one at a time, and looks whether a test notices.

mod checks;
mod list;
mod tree;

use std::{
    collections::HashMap,
    fs::File,
    path::Path,
    time::{Duration, Instant},
};

use cargo_metadata::MetadataCommand;

use crate::{
    error::{Error, Result},
    prerequisites, table,
};
pub use checks::data_folder;
use checks::{Checks, LEAST_PATIENCE, PATIENCE, Verdict};
use list::Sabotage;
use tree::Tree;

/// Tests named in the table's row of a sabotage; one is enough, a few show who else watches.
const TESTS_NAMED: usize = 2;

/// What became of a sabotage.
#[derive(Debug, PartialEq, Eq)]
enum Fate {
    /// By these tests.
    Caught(Vec<String>),
    NotCaught,
    /// Why nothing can be concluded.
    Broken(String),
}

/// How a check went without any sabotage: how long it took, or why it is of no use.
type Baseline = std::result::Result<Duration, String>;

/// What `cargo xtask e2e --sabotage` is asked for.
pub struct Options {
    /// Only these; all without.
    pub names: Vec<String>,
    /// Only say what each would break.
    pub list: bool,
    /// Install missing Debian packages.
    pub install: bool,
}

/// Tries the sabotages and reports.
pub fn run(options: &Options) -> Result<()> {
    let start = Instant::now();
    let metadata = MetadataCommand::new().no_deps().exec()?;
    let workspace = metadata.workspace_root.as_std_path();
    let list = chosen(list::load(workspace)?, &options.names)?;
    if options.list {
        let rows: Vec<_> = list.iter().map(|s| [s.name.clone(), s.breaks.clone()]).collect();
        print!("{}", table::layout(&rows, [false, false]));
        return Ok(());
    }
    let faults = list::faults(&list, workspace);
    if !faults.is_empty() {
        return Err(Error::Sabotages(faults.join("\n  ")));
    }
    let folder = metadata.target_directory.as_std_path().join("sabotage");
    let _lock = lock(&folder)?;
    let mut variables = prerequisites::ensure(workspace, options.install)?;
    variables.extend(data_folder(workspace).map(|data| ("MENISCUS_DATA", data)));
    checks::end_children_on_interrupt();

    let tree = Tree::copy(workspace, folder.join("tree"))?;
    let checks = Checks { tree: tree.root.clone(), target: folder.join("target"), variables };
    make_folder(&checks.target)?;
    let baselines = baselines(&list, &checks)?;
    let mut rows = vec![["sabotage", "seconds", "caught by"].map(String::from)];
    let (mut caught, mut missed, mut broken) = (0, 0, 0);
    for sabotage in &list {
        println!("{}: {}", sabotage.name, sabotage.breaks);
        let start = Instant::now();
        let fate = try_out(sabotage, &tree, &checks, &baselines)?;
        match fate {
            Fate::Caught(_) => caught += 1,
            Fate::NotCaught => missed += 1,
            Fate::Broken(_) => broken += 1,
        }
        let seconds = format!("{:.0}", start.elapsed().as_secs_f64());
        println!("    {}", fate.in_words());
        rows.push([sabotage.name.clone(), seconds, fate.in_words()]);
    }
    println!("\n{}", table::layout(&rows, [false, true, false]));
    println!("{:.0} s in all", start.elapsed().as_secs_f64());
    println!("{caught} caught, {missed} not caught, {broken} broken");
    if missed + broken > 0 { Err(Error::TestsReported) } else { Ok(()) }
}

fn chosen(list: Vec<Sabotage>, names: &[String]) -> Result<Vec<Sabotage>> {
    if let Some(unknown) = names.iter().find(|name| !list.iter().any(|sabotage| sabotage.name == **name)) {
        let known: Vec<&str> = list.iter().map(|sabotage| sabotage.name.as_str()).collect();
        return Err(Error::Sabotages(format!("no sabotage {unknown:?}; there are {}", known.join(", "))));
    }
    Ok(list.into_iter().filter(|sabotage| names.is_empty() || names.contains(&sabotage.name)).collect())
}

/// Two runs in one tree would undo each other's mistakes.
fn lock(folder: &Path) -> Result<File> {
    make_folder(folder)?;
    let path = folder.join("lock");
    let file = File::create(&path).map_err(|source| Error::File { path: path.clone(), source })?;
    file.try_lock().map_err(|_| Error::Sabotages(format!("another run is under way: {}", path.display())))?;
    Ok(file)
}

fn make_folder(path: &Path) -> Result<()> {
    std::fs::create_dir_all(path).map_err(|source| Error::File { path: path.to_owned(), source })
}

/// Runs every check without any sabotage: only what was green before can turn red.
fn baselines<'a>(list: &'a [Sabotage], checks: &Checks) -> Result<HashMap<&'a str, Baseline>> {
    let mut baselines = HashMap::new();
    for check in list.iter().flat_map(|sabotage| &sabotage.checks) {
        if baselines.contains_key(check.as_str()) {
            continue;
        }
        let (verdict, took) = checks.run(check, Duration::from_secs(1800))?;
        let baseline = match verdict {
            Verdict::Green { passed: 0, .. } => Err("runs no test to its end".to_owned()),
            Verdict::Green { passed, skipped } => {
                let seconds = took.as_secs_f64();
                println!("without sabotage: {check}: {passed} passed, {skipped} skipped, {seconds:.0} s");
                Ok(took)
            }
            Verdict::Red(tests) => Err(format!("is red without sabotage: {}", few(&tests))),
            Verdict::Hang => Err("hangs without sabotage".to_owned()),
            Verdict::DoesNotBuild(error) => Err(format!("does not build without sabotage: {error}")),
        };
        if let Err(reason) = &baseline {
            println!("without sabotage: {check} {reason}");
        }
        baselines.insert(check.as_str(), baseline);
    }
    Ok(baselines)
}

fn try_out(
    sabotage: &Sabotage,
    tree: &Tree,
    checks: &Checks,
    baselines: &HashMap<&str, Baseline>,
) -> Result<Fate> {
    let _applied = tree.apply(&sabotage.edits)?;
    for check in &sabotage.checks {
        let took = match baselines.get(check.as_str()) {
            Some(Ok(took)) => *took,
            Some(Err(reason)) => return Ok(Fate::Broken(format!("{check} {reason}"))),
            None => return Ok(Fate::Broken(format!("{check} was not tried without sabotage"))),
        };
        let (verdict, _) = checks.run(check, took * PATIENCE + LEAST_PATIENCE)?;
        if let Some(fate) = fate(verdict) {
            return Ok(fate);
        }
    }
    Ok(Fate::NotCaught)
}

/// What a check's verdict means for the sabotage; `None` where the next check has to tell.
fn fate(verdict: Verdict) -> Option<Fate> {
    match verdict {
        Verdict::Green { .. } => None,
        Verdict::Red(tests) => Some(Fate::Caught(tests)),
        Verdict::Hang => Some(Fate::Caught(vec!["hang".to_owned()])),
        Verdict::DoesNotBuild(error) => Some(Fate::Broken(format!("does not build: {error}"))),
    }
}

impl Fate {
    fn in_words(&self) -> String {
        match self {
            Self::Caught(tests) => few(tests),
            Self::NotCaught => "NOT CAUGHT".to_owned(),
            Self::Broken(reason) => format!("BROKEN: {reason}"),
        }
    }
}

fn few(tests: &[String]) -> String {
    let named = tests.iter().take(TESTS_NAMED).map(String::as_str).collect::<Vec<_>>().join(", ");
    match tests.len().saturating_sub(TESTS_NAMED) {
        0 => named,
        more => format!("{named} and {more} more"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_red_tests_and_hangs_are_catches() {
        assert_eq!(fate(Verdict::Green { passed: 9, skipped: 0 }), None);
        assert!(matches!(fate(Verdict::Red(vec!["a".into()])), Some(Fate::Caught(_))));
        assert_eq!(fate(Verdict::Hang), Some(Fate::Caught(vec!["hang".into()])));
        let broken = fate(Verdict::DoesNotBuild("error[E0308]".into())).unwrap();
        assert!(broken.in_words().starts_with("BROKEN: does not build: error[E0308]"));
    }

    #[test]
    fn a_few_tests_stand_for_many() {
        let tests: Vec<String> = ["a", "b", "c", "d"].map(String::from).to_vec();
        assert_eq!((few(&tests).as_str(), few(&tests[..1]).as_str()), ("a, b and 2 more", "a"));
    }

    #[test]
    fn unknown_names_are_refused_with_the_known_ones() {
        let list: Vec<Sabotage> = ["one", "two"]
            .map(|name| Sabotage {
                name: name.into(),
                breaks: String::new(),
                checks: Vec::new(),
                edits: Vec::new(),
            })
            .to_vec();
        assert_eq!(chosen(list.clone(), &["two".to_owned()]).unwrap().len(), 1);
        assert_eq!(chosen(list.clone(), &[]).unwrap().len(), 2);
        assert!(chosen(list, &["three".to_owned()]).unwrap_err().to_string().contains("one, two"));
    }
}
