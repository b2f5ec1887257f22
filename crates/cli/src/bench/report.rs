//! What `bench` found, as JSON has it.

use std::path::PathBuf;

use meniscus_core::{Flaws, WorkCounters};
use serde::Serialize;
use serde_json::{Map, Value};

use super::spread::Spread;
use super::stages::StageSamples;

/// All of it.
#[derive(Debug, Serialize)]
pub struct BenchReport {
    /// As typed.
    pub command: Vec<String>,
    /// When it ended, seconds since 1970.
    pub unix_time_s: u64,
    /// What of the set-up `render --report` says too, by the same names.
    #[serde(flatten)]
    pub setup: Map<String, Value>,
    pub input: PathBuf,
    /// Frame of the series that was drawn.
    pub series_frame: usize,
    /// Pictures measured.
    pub pictures: u32,
    /// Pictures drawn before those.
    pub warmup_pictures: u32,
    /// How far the camera went from picture to picture.
    pub orbit_deg_per_picture: f32,
    /// Worker threads.
    pub threads: usize,
    pub adapter: String,
    pub driver: String,
    pub size: [u32; 2],
    pub particles: u64,
    pub kept: u64,
    pub covered_fraction: f64,
    /// Of the drawn frame, several times; the files are in the system's cache from the second time on.
    pub read_ms: Option<Spread>,
    /// Bringing it into chunk order, on the same occasions.
    pub prepare_ms: Option<Spread>,
    /// The first picture of all: uploads, allocations and compilation by the driver. `None` without warm-up.
    pub first_picture_ms: Option<f64>,
    pub frame: FrameSpread,
    pub stages: Vec<StageSpread>,
    pub counters: WorkCounters,
    pub peak_bytes: u64,
    pub flaws: Flaws,
}

/// Clocks of whole frames.
#[derive(Debug, Serialize)]
pub struct FrameSpread {
    pub wall_ms: Option<Spread>,
    pub cpu_ms: Option<Spread>,
    pub gpu_ms: Option<Spread>,
}

/// Clocks of one stage, absent ones `None`.
#[derive(Debug, Serialize)]
pub struct StageSpread {
    pub name: String,
    pub gpu_ms: Option<Spread>,
    pub wall_ms: Option<Spread>,
    pub cpu_ms: Option<Spread>,
}

impl StageSpread {
    /// Of every stage in `samples`.
    pub fn all(samples: &StageSamples) -> Vec<Self> {
        let stage = |(name, [gpu_ms, wall_ms, cpu_ms]): (&str, [Option<Spread>; 3])| Self {
            name: name.to_owned(),
            gpu_ms,
            wall_ms,
            cpu_ms,
        };
        samples.spreads().map(stage).collect()
    }

    /// The best clock there is: the GPU's, else the wall's.
    pub fn time_ms(&self) -> Option<f64> {
        self.gpu_ms.or(self.wall_ms).map(|spread| spread.median)
    }
}
