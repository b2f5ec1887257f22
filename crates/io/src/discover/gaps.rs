//! Numbers that are missing among the files of a series.

use std::path::Path;

use meniscus_core::Choice;

use super::{TimeStep, names};

/// Runs of missing numbers that are listed.
const LISTED: usize = 6;

/// Says which numbers are missing among the files of `steps`, which are in order. Solvers that number by time step leave regular
/// gaps, which are none; of numbers without a rule, or with more missing than there, nothing is said.
pub(super) fn describe(steps: &[TimeStep]) -> Option<Choice> {
    let number = |file: &Path| Some(names::numbered(&file.file_name()?.to_string_lossy())?.1);
    let numbers: Vec<u64> = steps.iter().map(|step| number(step.files.first()?)).collect::<Option<_>>()?;
    let missing = missing(&numbers)?;
    let count: u64 = missing.iter().map(Run::count).sum();
    let mut list: Vec<String> = missing.iter().take(LISTED).map(Run::to_string).collect();
    if missing.len() > LISTED {
        list.push("...".into());
    }
    let (is, files) = if count == 1 { ("is", "file") } else { ("are", "files") };
    Some(Choice {
        what: "frames".into(),
        value: format!("{} files", steps.len()),
        reason: format!(
            "{count} {files} {is} missing: number {}; frames are counted as if there were no gap",
            list.join(", ")
        ),
        flag: "INPUT".into(),
    })
}

/// Numbers that follow each other.
struct Run {
    first: u64,
    last: u64,
    step: u64,
}

impl Run {
    fn count(&self) -> u64 {
        (self.last - self.first) / self.step + 1
    }
}

impl std::fmt::Display for Run {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.first == self.last {
            true => write!(f, "{}", self.first),
            false => write!(f, "{} to {}", self.first, self.last),
        }
    }
}

/// The gaps in `numbers`, whose smallest step is the usual one; `None` without a gap, or where they are no gaps.
fn missing(numbers: &[u64]) -> Option<Vec<Run>> {
    let pairs = || numbers.windows(2).map(|pair| [pair[0], pair[1]]);
    // Names such as `a_7` and `a_07` have the same number.
    let steps: Vec<u64> = pairs().map(|[a, b]| b.checked_sub(a)).collect::<Option<_>>()?;
    let step = steps.iter().copied().min().filter(|step| *step > 0)?;
    if steps.iter().any(|other| !other.is_multiple_of(step)) {
        return None;
    }
    let gap = |[a, b]: [u64; 2]| (b - a > step).then(|| Run { first: a + step, last: b - step, step });
    let gaps: Vec<Run> = pairs().filter_map(gap).collect();
    let count: u64 = gaps.iter().map(Run::count).sum();
    (count > 0 && count < numbers.len() as u64).then_some(gaps)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_told_from_the_steps_of_a_solver() {
        let of = |numbers: &[u64]| {
            missing(numbers).map(|runs| runs.iter().map(Run::to_string).collect::<Vec<_>>().join(", "))
        };
        assert_eq!(of(&[0, 1, 2, 3, 4, 6, 7, 8]).as_deref(), Some("5"));
        assert_eq!(of(&[3, 4, 7, 8, 9, 11]).as_deref(), Some("5 to 6, 10"));
        assert_eq!(of(&[0, 10, 20, 50, 60]).as_deref(), Some("30 to 40"));
        // Regular, irregular, more missing than there, the same number twice, nothing to compare.
        for none in [&[0, 10, 20][..], &[0, 7, 13, 22], &[0, 1, 100], &[1, 1, 3], &[4], &[], &[0, u64::MAX]] {
            assert_eq!(of(none), None, "{none:?}");
        }
    }
}
