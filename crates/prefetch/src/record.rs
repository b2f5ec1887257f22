use std::time::Duration;

use meniscus_core::FrameError;

use crate::FrameState;

/// What is known of one frame and what happened to it.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameRecord {
    /// Where it is now.
    pub state: FrameState,
    /// Bytes of its files that were decoded when it was last read, where the source counts.
    pub file_bytes: Option<u64>,
    /// How long its last read took, preparing included, on the wall clock.
    pub read_time: Option<Duration>,
    /// Reads that ended with a frame.
    pub reads: u32,
    /// How often somebody had to wait for it.
    pub stalls: u32,
    /// For how long, all together.
    pub stalled: Duration,
    /// Why the last read failed; `None` once it has been read.
    pub error: Option<FrameError>,
}

impl Default for FrameRecord {
    fn default() -> Self {
        Self {
            state: FrameState::Absent,
            file_bytes: None,
            read_time: None,
            reads: 0,
            stalls: 0,
            stalled: Duration::ZERO,
            error: None,
        }
    }
}
