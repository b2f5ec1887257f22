//! What criterion does not carry: CPU and GPU time beside the wall, bytes moved, and how fast this machine copies.

use std::io::Write;

use serde::Serialize;

/// The variable with which `cargo xtask bench` asks for records: a file to append them to, one JSON object per line.
const RECORDS: &str = "MENISCUS_BENCH_RECORDS";

/// What one run of the measured work took; milliseconds.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Sample {
    /// On the wall.
    pub wall_ms: f64,
    /// User + system, all threads of the process.
    pub cpu_ms: f64,
    /// By time stamps of the GPU; `None` where they are not trusted, and for work without a GPU.
    pub gpu_ms: Option<f64>,
}

impl Sample {
    /// The least that each clock showed, since whoever else uses the machine can only add to it; `None` without samples.
    pub(crate) fn least(samples: &[Self]) -> Option<Self> {
        let least = |ms: fn(&Self) -> Option<f64>| samples.iter().filter_map(ms).reduce(f64::min);
        Some(Self {
            wall_ms: least(|sample| Some(sample.wall_ms))?,
            cpu_ms: least(|sample| Some(sample.cpu_ms))?,
            gpu_ms: least(|sample| sample.gpu_ms),
        })
    }
}

/// One bench.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Record<'a> {
    pub stage: &'a str,
    pub bench: &'a str,
    pub view: &'a str,
    /// Adapter and driver, or `CPU`.
    pub device: &'a str,
    /// Bytes that the work has to read and write at least; `None` where there is no such number.
    pub bytes: Option<u64>,
    /// Bytes read and written per second by a copy on the same device in the same run, 1e9.
    pub copy_gb_per_s: f64,
    pub samples: &'a [Sample],
}

impl Record<'_> {
    /// Hands the record over, if somebody asked for it.
    pub(crate) fn append(&self) {
        let Some(path) = std::env::var_os(RECORDS) else { return };
        let line = serde_json::to_string(self).expect("numbers and text");
        let file = std::fs::OpenOptions::new().create(true).append(true).open(&path);
        file.and_then(|mut file| writeln!(file, "{line}"))
            .unwrap_or_else(|error| panic!("{RECORDS}={}: {error}", path.display()));
    }
}
