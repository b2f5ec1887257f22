use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::{Duration, Instant};

use crossbeam::channel::{Receiver, Sender};
use meniscus_core::{Cancel, FrameError, FrameErrorKind, FrameRequest, FrameSource, SetFrame};

use crate::coordinator::Message;

/// A frame to be read.
pub(crate) struct Job {
    pub frame: usize,
    pub cancel: Cancel,
    /// The part of the frame that a first impression of it takes; `None` to read the whole right away.
    pub coarse_share: Option<u32>,
}

/// How a read ended.
pub(crate) struct Finished<P> {
    pub frame: usize,
    /// The frame, or why there is none.
    pub result: Result<Delivered<P>, FrameError>,
    pub took: Duration,
    /// [`FrameSource::version`] before it was read.
    pub version: Option<u64>,
}

/// A frame as it was read.
pub(crate) struct Delivered<P> {
    pub prepared: P,
    /// Memory that it takes.
    pub bytes: u64,
    /// Bytes of files that were decoded for it, where the source counts.
    pub file_bytes: Option<u64>,
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
    pub(crate) fn run(&self, jobs: &Receiver<Job>, results: &Sender<Message<P>>) {
        for job in jobs {
            let (frame, started) = (job.frame, Instant::now());
            // A panic in a reader or in the caller's code costs this frame, not the program: somebody may be waiting.
            let read = catch_unwind(AssertUnwindSafe(|| self.read(&job, results)));
            let (version, result) = read.unwrap_or_else(|panic| (None, Err(panicked(frame, &*panic))));
            let finished = Finished { frame, result, took: started.elapsed(), version };
            if results.send(Message::Finished(finished)).is_err() {
                return;
            }
        }
    }

    /// The version of the frame's files and the frame, after its first impression where one is wanted.
    fn read(
        &self,
        job: &Job,
        results: &Sender<Message<P>>,
    ) -> (Option<u64>, Result<Delivered<P>, FrameError>) {
        // Before reading: what is written meanwhile is a change.
        let version = self.source.version(job.frame);
        let coarse = job.coarse_share.map_or(Ok(()), |share| self.read_coarse(job, share, results));
        (version, coarse.and_then(|()| self.read_whole(job)))
    }

    fn read_coarse(&self, job: &Job, share: u32, results: &Sender<Message<P>>) -> Result<(), FrameError> {
        if let Some(read) = self.source.read_coarse(job.frame, share, &self.request, &job.cancel)? {
            let prepared = (self.prepare)(read);
            // Nobody is there any more to look at it: then the whole is not sent either.
            let _ = results.send(Message::Coarse { frame: job.frame, prepared });
        }
        Ok(())
    }

    fn read_whole(&self, Job { frame, cancel, .. }: &Job) -> Result<Delivered<P>, FrameError> {
        if cancel.is_cancelled() {
            return Err(cancelled(*frame));
        }
        let read = self.source.read(*frame, &self.request, cancel)?;
        if cancel.is_cancelled() {
            return Err(cancelled(*frame));
        }
        let file_bytes = read.read.map(|read| read.bytes);
        let prepared = (self.prepare)(read);
        let bytes = (self.bytes_of)(&prepared);
        Ok(Delivered { prepared, bytes, file_bytes })
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
