use std::collections::HashMap;
use std::ops::ControlFlow;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crossbeam::channel::{Receiver, RecvTimeoutError, Sender};
use meniscus_core::{Cancel, FrameError, FrameErrorKind};

use crate::budget::Budget;
use crate::meter::Meter;
use crate::policy::{Action, Outcome, Policy};
use crate::reader::{Finished, Job};
use crate::{FrameState, MemoryProbe, Plan, PrefetchStats};

/// How old the known amount of free memory may be. Asking costs a few system calls; other programs rarely take gigabytes in
/// less.
const MEMORY_INTERVAL: Duration = Duration::from_millis(100);

/// What the coordinator is told.
pub(crate) enum Message<P> {
    SetPlan(Plan),
    Take { frame: usize, reply: Sender<Result<P, FrameError>> },
    GiveBack { frame: usize, prepared: P },
    Status(Sender<Vec<FrameState>>),
    Stats(Sender<PrefetchStats>),
    Finished(Finished<P>),
    Stop,
}

impl<P> From<Finished<P>> for Message<P> {
    fn from(finished: Finished<P>) -> Self {
        Self::Finished(finished)
    }
}

/// Somebody who waits for a frame.
struct Waiting<P> {
    frame: usize,
    since: Instant,
    reply: Sender<Result<P, FrameError>>,
}

/// Owns the frames and carries out what the policy decides.
pub(crate) struct Coordinator<P> {
    policy: Policy,
    meter: Meter,
    started: Instant,
    share: f64,
    memory: Box<dyn MemoryProbe>,
    /// When memory was last asked for, and the budget from it.
    budget: Option<(Instant, Budget)>,
    readers: Vec<JoinHandle<()>>,
    jobs: Sender<Job>,
    frames: HashMap<usize, P>,
    /// Of failed frames, until told.
    errors: HashMap<usize, FrameError>,
    running: HashMap<usize, Cancel>,
    waiting: Vec<Waiting<P>>,
}

impl<P> Coordinator<P> {
    pub(crate) fn new(
        source_bytes: Vec<u64>,
        readers: Vec<JoinHandle<()>>,
        jobs: Sender<Job>,
        share: f64,
        memory: Box<dyn MemoryProbe>,
    ) -> Self {
        Self {
            policy: Policy::new(source_bytes, readers.len()),
            meter: Meter::default(),
            started: Instant::now(),
            share,
            memory,
            budget: None,
            readers,
            jobs,
            frames: HashMap::new(),
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
            for action in self.policy.decide(budget) {
                self.carry_out(action);
            }
        }
        self.running.values().for_each(Cancel::cancel);
        drop(self.jobs);
        for reader in self.readers {
            // Readers catch panics; one that dies all the same has reported it.
            let _ = reader.join();
        }
    }

    fn receive(&mut self, message: Message<P>) -> ControlFlow<()> {
        match message {
            Message::SetPlan(plan) => self.policy.set_plan(plan),
            Message::Take { frame, reply } => self.take(frame, reply),
            Message::GiveBack { frame, prepared } => self.give_back(frame, prepared),
            Message::Finished(finished) => self.finish(finished),
            // Whoever asked may have gone; then nobody minds.
            Message::Status(reply) => {
                let budget = self.budget();
                let _ = reply.send(self.policy.states(budget));
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
        let result = match (self.frames.remove(&frame), self.errors.remove(&frame)) {
            (Some(prepared), _) => Ok(prepared),
            (None, Some(error)) => Err(error),
            (None, None) => {
                self.policy.await_frame(frame);
                return self.waiting.push(Waiting { frame, since: Instant::now(), reply });
            }
        };
        self.policy.taken(frame);
        let _ = reply.send(result);
    }

    fn finish(&mut self, Finished { frame, result }: Finished<P>) {
        self.meter.read_ended(self.started.elapsed());
        let stopped = self.running.remove(&frame).is_some_and(|cancel| cancel.is_cancelled());
        let outcome = match &result {
            Ok((_, bytes)) => Outcome::Ready { bytes: *bytes },
            Err(error) if stopped && error.kind == FrameErrorKind::Cancelled => Outcome::Cancelled,
            Err(_) => Outcome::Failed,
        };
        self.policy.finished(frame, outcome);
        self.meter.finished(outcome);
        if outcome == Outcome::Cancelled {
            return;
        }
        let result = result.map(|(prepared, _)| prepared);
        if let Some(place) = self.waiting.iter().position(|waiting| waiting.frame == frame) {
            let waiting = self.waiting.remove(place);
            self.meter.stalled(waiting.since.elapsed());
            self.policy.taken(frame);
            let _ = waiting.reply.send(result);
            return;
        }
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
            Action::Start(frame) => {
                let cancel = Cancel::default();
                self.running.insert(frame, cancel.clone());
                self.meter.read_started(self.started.elapsed());
                // Readers live as long as this does.
                let _ = self.jobs.send(Job { frame, cancel });
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
        }
    }

    /// The budget by the free memory, asked again when the last answer is old.
    fn budget(&mut self) -> Budget {
        match self.budget {
            Some((asked, budget)) if asked.elapsed() < MEMORY_INTERVAL => budget,
            _ => {
                let available = self.memory.available_bytes();
                let (ready, held) = (self.policy.ready_bytes(), self.policy.held_bytes());
                let budget = Budget::new(self.share, available, ready, held - ready);
                self.budget = Some((Instant::now(), budget));
                budget
            }
        }
    }
}
