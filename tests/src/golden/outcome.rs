//! What a run of the cases found, for people and for the report.

use serde::Serialize;

use super::Metric;

/// How a case ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// Within all limits.
    Passed,
    /// Outside of one, or not comparable.
    Failed,
    /// The expectation was replaced because somebody asked for it.
    Updated,
}

/// Milliseconds of a pass.
#[derive(Clone, Debug, Serialize)]
pub struct StageTime {
    /// Name of the pass.
    pub name: String,
    /// Wall time, or GPU time where the driver's stamps are believed.
    pub ms: f64,
}

/// The pictures of a case, paths inside of the output folder.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Pictures {
    /// What was drawn.
    pub ours: Option<String>,
    /// What was expected.
    pub expected: Option<String>,
    /// FLIP error as colours.
    pub flip: Option<String>,
}

/// One case.
#[derive(Clone, Debug, Serialize)]
pub struct CaseOutcome {
    /// Its name.
    pub name: String,
    /// What it is there for.
    pub why: String,
    /// Lines to type that make data and picture.
    pub commands: [String; 2],
    /// How it ended.
    pub status: Status,
    /// Why it failed, where no limit says so.
    pub problem: Option<String>,
    /// Values beside their limits; for an updated case against the expectation that it replaced.
    pub metrics: Vec<Metric>,
    /// The pictures.
    pub pictures: Pictures,
    /// Passes of the picture.
    pub stages: Vec<StageTime>,
    /// What made the expected image.
    pub made_by: Option<super::Origin>,
    /// Whether the limits are those for the driver that made it.
    pub same_driver: bool,
    /// Time that the case took.
    pub elapsed_s: f64,
}

/// All of them.
#[derive(Clone, Debug, Serialize)]
pub struct RunOutcome {
    /// Adapter and driver.
    pub driver: String,
    /// Version of the program.
    pub version: String,
    /// Commit of the source.
    pub commit: String,
    /// The cases.
    pub cases: Vec<CaseOutcome>,
    /// Expected files that belong to no case.
    pub stale: Vec<String>,
}

impl RunOutcome {
    /// Whether something was checked and nothing was wrong.
    pub fn passed(&self) -> bool {
        !self.cases.is_empty()
            && self.stale.is_empty()
            && self.cases.iter().all(|case| case.status != Status::Failed)
    }
}
