//! What the terminal shows of the findings.

use super::{
    groups::{self, GROUPS},
    images::{Images, Status},
    run::Findings,
};
use crate::{
    table,
    test::{Ending, report::Totals},
};

/// Title of the pictures.
pub const IMAGES: &str = "images";
/// Title of what kept the rest from running.
pub const PROBLEMS: &str = "could not run";

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
        known.chain([line("building", groups::others(report))])
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

/// Each failure in a line.
pub fn failures(findings: &Findings) -> Vec<String> {
    let mut failures = findings.problems.clone();
    if let Some(images) = &findings.images {
        failures.extend(failed_images(images));
    }
    for binary in findings.tests.iter().flat_map(|report| report.binaries()) {
        let failed = binary.tests.iter().filter(|test| test.ending == Ending::Failed);
        let named: Vec<_> = failed.map(|test| format!("{}: {}", binary.name, test.name)).collect();
        match named.is_empty() && binary.totals.failed > 0 {
            true => failures.push(binary.name.clone()),
            false => failures.extend(named),
        }
    }
    failures
}

fn failed_images(images: &Images) -> impl Iterator<Item = String> {
    let failed = images.cases.iter().filter(|case| case.status == Status::Failed);
    let said = failed.map(|case| {
        let limits = case.metrics.iter().filter(|metric| !metric.passed);
        let limits = limits.map(|m| format!("{} {} (limit {})", m.name, m.shown(), m.limit));
        let why = limits.chain(case.problem.clone()).collect::<Vec<_>>().join(", ");
        format!("{}: {why}", case.name)
    });
    said.chain(
        images.stale.iter().map(|file| format!("tests/expected: {file} belongs to no case; delete it")),
    )
}
