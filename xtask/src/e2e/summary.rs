//! What the terminal shows of the findings.

use super::{
    groups::{self, GROUPS},
    images::{Images, Status},
    run::Findings,
};
use crate::{
    table,
    test::{
        Ending,
        report::{Binary, Totals},
    },
};

/// Title of the pictures.
pub const IMAGES: &str = "images";
/// Title of what kept the rest from running.
pub const PROBLEMS: &str = "could not run";
/// Title of what cargo itself had to say.
pub const BUILDING: &str = "building";

/// A heading's counts.
#[derive(Debug, PartialEq)]
pub struct Line {
    pub title: &'static str,
    pub totals: Totals,
    pub seconds: f64,
}

/// Counts per heading; what was not run is left out.
pub fn lines(findings: &Findings) -> Vec<Line> {
    let images = findings.images.iter().map(|images| {
        let (passed, failed) = images.counts();
        let seconds = images.cases.iter().map(|case| case.elapsed_s).sum();
        Line { title: IMAGES, totals: Totals { passed, failed, skipped: 0 }, seconds }
    });
    let tests = findings.tests.iter().flat_map(|report| {
        let line = |title, binaries: Vec<_>| Line {
            title,
            totals: groups::totals(&binaries),
            seconds: binaries.iter().map(|binary| binary.seconds).sum(),
        };
        let known = GROUPS.iter().map(move |group| line(group.title, group.of(report)));
        known.chain([line(BUILDING, groups::others(report))])
    });
    let problems = Totals { failed: findings.problems.len(), ..Totals::default() };
    let problems = Line { title: PROBLEMS, totals: problems, seconds: 0.0 };
    let all = images.chain(tests).chain([problems]);
    all.filter(|line| line.totals != Totals::default()).collect()
}

/// One row per heading, and their sum.
pub fn table(findings: &Findings) -> String {
    let row = |title: &str, totals: Totals, seconds: f64| {
        let Totals { passed, failed, skipped } = totals;
        let numbers = [passed, failed, skipped].map(|n| n.to_string());
        let [passed, failed, skipped] = numbers;
        [title.to_owned(), passed, failed, skipped, format!("{seconds:.1}")]
    };
    let lines = lines(findings);
    let mut rows = vec![["group", "passed", "failed", "skipped", "seconds"].map(String::from)];
    rows.extend(lines.iter().map(|line| row(line.title, line.totals, line.seconds)));
    rows.push(row("sum", findings.totals(), lines.iter().map(|line| line.seconds).sum()));
    table::layout(&rows, [false, true, true, true, true])
}

/// Something that failed.
#[derive(Debug, PartialEq, Eq)]
pub struct Failure {
    /// Where the report shows it: the `id` of an element.
    pub anchor: String,
    pub name: String,
    /// Empty where the report of the test says why.
    pub why: String,
}

/// All of them, those first that kept others from running.
pub fn failures(findings: &Findings) -> Vec<Failure> {
    let problem = |why: &String| Failure { anchor: anchor(PROBLEMS), name: String::new(), why: why.clone() };
    let mut failures: Vec<Failure> = findings.problems.iter().map(problem).collect();
    if let Some(images) = &findings.images {
        failures.extend(failed_images(images));
    }
    if let Some(report) = &findings.tests {
        let known = GROUPS.iter().map(|group| (group.title, group.of(report)));
        for (title, binaries) in known.chain([(BUILDING, groups::others(report))]) {
            failures.extend(binaries.iter().flat_map(|binary| failed_tests(title, binary)));
        }
    }
    failures
}

/// The name of a heading as the end of an address.
pub fn anchor(title: &str) -> String {
    format!("group-{}", title.to_lowercase().replace(' ', "-"))
}

impl Failure {
    /// In a line.
    pub fn in_words(&self) -> String {
        let separator = if self.name.is_empty() || self.why.is_empty() { "" } else { ": " };
        format!("{}{separator}{}", self.name, self.why)
    }
}

fn failed_images(images: &Images) -> impl Iterator<Item = Failure> {
    let failed = images.cases.iter().filter(|case| case.status == Status::Failed);
    let said = failed.map(|case| {
        let limits = case.metrics.iter().filter(|metric| !metric.passed);
        let limits = limits.map(|m| format!("{} {} (limit {})", m.name, m.shown(), m.limit));
        let why = limits.chain(case.problem.clone()).collect::<Vec<_>>().join(", ");
        Failure { anchor: format!("case-{}", case.name), name: case.name.clone(), why }
    });
    let stale = |file: &String| Failure {
        anchor: anchor(IMAGES),
        name: format!("tests/expected/{file}"),
        why: "belongs to no case; delete it".to_owned(),
    };
    said.chain(images.stale.iter().map(stale))
}

/// The failed tests of a binary; the binary itself where it died or was not built.
fn failed_tests(title: &str, binary: &Binary) -> Vec<Failure> {
    let failure =
        |name: &str| Failure { anchor: anchor(title), name: format!("{title}, {name}"), why: String::new() };
    let failed = binary.tests.iter().filter(|test| test.ending == Ending::Failed);
    let named: Vec<_> = failed.map(|test| failure(&test.name)).collect();
    match named.is_empty() && binary.totals.failed > 0 {
        true => vec![failure(&binary.name)],
        false => named,
    }
}
