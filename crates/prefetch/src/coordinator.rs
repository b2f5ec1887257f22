use std::collections::HashMap;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crossbeam::channel::{Receiver, RecvTimeoutError, Sender};
use meniscus_core::{Cancel, FrameError, FrameErrorKind};

use crate::budget::Budget;
use crate::meter::Meter;
use crate::policy::{Action, Outcome, Policy, Rules};
use crate::reader::{Finished, Job};
use crate::watch::Seen;
use crate::{FrameRecord, FrameState, MemoryLimit, MemoryProbe, Plan, PrefetchStats};

/// How old the known amount of free memory may be. Asking costs a few system calls; other programs rarely take gigabytes in
/// less.
const MEMORY_INTERVAL: Duration = Duration::from_millis(100);

/// How long the end waits for readers to notice that they are cancelled, which they do between blocks. One that waits for a
/// disk which does not answer is left behind.
const FAREWELL: Duration = Duration::from_secs(5);

/// What the coordinator is told.
pub(crate) enum Message<P> {
    SetPlan(Plan),
    Take {
        frame: usize,
        reply: Sender<Result<P, FrameError>>,
    },
    TakeReady {
        frame: usize,
        reply: Sender<Option<Result<P, FrameError>>>,
    },
    Peek {
        frame: usize,
        clone: fn(&P) -> P,
        reply: Sender<Option<P>>,
    },
    TakeCoarse {
        frame: usize,
        reply: Sender<Option<P>>,
    },
    GiveBack {
        frame: usize,
        prepared: P,
    },
    Status(Sender<Vec<FrameState>>),
    Records(Sender<Vec<FrameRecord>>),
    Stats(Sender<PrefetchStats>),
    Coarse {
        frame: usize,
        prepared: P,
    },
    Finished(Finished<P>),
    /// The files of a frame have changed since it was read.
    Changed {
        frame: usize,
        source_bytes: u64,
    },
    /// Frames of so many bytes each were added at the end.
    Grown(Vec<u64>),
    Stop,
}

/// Somebody who waits for a frame.
struct Waiting<P> {
    frame: usize,
    since: Instant,
    reply: Sender<Result<P, FrameError>>,
}

/// The threads that the coordinator tells what to do.
pub(crate) struct Threads {
    pub readers: Vec<JoinHandle<()>>,
    pub jobs: Sender<Job>,
    pub watch: JoinHandle<()>,
    pub reads: Sender<Seen>,
}

/// Owns the frames and carries out what the policy decides.
pub(crate) struct Coordinator<P> {
    policy: Policy,
    meter: Meter,
    started: Instant,
    rules: Rules,
    limit: MemoryLimit,
    memory: Box<dyn MemoryProbe>,
    /// When memory was last asked for, and the budget from it.
    budget: Option<(Instant, Budget)>,
    threads: Threads,
    /// Number of frames, for those who ask for one.
    frame_count: Arc<AtomicUsize>,
    frames: HashMap<usize, P>,
    records: Vec<FrameRecord>,
    /// A first impression of a frame that is being read.
    coarse: Option<(usize, P)>,
    /// Of failed frames, until told.
    errors: HashMap<usize, FrameError>,
    running: HashMap<usize, Cancel>,
    waiting: Vec<Waiting<P>>,
}

impl<P> Coordinator<P> {
    pub(crate) fn new(
        source_bytes: Vec<u64>,
        threads: Threads,
        rules: Rules,
        limit: MemoryLimit,
        memory: Box<dyn MemoryProbe>,
        frame_count: Arc<AtomicUsize>,
    ) -> Self {
        Self {
            records: vec![FrameRecord::default(); source_bytes.len()],
            policy: Policy::new(source_bytes, rules),
            meter: Meter::default(),
            started: Instant::now(),
            rules,
            limit,
            memory,
            budget: None,
            threads,
            frame_count,
            frames: HashMap::new(),
            coarse: None,
            errors: HashMap::new(),
            running: HashMap::new(),
            waiting: Vec::new(),
        }
    }

    /// Serves messages until told to stop, then ends the readers.
    pub(crate) fn run(mut self, inbox: &Receiver<Message<P>>) {
        loop {
            let flow = match inbox.recv_timeout(MEMORY_INTERVAL) {
                Ok(message) => self.receive(message),
                Err(RecvTimeoutError::Timeout) => ControlFlow::Continue(()),
                Err(RecvTimeoutError::Disconnected) => ControlFlow::Break(()),
            };
            if flow.is_break() {
                break;
            }
            let budget = self.budget();
            for action in self.policy.decide(budget, self.started.elapsed()) {
                self.carry_out(action);
            }
            self.meter.settled(&self.policy, budget.keep);
        }
        self.running.values().for_each(Cancel::cancel);
        let Threads { readers, jobs, watch, reads } = self.threads;
        drop((jobs, reads));
        let begin = Instant::now();
        for thread in readers.into_iter().chain([watch]) {
            while !thread.is_finished() && begin.elapsed() < FAREWELL {
                thread::sleep(Duration::from_millis(1));
            }
            if thread.is_finished() {
                // Readers catch panics; one that dies all the same has reported it.
                let _ = thread.join();
            }
        }
    }

    fn receive(&mut self, message: Message<P>) -> ControlFlow<()> {
        // Whoever asked may have gone when the answer is sent; then nobody minds.
        match message {
            Message::SetPlan(plan) => self.policy.set_plan(plan),
            Message::Take { frame, reply } => self.take(frame, reply),
            Message::TakeReady { frame, reply } => {
                let _ = reply.send(self.take_ready(frame));
            }
            Message::Peek { frame, clone, reply } => {
                let _ = reply.send(self.frames.get(&frame).map(clone));
            }
            Message::TakeCoarse { frame, reply } => {
                let _ = reply.send(self.coarse.take_if(|(of, _)| *of == frame).map(|(_, coarse)| coarse));
            }
            Message::GiveBack { frame, prepared } => self.give_back(frame, prepared),
            Message::Coarse { frame, prepared } => self.coarse = Some((frame, prepared)),
            Message::Finished(finished) => self.finish(finished),
            Message::Changed { frame, source_bytes } => {
                if self.policy.changed(frame, source_bytes) {
                    self.frames.remove(&frame);
                    self.errors.remove(&frame);
                    self.meter.frame_changed();
                }
            }
            Message::Grown(source_bytes) => {
                self.policy.grow(&source_bytes);
                let count = self.records.len() + source_bytes.len();
                self.records.resize(count, FrameRecord::default());
                self.frame_count.store(count, Ordering::Release);
            }
            Message::Status(reply) => {
                let budget = self.budget();
                let _ = reply.send(self.policy.states(budget));
            }
            Message::Records(reply) => {
                let budget = self.budget();
                let states = self.policy.states(budget);
                let records = std::iter::zip(&self.records, states);
                let _ = reply
                    .send(records.map(|(record, state)| FrameRecord { state, ..record.clone() }).collect());
            }
            Message::Stats(reply) => {
                let budget = self.budget();
                let _ = reply.send(self.meter.stats(self.started.elapsed(), &self.policy, budget.keep));
            }
            Message::Stop => return ControlFlow::Break(()),
        }
        ControlFlow::Continue(())
    }

    fn take(&mut self, frame: usize, reply: Sender<Result<P, FrameError>>) {
        let result = match self.take_ready(frame) {
            Some(result) => result,
            None if self.policy.await_frame(frame) => {
                return self.waiting.push(Waiting { frame, since: Instant::now(), reply });
            }
            None => {
                self.policy.taken(frame, self.started.elapsed());
                Err(self.no_answer(frame))
            }
        };
        let _ = reply.send(result);
    }

    /// `frame`, or why there is none, if either is known.
    fn take_ready(&mut self, frame: usize) -> Option<Result<P, FrameError>> {
        let result = match self.frames.remove(&frame) {
            Some(prepared) => Ok(prepared),
            None => Err(self.errors.remove(&frame)?),
        };
        self.policy.taken(frame, self.started.elapsed());
        Some(result)
    }

    fn finish(&mut self, Finished { frame, result, took, version }: Finished<P>) {
        let now = self.started.elapsed();
        self.meter.read_ended(now);
        let stopped = self.running.remove(&frame).is_some_and(|cancel| cancel.is_cancelled());
        let outcome = match &result {
            Ok(delivered) => Outcome::Ready { bytes: delivered.bytes },
            Err(error) if stopped && error.kind == FrameErrorKind::Cancelled => Outcome::Cancelled,
            Err(_) => Outcome::Failed,
        };
        self.policy.finished(frame, outcome, now);
        let file_bytes = result.as_ref().ok().and_then(|delivered| delivered.file_bytes);
        self.meter.finished(outcome, file_bytes);
        if self.coarse.as_ref().is_some_and(|(of, _)| *of == frame) {
            self.coarse = None;
        }
        if outcome == Outcome::Cancelled {
            self.errors.remove(&frame);
            return;
        }
        let record = &mut self.records[frame];
        record.error = result.as_ref().err().cloned();
        if result.is_ok() {
            (record.reads, record.read_time, record.file_bytes) = (record.reads + 1, Some(took), file_bytes);
        }
        // The watch lives as long as this does.
        let _ = self.threads.reads.send(Seen { frame, version, failed: result.is_err() });
        self.hand_out(frame, result.map(|delivered| delivered.prepared));
    }

    /// Gives `frame` to whoever waits for it, else keeps it.
    fn hand_out(&mut self, frame: usize, result: Result<P, FrameError>) {
        if let Some(place) = self.waiting.iter().position(|waiting| waiting.frame == frame) {
            let waiting = self.waiting.remove(place);
            let time = waiting.since.elapsed();
            self.meter.stalled(time);
            self.records[frame].stalls += 1;
            self.records[frame].stalled += time;
            self.policy.taken(frame, self.started.elapsed());
            let _ = waiting.reply.send(result);
            return;
        }
        self.errors.remove(&frame);
        match result {
            Ok(prepared) => drop(self.frames.insert(frame, prepared)),
            Err(error) => drop(self.errors.insert(frame, error)),
        }
    }

    fn give_back(&mut self, frame: usize, prepared: P) {
        if self.policy.given_back(frame) {
            self.errors.remove(&frame);
            self.frames.insert(frame, prepared);
        }
    }

    fn carry_out(&mut self, action: Action) {
        match action {
            Action::Start { frame, coarse } => {
                let cancel = Cancel::default();
                self.running.insert(frame, cancel.clone());
                self.meter.read_started(self.started.elapsed());
                let coarse_share = self.rules.coarse_share.filter(|_| coarse);
                // Readers live as long as this does.
                let _ = self.threads.jobs.send(Job { frame, cancel, coarse_share });
            }
            Action::Cancel(frame) => {
                if let Some(cancel) = self.running.get(&frame) {
                    cancel.cancel();
                }
            }
            Action::Drop(frame) => {
                self.frames.remove(&frame);
                self.meter.frame_dropped();
            }
            Action::GiveUp(frame) => {
                let error = self.no_answer(frame);
                self.records[frame].error = Some(error.clone());
                self.meter.read_given_up();
                self.hand_out(frame, Err(error));
            }
        }
    }

    fn no_answer(&self, frame: usize) -> FrameError {
        let message = format!(
            "frame {frame} has not come for more than {:.0} s: the disk or the network that it is on does not answer; it is \
             taken when it comes after all",
            self.rules.patience.as_secs_f64()
        );
        FrameError { kind: FrameErrorKind::Io, file: None, message }
    }

    /// The budget by the free memory, asked again when the last answer is old.
    fn budget(&mut self) -> Budget {
        match self.budget {
            Some((asked, budget)) if asked.elapsed() < MEMORY_INTERVAL => budget,
            _ => {
                let available = self.memory.available_bytes();
                let (ready, held) = (self.policy.ready_bytes(), self.policy.held_bytes());
                let budget = Budget::new(self.limit, available, ready, held - ready);
                self.budget = Some((Instant::now(), budget));
                budget
            }
        }
    }
}
