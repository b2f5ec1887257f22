//! `meniscus bench --compare`: what two runs differ in, first in what was asked, then in what it cost.

mod run;
mod table;

use std::path::PathBuf;

use serde::Serialize;
use serde_json::Value;

use self::run::{Clocks, Run};
use super::spread::Spread;
use crate::failure::Failure;
use crate::terminal::print;

/// Two runs side by side.
#[derive(Debug, Serialize)]
struct Comparison {
    a: PathBuf,
    b: PathBuf,
    /// What else the runs differ in: a ratio between unlike runs is not the speed of the program.
    differences: Vec<Difference>,
    whole_frame: Vec<Pair>,
    stages: Vec<StagePairs>,
}

/// One entry of the set-up; `None` where a run does not have it.
#[derive(Debug, PartialEq, Serialize)]
struct Difference {
    key: String,
    a: Option<Value>,
    b: Option<Value>,
}

/// One clock of both runs; a clock that neither has is absent.
#[derive(Debug, PartialEq, Serialize)]
struct Pair {
    clock: &'static str,
    a: Option<Spread>,
    b: Option<Spread>,
    /// Median of B over median of A.
    ratio: Option<f64>,
    /// Whether the ranges from smallest to largest overlap: then the ratio may be noise.
    overlap: Option<bool>,
}

#[derive(Debug, Serialize)]
struct StagePairs {
    name: String,
    clocks: Vec<Pair>,
}

/// Names of clocks, as in the JSON of a run.
const CLOCKS: [&str; 3] = ["gpu_ms", "wall_ms", "cpu_ms"];

/// Compares the runs in the files `[a, b]`.
pub fn run(paths: &[PathBuf], json: bool) -> Result<(), Failure> {
    let [a, b] = paths else {
        return Err(Failure::Usage("--compare: give two files, A.json and B.json".into()));
    };
    let comparison = compare(&Run::read(a)?, &Run::read(b)?);
    if json {
        print(serde_json::to_string_pretty(&comparison).unwrap_or_default());
    } else {
        table::print_table(&comparison);
    }
    Ok(())
}

fn compare(a: &Run, b: &Run) -> Comparison {
    // Stages in A's order; those that only B has come last, in B's.
    let only_b = b.stages.iter().filter(|(name, _)| a.stage(name).is_none());
    let names = a.stages.iter().chain(only_b).map(|(name, _)| name);
    let stages = names
        .map(|name| StagePairs { name: name.clone(), clocks: pairs(a.stage(name), b.stage(name)) })
        .collect();
    Comparison {
        a: a.path.clone(),
        b: b.path.clone(),
        differences: differences(a, b),
        whole_frame: pairs(Some(&a.frame), Some(&b.frame)),
        stages,
    }
}

fn pairs(a: Option<&Clocks>, b: Option<&Clocks>) -> Vec<Pair> {
    let clock = |run: Option<&Clocks>, index: usize| run.and_then(|clocks| clocks[index]);
    CLOCKS
        .iter()
        .enumerate()
        .map(|(index, name)| pair(name, clock(a, index), clock(b, index)))
        .filter(|pair| pair.a.is_some() || pair.b.is_some())
        .collect()
}

fn pair(clock: &'static str, a: Option<Spread>, b: Option<Spread>) -> Pair {
    let both = a.zip(b);
    Pair {
        clock,
        a,
        b,
        // Nothing is so many times slower than no time at all.
        ratio: both.filter(|(a, _)| a.median > 0.0).map(|(a, b)| b.median / a.median),
        overlap: both.map(|(a, b)| a.min <= b.max && b.min <= a.max),
    }
}

/// Entries that differ, in A's order, then those that only B has.
fn differences(a: &Run, b: &Run) -> Vec<Difference> {
    let find =
        |run: &Run, key: &str| run.setup.iter().find(|(k, _)| k == key).map(|(_, value)| value.clone());
    let only_b = b.setup.iter().filter(|(key, _)| find(a, key).is_none());
    a.setup
        .iter()
        .chain(only_b)
        .map(|(key, _)| Difference { key: key.clone(), a: find(a, key), b: find(b, key) })
        .filter(|d| d.a != d.b)
        // A bench and a report do not say the same things; what both say is compared.
        .filter(|d| a.kind == b.kind || (d.a.is_some() && d.b.is_some()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spread(min: f64, median: f64, max: f64) -> Option<Spread> {
        Some(Spread { median, min, max })
    }

    #[test]
    fn ratios_are_of_medians_and_noise_is_marked() {
        let faster = pair("wall_ms", spread(9.0, 10.0, 11.0), spread(4.0, 5.0, 6.0));
        assert_eq!((faster.ratio, faster.overlap), (Some(0.5), Some(false)));
        let same = pair("wall_ms", spread(9.0, 10.0, 11.0), spread(10.5, 12.0, 20.0));
        assert_eq!((same.ratio, same.overlap), (Some(1.2), Some(true)));
        let missing = pair("gpu_ms", None, spread(1.0, 1.0, 1.0));
        assert_eq!((missing.ratio, missing.overlap), (None, None));
        assert_eq!(pair("cpu_ms", spread(0.0, 0.0, 0.0), spread(1.0, 1.0, 1.0)).ratio, None);
    }

    #[test]
    fn what_differs_is_listed_once() {
        let run = |kind: &'static str, setup: &[(&str, Value)]| Run {
            path: PathBuf::new(),
            kind,
            setup: setup.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect(),
            frame: [None; 3],
            stages: Vec::new(),
        };
        let a = run("bench", &[("size.0", 64.into()), ("threads", 2.into())]);
        let b = run("bench", &[("size.0", 32.into()), ("threads", 2.into()), ("lod", 1.into())]);
        let found = |a: &Run, b: &Run| -> Vec<String> {
            differences(a, b).into_iter().map(|difference| difference.key).collect()
        };
        assert_eq!(found(&a, &b), ["size.0", "lod"]);
        assert_eq!(found(&a, &a), [""; 0]);
        let report = run("report", &[("size.0", 32.into()), ("lod", 1.into())]);
        assert_eq!(found(&a, &report), ["size.0"]);
    }
}
