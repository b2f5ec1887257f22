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
