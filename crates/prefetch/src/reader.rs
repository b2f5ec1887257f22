use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use crossbeam::channel::{Receiver, Sender};
use meniscus_core::{Cancel, FrameError, FrameErrorKind, FrameRequest, FrameSource, SetFrame};

/// A frame to be read.
pub(crate) struct Job {
    pub frame: usize,
    pub cancel: Cancel,
}

/// How a read ended: the prepared frame and its bytes, or why there is none.
pub(crate) struct Finished<P> {
    pub frame: usize,
    pub result: Result<(P, u64), FrameError>,
}

/// What a reader thread needs.
pub(crate) struct Reader<P> {
    pub source: Arc<dyn FrameSource>,
    pub request: FrameRequest,
    pub prepare: Box<dyn Fn(SetFrame) -> P + Send + Sync>,
    pub bytes_of: Box<dyn Fn(&P) -> u64 + Send + Sync>,
}

impl<P> Reader<P> {
    /// Reads and prepares one frame after the other until no more can come.
    pub(crate) fn run<M: From<Finished<P>>>(&self, jobs: &Receiver<Job>, results: &Sender<M>) {
        for Job { frame, cancel } in jobs {
            // A panic in a reader or in the caller's code costs this frame, not the program: somebody may be waiting.
            let result = catch_unwind(AssertUnwindSafe(|| self.read(frame, &cancel)))
                .unwrap_or_else(|panic| Err(panicked(frame, &*panic)));
            if results.send(Finished { frame, result }.into()).is_err() {
                return;
            }
        }
    }

    fn read(&self, frame: usize, cancel: &Cancel) -> Result<(P, u64), FrameError> {
        if cancel.is_cancelled() {
            return Err(cancelled(frame));
        }
        let read = self.source.read(frame, &self.request, cancel)?;
        if cancel.is_cancelled() {
            return Err(cancelled(frame));
        }
        let prepared = (self.prepare)(read);
        let bytes = (self.bytes_of)(&prepared);
        Ok((prepared, bytes))
    }
}

fn cancelled(frame: usize) -> FrameError {
    FrameError {
        kind: FrameErrorKind::Cancelled,
        file: None,
        message: format!("frame {frame} was cancelled"),
    }
}

fn panicked(frame: usize, panic: &(dyn Any + Send)) -> FrameError {
    let reason = panic
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no reason given");
    FrameError {
        kind: FrameErrorKind::Io,
        file: None,
        message: format!("frame {frame}: internal error while reading ({reason}); please report it"),
    }
}
