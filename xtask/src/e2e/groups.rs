//! Which tests run besides the pictures, and what they are there for.

use crate::test::report::{Binary, Report, Totals};

/// Test targets under one heading.
#[derive(Debug)]
pub struct Group {
    pub title: &'static str,
    /// What it shows, for readers of the report.
    pub shows: &'static str,
    /// Package and test target. Whole targets, no name filters: a new test is in without being listed.
    targets: &'static [(&'static str, &'static str)],
}

/// In the order of the report.
pub const GROUPS: &[Group] = &[
    Group {
        title: "CPU twins against the GPU",
        shows: "Each stage on the device against its specification on the processor, closed forms and invariants.",
        targets: &[
            ("meniscus-lod", "gpu_set"),
            ("meniscus-ssfr", "filters"),
            ("meniscus-ssfr", "sphere"),
            ("meniscus-ssfr", "surface"),
            ("meniscus-ssfr", "thickness"),
            ("meniscus-shading", "device"),
            ("meniscus-compositor", "compositor"),
        ],
    },
    Group {
        title: "chain",
        shows: "From particles to picture through all stages: thickness in metres, coordinates of every convention.",
        targets: &[("meniscus-tests", "chain")],
    },
    Group {
        title: "command line",
        shows: "The program as users run it: results, exit codes, reports, and words for everything that goes wrong.",
        targets: &[("meniscus-tests", "program")],
    },
    Group {
        title: "memory",
        shows: "The most that the program holds at once, per particle and over many frames.",
        targets: &[("meniscus-tests", "memory")],
    },
    Group {
        title: "data",
        shows: "Files of every format with listed values, broken ones refused, doubtful ones survived.",
        targets: &[("meniscus-io", "index")],
    },
];

/// Packages with test targets of the same names: cargo chooses targets by name alone.
const LEFT_OUT: &[&str] = &["meniscus-gpu", "custom-filter", "custom-lighting"];

/// What follows `cargo test` to build or run all groups at once.
pub fn arguments() -> Vec<&'static str> {
    packages().chain(targets().flat_map(|(_, target)| ["--test", *target])).collect()
}

/// What follows `cargo test --no-run` to build the programs of the tests, with which cargo builds them, and little else.
pub fn arguments_beside_programs() -> Vec<&'static str> {
    packages().chain(["--test", "chain"]).collect()
}

/// The workspace rather than the packages by name: other selections have other features of shared dependencies, so that
/// what `cargo xtask test` has built would be built once more.
fn packages() -> impl Iterator<Item = &'static str> {
    ["--workspace"].into_iter().chain(LEFT_OUT.iter().flat_map(|package| ["--exclude", package]))
}

fn targets() -> impl Iterator<Item = &'static (&'static str, &'static str)> {
    GROUPS.iter().flat_map(|group| group.targets)
}

impl Group {
    /// What it has of the test binaries that ran.
    pub fn of(&self, report: &Report) -> Vec<Binary> {
        report.binaries().iter().filter(|binary| self.has(&binary.name)).cloned().collect()
    }

    /// Names of targets that left no result, as where a binary before them ended the run.
    pub fn missing(&self, report: &Report) -> Vec<&'static str> {
        let ran = |target: &str| report.binaries().iter().any(|binary| target_of(&binary.name) == target);
        self.targets.iter().map(|(_, target)| *target).filter(|target| !ran(target)).collect()
    }

    fn has(&self, binary: &str) -> bool {
        self.targets.iter().any(|(_, target)| *target == target_of(binary))
    }
}

/// Binaries that belong to no group: cargo itself, where something does not build.
pub fn others(report: &Report) -> Vec<Binary> {
    let known = |binary: &&Binary| GROUPS.iter().any(|group| group.has(&binary.name));
    report.binaries().iter().filter(|binary| !known(binary)).cloned().collect()
}

/// The sum over some binaries.
pub fn totals(binaries: &[Binary]) -> Totals {
    let mut sum = Totals::default();
    binaries.iter().for_each(|binary| sum.add(binary.totals));
    sum
}

/// `surface` of `surface  tests/surface.rs`.
fn target_of(binary: &str) -> &str {
    binary.split_whitespace().next().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_target_is_there_and_no_other_goes_by_its_name() {
        let metadata = cargo_metadata::MetadataCommand::new().no_deps().exec().unwrap();
        let chosen = |target: &cargo_metadata::Target| {
            target.is_test() && targets().any(|(_, name)| *name == target.name)
        };
        let packages = metadata.packages.iter().filter(|p| !LEFT_OUT.contains(&p.name.as_str()));
        let mut run: Vec<(&str, &str)> = packages
            .flat_map(|p| p.targets.iter().filter(|t| chosen(t)).map(|t| (p.name.as_str(), t.name.as_str())))
            .collect();
        let mut listed: Vec<(&str, &str)> = targets().copied().collect();
        run.sort_unstable();
        listed.sort_unstable();
        assert_eq!(run, listed, "cargo announces results without the package: leave out one, or rename");
    }

    #[test]
    fn results_go_to_their_groups_and_what_did_not_run_is_named() {
        let mut report = Report::default();
        for line in [
            "     Running tests/sphere.rs (target/debug/deps/sphere-00)",
            "test result: ok. 2 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.10s",
            "     Running tests/chain/main.rs (target/debug/deps/chain-00)",
            "test result: FAILED. 1 passed; 3 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.10s",
        ] {
            report.read(line);
        }
        let [twins, chain, ..] = GROUPS else { panic!() };
        assert_eq!(totals(&twins.of(&report)).passed, 2);
        assert_eq!(totals(&chain.of(&report)).failed, 3);
        assert!(chain.missing(&report).is_empty() && twins.missing(&report).contains(&"surface"));
        assert!(others(&report).is_empty());
    }
}
