use serde::Serialize;

use crate::{Flaws, WorkCounters};

/// What one stage of one frame cost. A pass that did not run has no entry; a clock that is not trusted is `None`, never
/// zero.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct StageCost {
    /// `stage.pass`, e.g. `ssfr.depth`.
    pub name: String,
    /// GPU milliseconds from time stamps.
    pub gpu_ms: Option<f64>,
    /// Wall-clock milliseconds, where the stage was run on its own.
    pub wall_ms: Option<f64>,
    /// User + system milliseconds of the whole process, where the stage was run on its own.
    pub cpu_ms: Option<f64>,
}

/// An automatic choice and how to override it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// What was chosen, e.g. `up axis`.
    pub what: String,
    /// The value.
    pub value: String,
    /// Why.
    pub reason: String,
    /// The flag that overrides it.
    pub flag: String,
}

impl std::fmt::Display for Choice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {} ({}; override with {})", self.what, self.value, self.reason, self.flag)
    }
}

/// Everything a picture says about itself.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FrameReport {
    /// Index in the series.
    pub frame: usize,
    /// Simulation time.
    pub time: Option<f64>,
    /// How much work it was.
    pub counters: WorkCounters,
    /// Cost per stage, in the order run.
    pub stages: Vec<StageCost>,
    /// Ways in which the picture is not what was asked.
    pub flaws: Flaws,
}

impl FrameReport {
    /// Adds what another picture took that goes into the same one.
    pub fn add(&mut self, other: &Self) {
        self.counters = self.counters.plus(&other.counters);
        self.flaws.merge(&other.flaws);
        for cost in &other.stages {
            match self.stages.iter_mut().find(|stage| stage.name == cost.name) {
                Some(stage) => stage.add(cost),
                None => self.stages.push(cost.clone()),
            }
        }
    }
}

impl StageCost {
    /// Adds what the same stage cost another time.
    fn add(&mut self, other: &Self) {
        let sum = |a: Option<f64>, b: Option<f64>| a.zip(b).map(|(a, b)| a + b);
        self.gpu_ms = sum(self.gpu_ms, other.gpu_ms);
        self.wall_ms = sum(self.wall_ms, other.wall_ms);
        self.cpu_ms = sum(self.cpu_ms, other.cpu_ms);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn costs_of_a_picture_in_parts_add_up_by_stage() {
        let cost =
            |name: &str, ms| StageCost { name: name.into(), gpu_ms: ms, wall_ms: Some(1.0), cpu_ms: None };
        let mut report =
            FrameReport { stages: vec![cost("a", Some(1.0)), cost("b", None)], ..Default::default() };
        let other =
            FrameReport { stages: vec![cost("c", Some(3.0)), cost("a", Some(2.0))], ..Default::default() };
        report.add(&other);
        let expected = [("a", Some(3.0), 2.0), ("b", None, 1.0), ("c", Some(3.0), 1.0)];
        let found: Vec<_> =
            report.stages.iter().map(|s| (s.name.as_str(), s.gpu_ms, s.wall_ms.unwrap())).collect();
        assert_eq!(found, expected);
    }
}
