//! The policy against imagined disks, memories and viewers; time is a number.

use std::collections::BTreeMap;
use std::time::Duration;

use proptest::prelude::*;

use crate::budget::Budget;
use crate::policy::{Action, FrameState, Outcome, Policy, Rules};
use crate::{MemoryLimit, Plan};

/// Bytes of a source frame; prepared it takes [`PREPARED`] of that.
const FRAME: u64 = 1000;
const PREPARED: u64 = 800;

/// What a frame takes while it is read, at most: the source's and the prepared one, before the latter's size is known.
const WHILE_READ: u64 = 2 * FRAME;

/// Longer than any read of these worlds that ends, of five that share the disk at 80 ms each.
const PATIENCE: Duration = Duration::from_millis(1000);

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
    /// Frames whose reads never end.
    gone: Vec<usize>,
    given_up: Vec<usize>,
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
            policy: Policy::new(
                vec![FRAME; count],
                Rules { readers, patience: PATIENCE, coarse_share: None },
            ),
            count,
            read_ms,
            reads: BTreeMap::new(),
            free_bytes,
            broken: Vec::new(),
            gone: Vec::new(),
            given_up: Vec::new(),
            now_ms: 0,
            started: Vec::new(),
            over_budget: 0,
            wasted_reads: 0,
        }
    }

    fn budget(&self) -> Budget {
        let (ready, held) = (self.policy.ready_bytes(), self.policy.held_bytes());
        // Running reads have allocated nothing yet: the case that promises most.
        Budget::new(MemoryLimit::Share(0.5), (2 * self.free_bytes).saturating_sub(ready), ready, held - ready)
    }

    fn now(&self) -> Duration {
        Duration::from_millis(self.now_ms)
    }

    fn plan(&mut self, plan: Plan) {
        self.policy.set_plan(plan);
        self.decide();
    }

    fn decide(&mut self) {
        let budget = self.budget();
        let ready_before = self.ready();
        let actions = self.policy.decide(budget, self.now());
        for &action in &actions {
            match action {
                Action::Start { frame, .. } => {
                    let read = Read { left_ms: self.read_ms, cancelled: false };
                    assert!(self.reads.insert(frame, read).is_none(), "read twice at once");
                    self.started.push(frame);
                }
                Action::Cancel(frame) => {
                    self.reads.get_mut(&frame).expect("cancels what runs").cancelled = true;
                    self.wasted_reads += 1;
                }
                Action::Drop(frame) => assert!(ready_before.contains(&frame), "drops what is ready"),
                Action::GiveUp(frame) => self.given_up.push(frame),
            }
        }
        let started = actions.iter().any(|action| matches!(action, Action::Start { .. }));
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
            .filter(|(frame, read)| (read.cancelled || read.left_ms <= 1e-9) && !self.gone.contains(frame))
            .map(|(&frame, _)| frame)
            .collect();
        for frame in ended {
            let read = self.reads.remove(&frame).expect("it ended");
            let outcome = match () {
                () if self.broken.contains(&frame) => Outcome::Failed,
                () if read.cancelled => Outcome::Cancelled,
                () => Outcome::Ready { bytes: PREPARED },
            };
            self.policy.finished(frame, outcome, self.now());
            self.decide();
        }
        // Without news the policy is asked every now and then.
        if self.now_ms.is_multiple_of(10) {
            self.decide();
        }
    }

    /// Takes `frame` as a viewer does; returns the milliseconds waited, or `None` when it failed.
    fn take(&mut self, frame: usize) -> Option<u64> {
        let asked = self.now_ms;
        if self.is_failed(frame) {
            self.policy.taken(frame, self.now());
            self.decide();
            return None;
        }
        if !self.ready().contains(&frame) {
            assert!(self.policy.await_frame(frame), "its read was given up and still runs");
            self.decide();
            let given_up = self.given_up.len();
            while !self.ready().contains(&frame) && !self.is_failed(frame) {
                if self.given_up[given_up..].contains(&frame) {
                    break;
                }
                self.tick();
                assert!(self.now_ms - asked < 1_000_000, "waits for ever for frame {frame}");
            }
        }
        let here = self.ready().contains(&frame);
        self.policy.taken(frame, self.now());
        self.decide();
        here.then_some(self.now_ms - asked)
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
    world.draw(20);
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
        world.decide();
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

/// Eleven of twelve frames fit, and what a read takes beside them. The best there is reads one frame in eleven shown; reading what
/// is missing as soon as something needed later can be dropped for it reads every frame every round.
#[test]
fn a_loop_that_almost_fits_is_mostly_read_once() {
    let mut world = World::new(12, 2, 10.0, 11 * FRAME);
    world.plan(play(0, 1, true));
    let mut stalls = 0;
    for shown in 0..240 {
        let frame = shown % 12;
        let wait = world.take(frame).expect("no frame is broken");
        stalls += usize::from(shown >= 12 && wait > 0);
        world.draw(20);
        assert!(world.policy.given_back(frame));
        world.decide();
    }
    assert_eq!((stalls, world.over_budget), (0, 0));
    let again = world.started.len() - 12;
    assert!(again <= 228 / 3, "{again} of 228 frames were read again");
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
    assert!(world.policy.await_frame(2));
    world.broken.clear();
    world.decide();
    world.draw(20);
    assert!(world.ready().contains(&2));
}

#[test]
fn a_broken_frame_is_tried_again_when_its_files_change() {
    let mut world = World::new(6, 2, 5.0, 20 * FRAME);
    world.broken = vec![4];
    world.plan(play(0, 1, true));
    world.draw(100);
    assert!(world.is_failed(4) && world.ready().len() == 5);
    world.broken.clear();
    assert!(world.policy.changed(4, FRAME));
    world.draw(20);
    assert_eq!(world.ready().len(), 6);
}

#[test]
fn frames_of_changed_files_are_read_again_before_they_are_shown() {
    let mut world = World::new(6, 2, 5.0, 20 * FRAME);
    world.plan(play(0, 1, true));
    world.draw(100);
    assert_eq!(world.ready().len(), 6);
    let reads = |world: &World, frame| world.started.iter().filter(|&&started| started == frame).count();
    let before = [3, 4].map(|frame| reads(&world, frame));
    // One that is ready, and one that somebody looks at.
    assert!(world.policy.changed(3, FRAME), "the frame of the old files is given up");
    assert!(!world.ready().contains(&3));
    assert!(world.take(4).is_some());
    assert!(!world.policy.changed(4, FRAME), "it is not here");
    assert!(!world.policy.given_back(4), "of the old files");
    world.decide();
    world.draw(20);
    assert_eq!(world.ready().len(), 6);
    assert_eq!([3, 4].map(|frame| reads(&world, frame)), before.map(|reads| reads + 1));
    assert!(world.take(4).is_some() && world.policy.given_back(4), "of the new files");
}

#[test]
fn a_disk_that_does_not_answer_costs_its_frames_and_no_more() {
    let mut world = World::new(30, 2, 5.0, 20 * FRAME);
    world.gone = vec![3];
    world.plan(play(0, 1, false));
    let waits: Vec<_> = (0..30)
        .map(|frame| {
            let wait = world.take(frame);
            world.draw(20);
            wait
        })
        .collect();
    assert_eq!(waits.iter().position(Option::is_none), Some(3));
    assert_eq!(waits.iter().flatten().filter(|&&wait| wait > 20).count(), 0, "{waits:?}");
    assert_eq!(world.given_up, [3]);
    // Both readers hang: whoever waits is told, and nothing is begun.
    world.gone.extend([10, 11]);
    world.plan(play(10, 1, false));
    assert_eq!((world.take(10), world.take(11)), (None, None));
    // The disk is back: so are the readers and their frames.
    world.gone.clear();
    world.draw(20);
    assert!([3, 10].iter().all(|frame| world.ready().contains(frame)), "{:?}", world.ready());
    assert!(world.take(20).is_some());
}

#[test]
fn frames_that_are_added_join_in() {
    let mut world = World::new(4, 2, 5.0, 20 * FRAME);
    world.plan(play(0, 1, false));
    (0..4).for_each(|frame| assert!(world.take(frame).is_some()));
    world.draw(50);
    assert_eq!(world.started, [0, 1, 2, 3]);
    world.policy.grow(&[FRAME; 3]);
    world.count += 3;
    world.draw(50);
    assert_eq!(world.started, [0, 1, 2, 3, 4, 5, 6]);
}

#[test]
fn a_first_impression_comes_with_the_frame_that_is_looked_at() {
    let rules = Rules { readers: 2, patience: PATIENCE, coarse_share: Some(8) };
    let mut policy = Policy::new(vec![FRAME; 50], rules);
    let budget = Budget { fill: 40 * FRAME, keep: 40 * FRAME };
    let start = |frame, coarse| Action::Start { frame, coarse };
    let now = Duration::ZERO;
    policy.set_plan(play(20, 0, false));
    assert_eq!(policy.decide(budget, now), [start(20, true), start(21, false)]);
    // Both reads are of frames that will be shown, but later: the one needed last makes way.
    policy.set_plan(play(3, 1, false));
    assert_eq!(policy.decide(budget, now), [Action::Cancel(21)]);
    assert_eq!(policy.decide(budget, now), [], "one is enough");
    policy.finished(21, Outcome::Cancelled, now);
    assert_eq!(policy.decide(budget, now), [start(3, true)]);
    policy.finished(3, Outcome::Ready { bytes: PREPARED }, now);
    policy.taken(3, now);
    assert_eq!(policy.decide(budget, now), [start(4, false)], "playback is under way");
}

/// A long series on disks from twice as slow as drawing to four times as fast, with other programs that take and return memory,
/// changes of speed and direction, and jumps: what holds in the small holds here, and the disk has no idle time to speak of.
#[test]
fn thousands_of_frames() {
    for read_ms in [40.0, 18.0, 5.0] {
        let mut world = World::new(2000, 3, read_ms, 30 * FRAME);
        let (mut frame, mut step) = (0, 1);
        let mut stalls = 0;
        world.plan(play(frame, step, true));
        for shown in 0..2000_usize {
            match shown % 500 {
                100 => world.free_bytes = 6 * FRAME,
                200 => world.free_bytes = 30 * FRAME,
                300 => step = [1, -1, 4][shown / 500 % 3],
                400 => frame = shown * 7919 % 2000,
                _ => {}
            }
            if matches!(shown % 500, 300 | 400) {
                world.plan(play(frame, step, true));
            }
            let wait = world.take(frame).expect("no frame is broken");
            stalls += usize::from(wait > 0);
            world.draw(20);
            frame = (frame as isize + step).rem_euclid(2000) as usize;
        }
        assert_eq!(world.over_budget, 0);
        // Four jumps and four changes of direction, each with the frames that the three readers begin with, and the start.
        let unavoidable = 3 * (4 + 4 + 1);
        assert!(read_ms > 20.0 || stalls <= unavoidable, "{stalls} stalls at {read_ms} ms");
        let busy_ms = 2000.0 * read_ms;
        assert!(read_ms < 20.0 || (world.now_ms as f64) < 1.02 * busy_ms, "{} ms", world.now_ms);
    }
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
