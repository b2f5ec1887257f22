//! The policy against imagined disks, memories and viewers; time is a number.

use std::collections::BTreeMap;

use proptest::prelude::*;

use crate::Plan;
use crate::budget::Budget;
use crate::policy::{Action, FrameState, Outcome, Policy};

/// Bytes of a source frame; prepared it takes [`PREPARED`] of that.
const FRAME: u64 = 1000;
const PREPARED: u64 = 800;

/// What a frame takes while it is read, at most: the source's and the prepared one, before the latter's size is known.
const WHILE_READ: u64 = 2 * FRAME;

/// A machine with readers that share one disk, and a memory that others use too.
struct World {
    policy: Policy,
    count: usize,
    /// Milliseconds a read takes on its own; `n` at once take `n` times as long.
    read_ms: f64,
    /// Running reads, with what is left of them.
    reads: BTreeMap<usize, Read>,
    /// Half of what others leave: with a share of one half, this is the budget.
    free_bytes: u64,
    broken: Vec<usize>,
    now_ms: u64,
    started: Vec<usize>,
    /// Largest sum held beyond what the budget allows, bytes.
    over_budget: u64,
    wasted_reads: usize,
}

struct Read {
    left_ms: f64,
    cancelled: bool,
}

impl World {
    fn new(count: usize, readers: usize, read_ms: f64, free_bytes: u64) -> Self {
        Self {
            policy: Policy::new(vec![FRAME; count], readers),
            count,
            read_ms,
            reads: BTreeMap::new(),
            free_bytes,
            broken: Vec::new(),
            now_ms: 0,
            started: Vec::new(),
            over_budget: 0,
            wasted_reads: 0,
        }
    }

    fn budget(&self) -> Budget {
        let (ready, held) = (self.policy.ready_bytes(), self.policy.held_bytes());
        // Running reads have allocated nothing yet: the case that promises most.
        Budget::new(0.5, (2 * self.free_bytes).saturating_sub(ready), ready, held - ready)
    }

    fn plan(&mut self, plan: Plan) {
        self.policy.set_plan(plan);
        self.decide();
    }

    fn decide(&mut self) {
        let budget = self.budget();
        let ready_before = self.ready();
        let actions = self.policy.decide(budget);
        for &action in &actions {
            match action {
                Action::Start(frame) => {
                    let read = Read { left_ms: self.read_ms, cancelled: false };
                    assert!(self.reads.insert(frame, read).is_none(), "read twice at once");
                    self.started.push(frame);
                }
                Action::Cancel(frame) => {
                    self.reads.get_mut(&frame).expect("cancels what runs").cancelled = true;
                    self.wasted_reads += 1;
                }
                Action::Drop(frame) => assert!(ready_before.contains(&frame), "drops what is ready"),
            }
        }
        let started = actions.iter().any(|action| matches!(action, Action::Start(_)));
        let held = self.policy.held_bytes();
        let items = self.ready().len() + self.reads.len();
        if items > 1 {
            // What runs cannot be taken back at once, but nothing may be begun beside it.
            let running_bytes = held - self.policy.ready_bytes();
            let limit = if started { budget.fill } else { budget.keep.max(running_bytes) };
            let most_useful = if self.reads.is_empty() || started { 0 } else { PREPARED };
            self.over_budget = self.over_budget.max(held.saturating_sub(limit + most_useful));
        }
    }

    fn ready(&self) -> Vec<usize> {
        let states = self.policy.states(Budget::default());
        (0..self.count).filter(|&frame| matches!(states[frame], FrameState::Ready { .. })).collect()
    }

    fn is_failed(&self, frame: usize) -> bool {
        self.policy.states(Budget::default())[frame] == FrameState::Failed
    }

    /// One millisecond: the disk works on all reads alike; a cancelled read ends.
    fn tick(&mut self) {
        self.now_ms += 1;
        let each = 1.0 / self.reads.len().max(1) as f64;
        self.reads.values_mut().for_each(|read| read.left_ms -= each);
        let ended: Vec<usize> = self
            .reads
            .iter()
            .filter(|(_, read)| read.cancelled || read.left_ms <= 1e-9)
            .map(|(&frame, _)| frame)
            .collect();
        for frame in ended {
            let read = self.reads.remove(&frame).expect("it ended");
            let outcome = match () {
                () if self.broken.contains(&frame) => Outcome::Failed,
                () if read.cancelled => Outcome::Cancelled,
                () => Outcome::Ready { bytes: PREPARED },
            };
            self.policy.finished(frame, outcome);
            self.decide();
        }
        self.decide();
    }

    /// Takes `frame` as a viewer does; returns the milliseconds waited, or `None` when it failed.
    fn take(&mut self, frame: usize) -> Option<u64> {
        let asked = self.now_ms;
        if self.is_failed(frame) {
            self.policy.taken(frame);
            self.decide();
            return None;
        }
        if !self.ready().contains(&frame) {
            self.policy.await_frame(frame);
            self.decide();
            while !self.ready().contains(&frame) && !self.is_failed(frame) {
                self.tick();
                assert!(self.now_ms - asked < 1_000_000, "waits for ever for frame {frame}");
            }
        }
        let failed = self.is_failed(frame);
        self.policy.taken(frame);
        self.decide();
        (!failed).then_some(self.now_ms - asked)
    }

    fn draw(&mut self, ms: u64) {
        (0..ms).for_each(|_| self.tick());
    }
}

fn play(playhead: usize, step: isize, looping: bool) -> Plan {
    Plan::Play { playhead, step, looping }
}

#[test]
fn a_disk_that_keeps_up_never_stalls_after_the_first_frame() {
    let mut world = World::new(1000, 3, 18.0, 20 * FRAME);
    world.plan(play(0, 1, false));
    let waits: Vec<_> = (0..1000)
        .map(|frame| {
            let wait = world.take(frame);
            world.draw(20);
            wait
        })
        .collect();
    // Three readers share the disk, so the first three frames come after three reads' time.
    assert!(waits[0] <= Some(54) && waits[1..].iter().all(|&wait| wait == Some(0)), "{waits:?}");
    assert_eq!(world.started, Vec::from_iter(0..1000), "each once, in order");
    assert_eq!((world.over_budget, world.wasted_reads), (0, 0));
}

#[test]
fn a_slow_disk_is_never_idle() {
    let mut world = World::new(300, 2, 40.0, 20 * FRAME);
    world.plan(play(0, 1, false));
    for frame in 0..300 {
        assert!(world.take(frame).is_some());
        if frame < 299 {
            world.draw(20);
        }
    }
    // 300 reads of 40 ms one after the other, and a tick of rounding for each.
    assert!(world.now_ms <= 300 * 41, "{} ms", world.now_ms);
}

#[test]
fn memory_that_others_need_is_given_back_and_used_again() {
    let mut world = World::new(100, 2, 5.0, 20 * FRAME);
    world.plan(play(0, 1, true));
    world.draw(500);
    let before = world.ready();
    assert!(before.len() >= 18, "{before:?}");
    world.free_bytes = 5 * FRAME;
    // At first all that is seen is that nothing is left: half of ours goes. Then what the others took is known.
    world.draw(2);
    let after = world.ready();
    // 5000 bytes hold six prepared frames; the six shown next stay.
    assert_eq!(after, [0, 1, 2, 3, 4, 5]);
    world.free_bytes = 20 * FRAME;
    world.draw(500);
    assert_eq!(world.ready(), before);
    assert_eq!(world.over_budget, 0);
}

#[test]
fn a_small_wobble_of_free_memory_causes_no_reads() {
    let mut world = World::new(100, 2, 5.0, 20 * FRAME);
    world.plan(play(0, 1, true));
    world.draw(500);
    let started = world.started.len();
    for round in 0..200 {
        world.free_bytes = 20 * FRAME - (round % 7) * FRAME / 10;
        world.tick();
    }
    assert_eq!(world.started.len(), started);
}

#[test]
fn less_memory_than_a_frame_still_shows_all() {
    let mut world = World::new(20, 3, 5.0, FRAME / 2);
    world.plan(play(0, 1, false));
    for frame in 0..20 {
        assert!(world.take(frame).is_some());
        assert!(world.reads.len() + world.ready().len() <= 1);
    }
    assert_eq!(world.started.len(), 20);
}

#[test]
fn a_seek_cancels_what_is_no_longer_wanted_and_reads_the_target_first() {
    let mut world = World::new(1000, 2, 50.0, 6 * FRAME);
    world.plan(play(0, 1, false));
    world.draw(10);
    world.plan(play(500, -1, false));
    assert_eq!(world.wasted_reads, 2, "both reads of the old place");
    // One tick for the cancelled reads to end, then two reads that share the disk.
    assert!(world.take(500) <= Some(102));
    assert_eq!(world.started[2..4], [500, 499]);
}

#[test]
fn a_frame_out_of_plan_is_read_before_the_plan() {
    let mut world = World::new(100, 1, 50.0, 10 * FRAME);
    world.plan(play(0, 1, false));
    world.draw(5);
    // The only reader is taken from frame 0.
    assert!(world.take(70) <= Some(52));
    assert_eq!(world.started[..2], [0, 70]);
    assert!(world.take(0).is_some());
}

#[test]
fn a_short_loop_is_read_once() {
    let mut world = World::new(10, 2, 30.0, 30 * FRAME);
    world.plan(play(0, 1, true));
    for round in 0..5 {
        for frame in 0..10 {
            let wait = world.take(frame);
            world.draw(30);
            assert!(world.policy.given_back(frame));
            world.decide();
            assert!(round == 0 || wait == Some(0), "round {round}, frame {frame}: {wait:?}");
        }
    }
    assert_eq!(world.started.len(), 10);
}

#[test]
fn a_broken_frame_fails_once_and_is_tried_again_when_taken_again() {
    let mut world = World::new(6, 2, 5.0, 20 * FRAME);
    world.broken = vec![2];
    world.plan(play(0, 1, true));
    let taken: Vec<bool> = (0..6).map(|frame| world.take(frame).is_some()).collect();
    assert_eq!(taken, [true, true, false, true, true, true]);
    world.draw(300);
    assert_eq!(world.started.iter().filter(|&&frame| frame == 2).count(), 1, "not read again and again");
    // The failure was told; told again it is tried again.
    world.policy.await_frame(2);
    world.broken.clear();
    world.decide();
    world.draw(20);
    assert!(world.ready().contains(&2));
}

/// Something a viewer does.
#[derive(Clone, Debug)]
enum Step {
    Plan(Plan),
    /// Takes the frame that is next in the plan, or this one where there is none.
    TakeNext(usize),
    Take(usize),
    GiveBack(usize),
    Draw(u64),
    Memory(u64),
}

const COUNT: usize = 40;

fn step() -> impl Strategy<Value = Step> {
    let frame = 0..COUNT;
    prop_oneof![
        (frame.clone(), -3..4_isize, any::<bool>())
            .prop_map(|(playhead, step, looping)| Step::Plan(play(playhead, step, looping))),
        prop::collection::vec(0..COUNT + 2, 0..8).prop_map(|frames| Step::Plan(Plan::Frames(frames))),
        frame.clone().prop_map(Step::TakeNext),
        frame.clone().prop_map(Step::TakeNext),
        frame.clone().prop_map(Step::Take),
        frame.prop_map(Step::GiveBack),
        (0..60_u64).prop_map(Step::Draw),
        (0..30 * FRAME).prop_map(Step::Memory),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn whatever_happens(
        steps in prop::collection::vec(step(), 1..60),
        readers in 1..5_usize,
        read_ms in 1..80_u32,
        broken in prop::collection::vec(0..COUNT, 0..4),
    ) {
        let mut world = World::new(COUNT, readers, f64::from(read_ms), 10 * FRAME);
        world.broken = broken.clone();
        let mut plan = Plan::IDLE;
        for step in steps {
            let start = world.started.len();
            // These are not begun anew before they have ended.
            let ending: Vec<_> =
                world.reads.iter().filter(|(_, read)| read.cancelled).map(|(&frame, _)| frame).collect();
            match step {
                Step::Plan(new) => {
                    plan = new.clone();
                    world.plan(new);
                }
                Step::TakeNext(otherwise) => {
                    let frame = plan.upcoming(COUNT).first().copied().unwrap_or(otherwise);
                    // No starvation: `take` gives up after a long time.
                    prop_assert_eq!(world.take(frame).is_none(), broken.contains(&frame));
                    plan.advance_past(frame, COUNT);
                }
                Step::Take(frame) => {
                    prop_assert_eq!(world.take(frame).is_none(), broken.contains(&frame));
                    plan.advance_past(frame, COUNT);
                }
                Step::GiveBack(frame) => {
                    world.policy.given_back(frame);
                    world.decide();
                }
                Step::Draw(ms) => {
                    world.draw(ms);
                    // Nearest deadline first: no read begins while an earlier frame waits for one.
                    let order = plan.upcoming(COUNT);
                    for frame in &world.started[start..] {
                        prop_assert!(order.contains(frame), "frame {} is not wanted", frame);
                    }
                    let places: Vec<_> = world.started[start..]
                        .iter()
                        .filter(|frame| !ending.contains(frame))
                        .map(|frame| order.iter().position(|other| other == frame))
                        .collect();
                    prop_assert!(places.is_sorted(), "{:?} out of order", places);
                }
                Step::Memory(free) => {
                    world.free_bytes = free;
                    world.decide();
                }
            }
            prop_assert!(world.reads.len() <= readers);
            prop_assert_eq!(world.over_budget, 0);
        }
        // In the end all reads end, and what the plan wants within memory is here.
        world.free_bytes = COUNT as u64 * WHILE_READ * 2;
        world.draw(COUNT as u64 * u64::from(read_ms) * 2 + 100);
        let here = world.ready();
        let mut missing = plan.upcoming(COUNT);
        missing.retain(|frame| !here.contains(frame) && !world.is_failed(*frame));
        // Only the one in the viewer's hands.
        prop_assert!(missing.len() <= 1, "{:?}", missing);
    }
}
