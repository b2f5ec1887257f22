//! What `bench --play` found, as JSON has it.

use std::path::PathBuf;

use meniscus_core::Flaws;
use meniscus_prefetch::{FrameRecord, FrameState};
use serde::Serialize;
use serde_json::{Map, Value};

use super::super::spread::Spread;
use super::jumps::JumpReport;

/// All of it. Rates are in MB (10^6 bytes) of file per second.
#[derive(Debug, Serialize)]
pub struct PlayReport {
    /// As typed.
    pub command: Vec<String>,
    /// When it ended, seconds since 1970.
    pub unix_time_s: u64,
    /// What of the set-up `render --report` says too, by the same names.
    #[serde(flatten)]
    pub setup: Map<String, Value>,
    pub input: PathBuf,
    pub adapter: String,
    pub driver: String,
    pub size: [u32; 2],
    /// Threads that work on a frame, and frames that are read at once.
    pub threads: usize,
    pub readers: usize,
    pub apart: ApartReport,
    pub play: PlayFigures,
    /// With `--jumps`; there is no playing then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jumps: Option<JumpReport>,
    pub memory: MemoryReport,
    pub frames: Vec<FrameEntry>,
    pub flaws: Flaws,
}

/// Frames read and drawn one after the other, the files in the system's cache from the second look on.
#[derive(Debug, Serialize)]
pub struct ApartReport {
    pub read_ms: Option<Spread>,
    pub read_cpu_ms: Option<Spread>,
    pub draw_ms: Option<Spread>,
    pub draw_cpu_ms: Option<Spread>,
}

/// Playing.
#[derive(Debug, Serialize)]
pub struct PlayFigures {
    pub pictures: u64,
    /// Pictures that could not be shown because their frames failed.
    pub missing: u64,
    /// From the wish to play until as many frames are there as are read at once, or as memory has room for.
    pub start_ms: f64,
    /// From then on to the end.
    pub wall_ms: f64,
    /// From picture to picture.
    pub picture_ms: Option<Spread>,
    /// Uploading and drawing, of that.
    pub draw_ms: Option<Spread>,
    /// Pictures after the first that had to wait for their frame.
    pub stalls: u64,
    pub stall_share: f64,
    pub stalled_ms: f64,
    /// Of the whole process, from the wish to play to the end.
    pub cpu_ms: f64,
    /// What the frames read and the pictures drawn cost apart, summed up.
    pub cpu_apart_ms: f64,
    pub frames_read: u64,
    pub reads_cancelled: u64,
    pub reads_failed: u64,
    /// Frames that were in memory or had failed and were given up, to be read again, because their files had changed.
    pub frames_changed: u64,
    /// Frames that joined the series.
    pub frames_added: usize,
    /// Sets of particles that were uploaded when they were to be drawn, that were uploaded while others were drawn, and that were
    /// on the GPU when they were to be drawn: uploaded ahead, or kept since they were last shown.
    pub uploads: u64,
    pub uploads_ahead: u64,
    pub found_on_gpu: u64,
    /// What came while something was being read.
    pub delivered_mb_per_s: Option<f64>,
    /// What the medium gives to one who reads files one after the other and does not look at them.
    pub medium_mb_per_s: Option<f64>,
    /// Where that comes from: `emulated`, `files, not cached`, `files, cached`.
    pub medium: &'static str,
}

/// Memory in bytes.
#[derive(Debug, Serialize)]
pub struct MemoryReport {
    /// For frames, at the end.
    pub budget_bytes: u64,
    /// Frames ready or being read, at most.
    pub peak_held_bytes: u64,
    /// By how much the ready ones have exceeded the budget of their time, at most.
    pub peak_over_budget_bytes: u64,
    /// Of the process, without pages of mapped files, before playing, and at most while playing, seen once per picture.
    pub resident_before_bytes: Option<u64>,
    pub resident_peak_bytes: Option<u64>,
    /// On the GPU, for particles: the budget, and what they took at most. What is drawn is there in any case.
    pub gpu_budget_bytes: u64,
    pub gpu_peak_particle_bytes: u64,
    /// Buffers and textures, at most.
    pub gpu_peak_bytes: u64,
}

/// One frame of the series.
#[derive(Clone, Debug, Serialize)]
pub struct FrameEntry {
    pub frame: usize,
    pub state: &'static str,
    /// Memory that it takes, where it is ready.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bytes: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file_bytes: Option<u64>,
    /// Its last read, with preparing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub read_ms: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mb_per_s: Option<f64>,
    pub reads: u32,
    pub stalls: u32,
    pub stalled_ms: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
}

impl FrameEntry {
    pub fn new(frame: usize, record: &FrameRecord) -> Self {
        let seconds = record.read_time.map(|time| time.as_secs_f64());
        Self {
            frame,
            state: record.state.as_str(),
            bytes: match record.state {
                FrameState::Ready { bytes } => Some(bytes),
                _ => None,
            },
            file_bytes: record.file_bytes,
            read_ms: seconds.map(|s| s * 1e3),
            mb_per_s: record.file_bytes.zip(seconds).map(|(bytes, s)| bytes as f64 / 1e6 / s),
            reads: record.reads,
            stalls: record.stalls,
            stalled_ms: record.stalled.as_secs_f64() * 1e3,
            error: record.error.as_ref().map(ToString::to_string),
        }
    }
}
