//! Every frame read and drawn without reading ahead: what playing is compared with.

use std::collections::HashMap;
use std::time::Instant;

use meniscus_core::{Cancel, FrameSource};
use meniscus_gpu::process_cpu_ms;
use meniscus_pipeline::Preparer;

use super::super::{Orbit, ms_since};
use crate::failure::Failure;
use crate::picture::Studio;

/// What a frame costs when nothing else runs.
#[derive(Clone, Copy, Debug, Default)]
pub struct FrameCost {
    /// Reading and preparing.
    pub read_ms: f64,
    pub read_cpu_ms: f64,
    /// Uploading and drawing.
    pub draw_ms: f64,
    pub draw_cpu_ms: f64,
    /// Bytes of its files that are decoded.
    pub file_bytes: u64,
}

/// The costs of all frames that could be read.
pub struct Apart {
    costs: HashMap<usize, FrameCost>,
    mean: FrameCost,
}

impl Apart {
    /// Reads and draws `frames` one after the other; `done` is called after each.
    pub fn measure(
        source: &dyn FrameSource,
        preparer: &Preparer,
        frames: &[usize],
        studio: &mut Studio,
        orbit: &mut Orbit,
        cancel: &Cancel,
        done: impl Fn(),
    ) -> Result<Self, Failure> {
        let mut costs = HashMap::new();
        for &index in frames {
            let (started, cpu) = (Instant::now(), process_cpu_ms());
            // What is wrong with a frame is said when it is played.
            if let Ok(read) = source.read(index, studio.world.request(), cancel) {
                let file_bytes = read.read.map_or(0, |read| read.bytes);
                let frame = preparer.prepare(read);
                let (read_ms, read_cpu_ms) = (ms_since(started), process_cpu_ms() - cpu);
                let (started, cpu) = (Instant::now(), process_cpu_ms());
                orbit.draw(studio, &frame, cancel)?;
                let (draw_ms, draw_cpu_ms) = (ms_since(started), process_cpu_ms() - cpu);
                costs.insert(index, FrameCost { read_ms, read_cpu_ms, draw_ms, draw_cpu_ms, file_bytes });
            }
            if cancel.is_cancelled() {
                return Err(Failure::Interrupted);
            }
            done();
        }
        Ok(Self { mean: mean(costs.values()), costs })
    }

    /// The cost of frame `index`; the mean where it was not measured.
    pub fn cost(&self, index: usize) -> FrameCost {
        self.costs.get(&index).copied().unwrap_or(self.mean)
    }

    /// The mean over all frames.
    pub fn mean(&self) -> FrameCost {
        self.mean
    }

    /// One figure of all frames.
    pub fn each(&self, figure: impl Fn(&FrameCost) -> f64) -> Vec<f64> {
        self.costs.values().map(figure).collect()
    }
}

fn mean<'a>(costs: impl ExactSizeIterator<Item = &'a FrameCost>) -> FrameCost {
    let count = costs.len().max(1) as f64;
    let mut mean = FrameCost::default();
    let mut bytes = 0.0;
    for cost in costs {
        mean.read_ms += cost.read_ms / count;
        mean.read_cpu_ms += cost.read_cpu_ms / count;
        mean.draw_ms += cost.draw_ms / count;
        mean.draw_cpu_ms += cost.draw_cpu_ms / count;
        bytes += cost.file_bytes as f64 / count;
    }
    FrameCost { file_bytes: bytes as u64, ..mean }
}
