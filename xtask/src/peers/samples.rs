//! Milliseconds of many runs.

use serde::{Deserialize, Serialize};

/// Times of the same work, in milliseconds.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize)]
pub struct Samples {
    /// Wall clock.
    pub wall_ms: Vec<f64>,
    /// User + system time of all threads.
    pub cpu_ms: Vec<f64>,
}

impl Samples {
    /// One more.
    pub fn add(&mut self, wall_ms: f64, cpu_ms: f64) {
        self.wall_ms.push(wall_ms);
        self.cpu_ms.push(cpu_ms);
    }
}

/// The middle of the sorted values; `None` for none.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match sorted.len() {
        0 => None,
        n if n % 2 == 1 => Some(sorted[middle]),
        _ => Some(0.5 * (sorted[middle - 1] + sorted[middle])),
    }
}

/// `median (smallest to largest)`, without decimals where they would be noise.
pub fn spread(values: &[f64]) -> String {
    let Some(middle) = median(values) else { return "-".to_owned() };
    let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = values.iter().copied().fold(0.0, f64::max);
    let digits = if middle < 100.0 { 1 } else { 0 };
    format!("{middle:.digits$} ({smallest:.digits$} to {largest:.digits$})")
}

/// How many times more `theirs` costs than `ours`, by medians.
pub fn ratio(theirs: &[f64], ours: &[f64]) -> Option<f64> {
    let ours = median(ours).filter(|ours| *ours > 0.0)?;
    Some(median(theirs)? / ours)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_are_of_medians_and_need_both() {
        assert_eq!(ratio(&[10.0, 1000.0, 12.0], &[3.0]), Some(4.0));
        assert_eq!(ratio(&[10.0], &[]), None);
        assert_eq!(ratio(&[10.0], &[0.0]), None);
        assert_eq!(ratio(&[], &[1.0]), None);
    }

    #[test]
    fn spreads_show_all_that_was_seen() {
        assert_eq!(spread(&[2.0, 1.0, 4.0, 3.0]), "2.5 (1.0 to 4.0)");
        assert_eq!(spread(&[2000.0]), "2000 (2000 to 2000)");
        assert_eq!(spread(&[]), "-");
    }
}
