use std::sync::Arc;
use std::thread::{self, JoinHandle};

use crossbeam::channel::{self, Sender};
use meniscus_core::{FrameError, FrameErrorKind, FrameRequest, FrameSource, SetFrame};

use crate::coordinator::{Coordinator, Message};
use crate::reader::Reader;
use crate::{FrameState, MemoryProbe, Plan, PrefetchError, PrefetchStats, SystemMemory};

/// How frames are prefetched.
#[derive(Clone, Debug, PartialEq)]
pub struct PrefetchOptions {
    /// Frames read at once, at least 1 (0 counts as 1).
    pub threads: usize,
    /// Share of the free memory that prefetched frames may take, above 0 and at most 1. What is taken counts as free here,
    /// so the share does not shrink while it is used. The nearer to 1, the slower memory goes back to programs that need it;
    /// at 1 none does.
    pub memory_share: f64,
    /// What of each frame is read.
    pub request: FrameRequest,
}

impl Default for PrefetchOptions {
    /// Two readers, half of the free memory, positions only.
    fn default() -> Self {
        Self { threads: 2, memory_share: 0.5, request: FrameRequest::default() }
    }
}

/// Reads frames ahead on threads of its own and hands them out prepared, as `P`.
///
/// Nothing is read before a plan is set or a frame is taken. Dropping it cancels what is being read and joins all threads;
/// how long that takes is how long the source takes to notice.
pub struct Prefetcher<P> {
    frame_count: usize,
    messages: Sender<Message<P>>,
    coordinator: Option<JoinHandle<()>>,
}

impl<P: Send + 'static> Prefetcher<P> {
    /// Starts the threads. `prepare` turns a frame into what the caller needs, on the reader threads; `bytes_of` tells how
    /// much memory the result takes.
    ///
    /// # Errors
    /// [`PrefetchError`] when the memory share is out of range, or the system refuses threads or does not tell about memory.
    pub fn new(
        source: Arc<dyn FrameSource>,
        prepare: impl Fn(SetFrame) -> P + Send + Sync + 'static,
        bytes_of: impl Fn(&P) -> u64 + Send + Sync + 'static,
        options: PrefetchOptions,
    ) -> Result<Self, PrefetchError> {
        Self::with_memory(source, prepare, bytes_of, options, Box::new(SystemMemory::new()?))
    }

    /// Like [`Self::new`], with another source of truth about free memory.
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub fn with_memory(
        source: Arc<dyn FrameSource>,
        prepare: impl Fn(SetFrame) -> P + Send + Sync + 'static,
        bytes_of: impl Fn(&P) -> u64 + Send + Sync + 'static,
        options: PrefetchOptions,
        memory: Box<dyn MemoryProbe>,
    ) -> Result<Self, PrefetchError> {
        let share = options.memory_share;
        if !(share > 0.0 && share <= 1.0) {
            return Err(PrefetchError::MemoryShare { found: share });
        }
        let frame_count = source.frame_count();
        let source_bytes = (0..frame_count).map(|frame| source.estimated_bytes(frame)).collect();
        let reader = Arc::new(Reader {
            source,
            request: options.request,
            prepare: Box::new(prepare),
            bytes_of: Box::new(bytes_of),
        });

        let (messages, inbox) = channel::unbounded();
        let (jobs, jobs_of_readers) = channel::unbounded();
        let readers = (0..options.threads.max(1))
            .map(|number| {
                let (reader, jobs, results) = (reader.clone(), jobs_of_readers.clone(), messages.clone());
                thread::Builder::new()
                    .name(format!("meniscus-read-{number}"))
                    .spawn(move || reader.run(&jobs, &results))
            })
            .collect::<Result<Vec<_>, _>>()?;
        let coordinator = Coordinator::new(source_bytes, readers, jobs, share, memory);
        let coordinator = thread::Builder::new()
            .name("meniscus-prefetch".to_owned())
            .spawn(move || coordinator.run(&inbox))?;
        Ok(Self { frame_count, messages, coordinator: Some(coordinator) })
    }

    /// Sets which frames come next, in place of the last plan. Reads that are no longer wanted are cancelled; what is ready
    /// stays as far as memory allows.
    pub fn set_plan(&self, plan: Plan) {
        self.tell(Message::SetPlan(plan));
    }

    /// Hands out frame `index`, waiting until it is ready; a wait counts as a stall. A frame outside the plan is read
    /// before those of the plan. The plan moves on past the frame, also when it fails.
    ///
    /// # Errors
    /// The source's [`FrameError`], once for each failed read: taking the frame again tries again.
    pub fn take(&self, index: usize) -> Result<P, FrameError> {
        if index >= self.frame_count {
            return Err(FrameError {
                kind: FrameErrorKind::Usage,
                file: None,
                message: format!("frame {index}: the series has {} frames, counted from 0", self.frame_count),
            });
        }
        let (reply, answer) = channel::bounded(1);
        self.tell(Message::Take { frame: index, reply });
        answer.recv().unwrap_or_else(|_| {
            Err(FrameError {
                kind: FrameErrorKind::Io,
                file: None,
                message: format!("frame {index}: prefetching has stopped"),
            })
        })
    }

    /// Gives frame `index` back after use, to be kept for the next time it is shown. It is dropped when memory is short or
    /// there is no such frame.
    pub fn give_back(&self, index: usize, frame: P) {
        if index < self.frame_count {
            self.tell(Message::GiveBack { frame: index, prepared: frame });
        }
    }

    /// The state of each frame, in order.
    pub fn status(&self) -> Vec<FrameState> {
        self.ask(Message::Status)
    }

    /// What was done so far.
    pub fn stats(&self) -> PrefetchStats {
        self.ask(Message::Stats)
    }

    fn ask<T: Default>(&self, question: impl FnOnce(Sender<T>) -> Message<P>) -> T {
        let (reply, answer) = channel::bounded(1);
        self.tell(question(reply));
        answer.recv().unwrap_or_default()
    }
}

impl<P> Prefetcher<P> {
    fn tell(&self, message: Message<P>) {
        // The coordinator ends before this value only by a panic of its own; those who wait for an answer notice.
        let _ = self.messages.send(message);
    }
}

impl<P> Drop for Prefetcher<P> {
    fn drop(&mut self) {
        self.tell(Message::Stop);
        if let Some(coordinator) = self.coordinator.take() {
            // A panic has been reported on its thread.
            let _ = coordinator.join();
        }
    }
}
