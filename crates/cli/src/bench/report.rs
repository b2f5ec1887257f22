//! What `bench` found, as JSON has it.

use meniscus_core::{Flaws, StageCost};
use serde::Serialize;

use super::spread::Spread;

/// All of it.
#[derive(Debug, Serialize)]
pub struct BenchReport {
    pub adapter: String,
    pub driver: String,
    pub size: [u32; 2],
    pub particles: u64,
    pub kept: u64,
    pub covered_fraction: f64,
    pub frame: FrameSpread,
    pub stages: Vec<StageCost>,
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
