//! The groups besides the pictures: each test and how it ended.

use super::text::escape;
use crate::{
    e2e::{
        groups::{self, GROUPS},
        summary::{BUILDING, anchor},
    },
    test::{
        Ending,
        report::{Binary, Report, Test},
    },
};

/// Everything, group by group; groups with failures first and open.
pub fn groups(report: &Report) -> String {
    let known = GROUPS.iter().map(|group| (group.title, group.shows, group.of(report)));
    let others =
        (BUILDING, "What cargo itself had to say; see the output of the command.", groups::others(report));
    let mut all: Vec<_> = known.chain([others]).filter(|(_, _, binaries)| !binaries.is_empty()).collect();
    all.sort_by_key(|(_, _, binaries)| groups::totals(binaries).failed == 0);
    all.into_iter().map(|(title, shows, binaries)| group(title, shows, &binaries)).collect()
}

fn group(title: &str, shows: &str, binaries: &[Binary]) -> String {
    let totals = groups::totals(binaries);
    let count = |number: usize, what: &str| match number {
        0 => String::new(),
        _ => format!("<span class=\"pill {what}\">{number} {what}</span> "),
    };
    let tables: String = binaries.iter().map(table).collect();
    format!(
        "<details class=\"group\" id=\"{anchor}\"{open}><summary><b>{title}</b>{failed}{passed}{skipped}</summary>\n\
         <p class=\"soft\">{shows}</p>\n{tables}</details>\n",
        anchor = anchor(title),
        open = if totals.failed > 0 { " open" } else { "" },
        title = escape(title),
        failed = count(totals.failed, "failed"),
        passed = count(totals.passed, "passed"),
        skipped = count(totals.skipped, "skipped"),
        shows = escape(shows),
    )
}

fn table(binary: &Binary) -> String {
    let mut tests: Vec<&Test> = binary.tests.iter().collect();
    tests.sort_by_key(|test| match test.ending {
        Ending::Failed => 0,
        Ending::Skipped => 1,
        Ending::Passed => 2,
    });
    let rows: String = tests.into_iter().map(row).collect();
    format!("<table><caption>{}, {:.1} s</caption>\n{rows}</table>\n", escape(&binary.name), binary.seconds)
}

fn row(test: &Test) -> String {
    let ending = match test.ending {
        Ending::Passed => "passed",
        Ending::Failed => "failed",
        Ending::Skipped => "skipped",
    };
    let notes = match (test.ending, test.notes.trim()) {
        (_, "") => String::new(),
        (Ending::Failed, notes) => format!("<pre>{}</pre>", escape(notes)),
        (_, notes) => format!("<br><span class=\"soft\">{}</span>", escape(notes)),
    };
    format!(
        "<tr><td><span title=\"{}\">{}</span>{notes}<td><span class=\"pill {ending}\">{ending}</span></tr>\n",
        escape(&test.name),
        escape(&test.name.replace("::", " · ").replace('_', " "))
    )
}
