//! Which frame of a set's own files is shown with a frame of the series.

use std::collections::HashSet;

use meniscus_core::Choice;

use super::sets::{SetPlan, SetSource};
use super::survey::choice;
use crate::discover::TimeStep;

/// The step of a companion series that is shown with frame `index` at `time`: the nearest in time where both know theirs, else
/// the same index, else the last.
pub(crate) fn companion(steps: &[TimeStep], index: usize, time: Option<f64>) -> Option<&TimeStep> {
    place(steps, index, time).map(|place| &steps[place])
}

fn place(steps: &[TimeStep], index: usize, time: Option<f64>) -> Option<usize> {
    let nearest = time.and_then(|time| {
        let known = steps.iter().enumerate().filter_map(|(i, step)| Some((i, (step.time? - time).abs())));
        known.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
    });
    nearest.or_else(|| Some(index.min(steps.len().checked_sub(1)?)))
}

/// Says which sets have fewer frames than the series `steps`, so that some frames share one.
pub(super) fn describe(steps: &[TimeStep], plans: &[SetPlan], choices: &mut Vec<Choice>) {
    for plan in plans {
        let SetSource::Files(own) = &plan.source else { continue };
        let used: HashSet<usize> =
            steps.iter().enumerate().filter_map(|(index, step)| place(own, index, step.time)).collect();
        if used.len() < steps.len() {
            let frames = if used.len() == 1 { "frame" } else { "frames" };
            choices.push(choice(
                &format!("set {}", plan.name),
                format!("{} {frames} for all {} of the series", used.len(), steps.len()),
                "where it has none of that time or index, the nearest is shown".into(),
                &format!("--set {}=FILES, a series of as many frames", plan.name),
            ));
        }
    }
}
