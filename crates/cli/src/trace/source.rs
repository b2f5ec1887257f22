//! A source that notes when it was read, and by which thread.

use std::sync::Arc;
use std::time::Instant;

use meniscus_core::{Cancel, FrameError, FrameRequest, FrameSource, SetFrame};
use serde_json::{Value, json};

use super::{Trace, Track};

/// Another source, traced.
pub struct TracedSource {
    inner: Arc<dyn FrameSource>,
    trace: Arc<Trace>,
}

impl TracedSource {
    /// `inner` as it is, noted in `trace`.
    pub fn new(inner: Arc<dyn FrameSource>, trace: Arc<Trace>) -> Self {
        Self { inner, trace }
    }
}

impl FrameSource for TracedSource {
    fn frame_count(&self) -> usize {
        self.inner.frame_count()
    }

    fn time(&self, index: usize) -> Option<f64> {
        self.inner.time(index)
    }

    fn estimated_bytes(&self, index: usize) -> u64 {
        self.inner.estimated_bytes(index)
    }

    fn read(&self, index: usize, request: &FrameRequest, cancel: &Cancel) -> Result<SetFrame, FrameError> {
        let begin = Instant::now();
        let result = self.inner.read(index, request, cancel);
        let outcome = match &result {
            Ok(frame) => json!({"frame": index, "particles": frame.len()}),
            Err(error) => json!({"frame": index, "error": error.to_string()}),
        };
        self.trace.on_this_thread("read", begin, outcome);
        result
    }

    fn version(&self, index: usize) -> Option<u64> {
        self.inner.version(index)
    }

    fn read_coarse(
        &self,
        index: usize,
        share: u32,
        request: &FrameRequest,
        cancel: &Cancel,
    ) -> Result<Option<SetFrame>, FrameError> {
        let begin = Instant::now();
        let result = self.inner.read_coarse(index, share, request, cancel);
        self.trace.on_this_thread("read a part", begin, json!({"frame": index, "share": share}));
        result
    }
}

impl Trace {
    /// [`Self::span`] on the row of the thread that calls.
    pub fn on_this_thread(&self, name: &'static str, begin: Instant, args: Value) {
        let thread = std::thread::current();
        self.span(Track::Reader(thread.name().unwrap_or("reading").to_owned()), name, begin, args);
    }
}
