use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crossbeam::channel::{self, Sender};
use meniscus_core::{FrameError, FrameErrorKind, FrameRequest, FrameSource, SetFrame};

use crate::coordinator::{Coordinator, Message, Threads};
use crate::policy::Rules;
use crate::reader::Reader;
use crate::{
    FrameRecord, FrameState, MemoryLimit, MemoryProbe, Plan, PrefetchError, PrefetchStats, SystemMemory,
    watch,
};

/// How frames are prefetched.
#[derive(Clone, Debug, PartialEq)]
pub struct PrefetchOptions {
    /// Frames read at once, at least 1 (0 counts as 1).
    pub threads: usize,
    /// What prefetched frames may take. Frames that were taken are the caller's and do not count.
    pub memory: MemoryLimit,
    /// What of each frame is read.
    pub request: FrameRequest,
    /// How long a read may take before its frame counts as failed and playback goes on without it; longer where reads have
    /// taken long before. The read goes on, and its frame is there when it ends.
    pub patience: Duration,
    /// The part (one in so many particles) of the frame that a plan begins with which is read before the whole, to be seen at
    /// once ([`Prefetcher::take_coarse`]); `None` for none.
    pub coarse_share: Option<u32>,
}

impl Default for PrefetchOptions {
    /// Two readers, half of the free memory, positions only, a minute of patience, whole frames.
    fn default() -> Self {
        Self {
            threads: 2,
            memory: MemoryLimit::Share(0.5),
            request: FrameRequest::default(),
            patience: Duration::from_secs(60),
            coarse_share: None,
        }
    }
}

/// Reads frames ahead on threads of its own and hands them out prepared, as `P`.
///
/// Nothing is read before a plan is set or a frame is taken. Dropping it cancels what is being read and joins all threads;
/// how long that takes is how long the source takes to notice.
pub struct Prefetcher<P> {
    frame_count: Arc<AtomicUsize>,
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
        options.memory.validate()?;
        let count = source.frame_count();
        let source_bytes = (0..count).map(|frame| source.estimated_bytes(frame)).collect();
        let readers = options.threads.max(1);
        let rules = Rules { readers, patience: options.patience, coarse_share: options.coarse_share };
        let reader = Arc::new(Reader {
            source: Arc::clone(&source),
            request: options.request,
            prepare: Box::new(prepare),
            bytes_of: Box::new(bytes_of),
        });

        let (messages, inbox) = channel::unbounded();
        let (jobs, jobs_of_readers) = channel::unbounded();
        let (reads, reads_seen) = channel::unbounded();
        let named = |name: String| thread::Builder::new().name(name);
        let readers = (0..readers)
            .map(|number| {
                let (reader, jobs, results) = (reader.clone(), jobs_of_readers.clone(), messages.clone());
                named(format!("meniscus-read-{number}")).spawn(move || reader.run(&jobs, &results))
            })
            .collect::<Result<Vec<_>, _>>()?;
        let news = messages.clone();
        let watch = named("meniscus-watch".to_owned())
            .spawn(move || watch::run(&source, count, &reads_seen, &news))?;
        let frame_count = Arc::new(AtomicUsize::new(count));
        let threads = Threads { readers, jobs, watch, reads };
        let coordinator =
            Coordinator::new(source_bytes, threads, rules, options.memory, memory, Arc::clone(&frame_count));
        let coordinator = named("meniscus-prefetch".to_owned()).spawn(move || coordinator.run(&inbox))?;
        Ok(Self { frame_count, messages, coordinator: Some(coordinator) })
    }

    /// Number of frames, those included that were added to the series since the start.
    pub fn frame_count(&self) -> usize {
        self.frame_count.load(Ordering::Acquire)
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
        self.check(index)?;
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

    /// [`Self::take`] without waiting: `None` where nothing is known of the frame yet. For those who have something else to
    /// show meanwhile.
    pub fn take_ready(&self, index: usize) -> Option<Result<P, FrameError>> {
        if let Err(error) = self.check(index) {
            return Some(Err(error));
        }
        self.ask(|reply| Message::TakeReady { frame: index, reply })
    }

    /// Frame `index` where it is ready, without taking it: for what can be done with it before it is shown.
    pub fn peek(&self, index: usize) -> Option<P>
    where
        P: Clone,
    {
        self.ask(|reply| Message::Peek { frame: index, clone: P::clone, reply })
    }

    /// Hands out the first impression of frame `index`, once, where it is there and the whole is not. Only the frame that a
    /// plan begins with has one, and only with [`PrefetchOptions::coarse_share`].
    pub fn take_coarse(&self, index: usize) -> Option<P> {
        self.ask(|reply| Message::TakeCoarse { frame: index, reply })
    }

    /// Gives frame `index` back after use, to be kept for the next time it is shown. It is dropped when memory is short or
    /// there is no such frame.
    pub fn give_back(&self, index: usize, frame: P) {
        if index < self.frame_count() {
            self.tell(Message::GiveBack { frame: index, prepared: frame });
        }
    }

    /// The state of each frame, in order.
    pub fn status(&self) -> Vec<FrameState> {
        self.ask(Message::Status)
    }

    /// What is known of each frame and what happened to it, in order.
    pub fn records(&self) -> Vec<FrameRecord> {
        self.ask(Message::Records)
    }

    /// What was done so far.
    pub fn stats(&self) -> PrefetchStats {
        self.ask(Message::Stats)
    }

    fn check(&self, index: usize) -> Result<(), FrameError> {
        let count = self.frame_count();
        if index < count {
            return Ok(());
        }
        let message = format!("frame {index}: the series has {count} frames, counted from 0");
        Err(FrameError { kind: FrameErrorKind::Usage, file: None, message })
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
