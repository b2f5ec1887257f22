//! Times of frames that state none.

use crate::discover::{TimeStep, names};

/// Gives frame after frame `time_step` more, from 0. Where the file names are numbered, missing numbers leave their gap; the
/// common step of the numbers is one time step.
pub(super) fn apply(steps: &mut [TimeStep], time_step: f64) {
    let places = places(steps).unwrap_or_else(|| (0..steps.len() as u64).collect());
    for (step, place) in steps.iter_mut().zip(places) {
        step.time = Some(place as f64 * time_step);
    }
}

/// Places by number, where the names are one numbered series in rising order.
fn places(steps: &[TimeStep]) -> Option<Vec<u64>> {
    let numbered = |step: &TimeStep| names::numbered(&step.files.first()?.file_name()?.to_string_lossy());
    let names: Vec<(String, u64)> = steps.iter().map(numbered).collect::<Option<_>>()?;
    let (stem, first) = names.first()?;
    let rises = names.is_sorted_by(|a, b| a.1 < b.1) && names.iter().all(|(other, _)| other == stem);
    let gcd = names.iter().fold(0, |gcd, (_, number)| gcd_of(gcd, number - first.min(number)));
    (rises && gcd > 0).then(|| names.iter().map(|(_, number)| (number - first) / gcd).collect())
}

fn gcd_of(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd_of(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(names: &[&str]) -> Vec<f64> {
        let step = |name: &&str| TimeStep { time: None, files: vec![name.into()] };
        let mut steps: Vec<TimeStep> = names.iter().map(step).collect();
        apply(&mut steps, 0.5);
        steps.iter().filter_map(|step| step.time).collect()
    }

    #[test]
    fn missing_numbers_leave_gaps() {
        assert_eq!(times(&["f_3.vtu", "f_4.vtu", "f_6.vtu"]), [0.0, 0.5, 1.5]);
        assert_eq!(times(&["f_0.vtu", "f_200.vtu", "f_500.vtu"]), [0.0, 1.0, 2.5]);
        assert_eq!(times(&["a.vtu", "b.vtu"]), [0.0, 0.5]);
        assert_eq!(times(&["f_1.vtu", "g_9.vtu", "f_2.vtu"]), [0.0, 0.5, 1.0]);
        assert_eq!(times(&["f_7.vtu"]), [0.0]);
    }
}
