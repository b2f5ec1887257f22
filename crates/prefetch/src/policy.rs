use std::collections::BTreeMap;
use std::time::Duration;

use crate::Plan;
use crate::budget::Budget;

/// What is known of one frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameState {
    /// Not here and not wanted.
    Absent,
    /// Wanted within the memory there is, and not yet begun.
    Requested,
    /// Being read or prepared.
    Reading,
    /// Here.
    Ready {
        /// Size in memory.
        bytes: u64,
    },
    /// Could not be read. Read again when its files have changed, or when it is taken again.
    Failed,
    /// Taken last, and not given back.
    Taken,
}

impl FrameState {
    /// Name as used in JSON.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Absent => "absent",
            Self::Requested => "requested",
            Self::Reading => "reading",
            Self::Ready { .. } => "ready",
            Self::Failed => "failed",
            Self::Taken => "taken",
        }
    }
}

/// What is to be done, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    /// Let go of the ready frame.
    Drop(usize),
    /// Ask the running read to stop. Its end is still reported.
    Cancel(usize),
    /// Let an idle reader read the frame; `coarse`: a first impression of it before the whole.
    Start { frame: usize, coarse: bool },
    /// Report the frame as failed: its read does not end, or there is no reader that would begin one.
    GiveUp(usize),
}

/// How a read ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    Ready { bytes: u64 },
    Cancelled,
    Failed,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Slot {
    Absent,
    Reading { bytes: u64, since: Duration, cancelled: bool },
    Ready { bytes: u64 },
    Failed,
}

/// What does not change while frames are read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rules {
    /// Parallel reads.
    pub readers: usize,
    /// A read may take this long, or [`SLOWER`] times as long as the longest so far, before it is given up.
    pub patience: Duration,
    /// The part of a frame that a first impression of it takes; `None` where none are wanted.
    pub coarse_share: Option<u32>,
}

/// How much longer than all before it a read may take: disks stutter, and frames differ in size.
const SLOWER: u32 = 8;

/// Decides what is read, stopped and kept. Told what happens; asked by [`Policy::decide`] what to do.
///
/// * Frames are read in the order in which they will be shown; a frame that somebody waits for comes before all.
/// * Wanted is the longest run of coming frames that fits into the budget, and always the first one. A running read of any
///   other frame is stopped.
/// * A frame is begun when it fits beside what is held, dropping what is needed later - or when nothing else is held, so
///   that a budget below one frame still shows frames.
/// * Frames that are not needed stay as long as there is room.
/// * A frame that will be shown again and has its place in memory makes way only for one that is due soon, by the measured times
///   of reading and showing. A loop that is a little too long for memory would else be read anew every round.
/// * While it is read, a frame counts twice: as the source delivers it and as it is prepared from that.
/// * A read that does not end (a disk that is gone) costs its frame and its reader, nothing else. Should it end after all, both
///   are back.
/// * The frame that the plan was set for is the one that somebody looks at: a first impression of it comes before the whole.
///
/// Time is whatever clock the caller has, from any start.
#[derive(Debug)]
pub(crate) struct Policy {
    plan: Plan,
    slots: Vec<Slot>,
    /// Of the source's frame, as the source says.
    source_bytes: Vec<u64>,
    /// Of the prepared frame, where it has been seen.
    prepared_bytes: Vec<Option<u64>>,
    /// Prepared bytes per source byte, smoothed over the frames seen.
    bytes_ratio: f64,
    rules: Rules,
    /// Frames that are waited for, in the order asked.
    awaited: Vec<usize>,
    taken: Option<usize>,
    /// Reads that were given up and have not ended, with the memory they may hold.
    lost: BTreeMap<usize, u64>,
    longest_read: Duration,
    /// Time of a read and time from one frame taken to the next, smoothed.
    pace: Pace,
    /// Whether nothing was taken since the plan was set.
    aimed: bool,
}

impl Policy {
    /// For frames of `source_bytes` each.
    pub(crate) fn new(source_bytes: Vec<u64>, rules: Rules) -> Self {
        let count = source_bytes.len();
        Self {
            plan: Plan::IDLE,
            slots: vec![Slot::Absent; count],
            source_bytes,
            prepared_bytes: vec![None; count],
            bytes_ratio: 1.0,
            rules,
            awaited: Vec::new(),
            taken: None,
            lost: BTreeMap::new(),
            longest_read: Duration::ZERO,
            pace: Pace::default(),
            aimed: false,
        }
    }

    pub(crate) fn set_plan(&mut self, plan: Plan) {
        self.plan = plan;
        self.aimed = true;
    }

    /// Frames of `source_bytes` each were added at the end of the series.
    pub(crate) fn grow(&mut self, source_bytes: &[u64]) {
        self.source_bytes.extend_from_slice(source_bytes);
        self.slots.resize(self.source_bytes.len(), Slot::Absent);
        self.prepared_bytes.resize(self.source_bytes.len(), None);
    }

    /// Somebody waits for `frame`. One that failed is tried again; `false` where it cannot be, because the read that was given
    /// up still runs.
    pub(crate) fn await_frame(&mut self, frame: usize) -> bool {
        if self.lost.contains_key(&frame) {
            return false;
        }
        if self.slots[frame] == Slot::Failed {
            self.slots[frame] = Slot::Absent;
        }
        self.awaited.push(frame);
        true
    }

    /// The files of `frame` have changed since it was read, and it now takes `source_bytes`. Returns whether what is known of
    /// it, the frame or why it failed, counts no more; it is then read again where it is wanted. One that is being read is of
    /// the old files or of the new ones: who asks will know, and tell again.
    pub(crate) fn changed(&mut self, frame: usize, source_bytes: u64) -> bool {
        self.source_bytes[frame] = source_bytes;
        match self.slots[frame] {
            Slot::Failed if self.lost.contains_key(&frame) => return false,
            Slot::Reading { .. } => return false,
            Slot::Ready { .. } | Slot::Failed | Slot::Absent => {}
        }
        // In somebody's hands, it is not taken back: `given_back`.
        self.prepared_bytes[frame] = None;
        std::mem::replace(&mut self.slots[frame], Slot::Absent) != Slot::Absent
    }

    /// `frame` was handed out at `now`, as a frame or as its error: it is no longer here, and the plan moves on.
    pub(crate) fn taken(&mut self, frame: usize, now: Duration) {
        self.pace.shown(now);
        if let Some(place) = self.awaited.iter().position(|&awaited| awaited == frame) {
            self.awaited.remove(place);
        }
        if let Slot::Ready { .. } = self.slots[frame] {
            self.slots[frame] = Slot::Absent;
            self.taken = Some(frame);
        }
        self.aimed = false;
        self.plan.advance_past(frame, self.slots.len());
    }

    /// `frame` was given back. Returns whether it is kept: not where it is here again or being read already, not where its files
    /// have changed meanwhile, and not where it was never handed out.
    pub(crate) fn given_back(&mut self, frame: usize) -> bool {
        if self.taken == Some(frame) {
            self.taken = None;
        }
        match (self.slots[frame], self.prepared_bytes[frame]) {
            (Slot::Absent | Slot::Failed, Some(bytes)) => {
                self.slots[frame] = Slot::Ready { bytes };
                true
            }
            _ => false,
        }
    }

    /// The read of `frame` ended, at `now`.
    pub(crate) fn finished(&mut self, frame: usize, outcome: Outcome, now: Duration) {
        if let Slot::Reading { since, .. } = self.slots[frame] {
            self.longest_read = self.longest_read.max(now.saturating_sub(since));
            if let Outcome::Ready { .. } = outcome {
                self.pace.read(now.saturating_sub(since));
            }
        }
        self.lost.remove(&frame);
        self.slots[frame] = match outcome {
            Outcome::Ready { bytes } => {
                self.learn(frame, bytes);
                Slot::Ready { bytes }
            }
            Outcome::Cancelled => Slot::Absent,
            Outcome::Failed => Slot::Failed,
        };
    }

    fn learn(&mut self, frame: usize, bytes: u64) {
        self.prepared_bytes[frame] = Some(bytes);
        let ratio = bytes as f64 / self.source_bytes[frame].max(1) as f64;
        // Follows a change within a few frames, and no single odd frame.
        self.bytes_ratio += (ratio - self.bytes_ratio) * 0.3;
    }

    /// Bytes of the prepared frame: as seen, or as others of its kind.
    fn expected_bytes(&self, frame: usize) -> u64 {
        match self.slots[frame] {
            Slot::Ready { bytes } => bytes,
            _ => self.prepared_bytes[frame]
                .unwrap_or((self.source_bytes[frame] as f64 * self.bytes_ratio) as u64),
        }
    }

    /// Bytes of everything held: ready frames and running reads.
    pub(crate) fn held_bytes(&self) -> u64 {
        self.slots.iter().map(|slot| slot.bytes()).chain(self.lost.values().copied()).sum()
    }

    /// Bytes of the ready frames.
    pub(crate) fn ready_bytes(&self) -> u64 {
        self.ready().map(|frame| self.slots[frame].bytes()).sum()
    }

    /// Number of ready frames.
    pub(crate) fn ready_count(&self) -> usize {
        self.ready().count()
    }

    /// What each frame is, for people.
    pub(crate) fn states(&self, budget: Budget) -> Vec<FrameState> {
        let wanted = self.wanted(budget);
        let states = self.slots.iter().enumerate().map(|(frame, slot)| match *slot {
            Slot::Absent if wanted.rank[frame] < wanted.begin => FrameState::Requested,
            Slot::Absent if self.taken == Some(frame) => FrameState::Taken,
            Slot::Absent | Slot::Reading { cancelled: true, .. } => FrameState::Absent,
            Slot::Reading { .. } => FrameState::Reading,
            Slot::Ready { bytes } => FrameState::Ready { bytes },
            Slot::Failed => FrameState::Failed,
        });
        states.collect()
    }

    /// What to do within `budget` at `now`. The actions count as done.
    pub(crate) fn decide(&mut self, budget: Budget, now: Duration) -> Vec<Action> {
        let mut actions = Vec::new();
        self.give_up(now, &mut actions);
        let wanted = self.wanted(budget);
        self.cancel_unwanted(&wanted, &mut actions);
        self.drop_down_to(budget.keep, &wanted, &mut actions);
        self.start_reads(budget.fill, now, &wanted, &mut actions);
        self.make_way(&wanted, &mut actions);
        actions
    }

    /// Writes off the reads that take too long. When no reader is left, those who wait are told at once.
    fn give_up(&mut self, now: Duration, actions: &mut Vec<Action>) {
        let patience = self.rules.patience.max(self.longest_read.saturating_mul(SLOWER));
        for (frame, slot) in self.slots.iter_mut().enumerate() {
            if let Slot::Reading { bytes, since, .. } = *slot
                && now.saturating_sub(since) >= patience
            {
                self.lost.insert(frame, bytes);
                *slot = Slot::Failed;
                actions.push(Action::GiveUp(frame));
            }
        }
        if self.lost.len() == self.rules.readers {
            for &frame in self.awaited.iter().filter(|&&frame| self.slots[frame] == Slot::Absent) {
                actions.push(Action::GiveUp(frame));
            }
        }
    }

    fn wanted(&self, budget: Budget) -> Wanted {
        let mut wanted = Wanted {
            order: Vec::new(),
            rank: vec![usize::MAX; self.slots.len()],
            begin: 0,
            keep: 0,
            in_hand_bytes: 0,
        };
        let mut bytes = 0_u64;
        for frame in self.awaited.iter().copied().chain(self.plan.upcoming(self.slots.len())) {
            let in_hand = self.taken == Some(frame) && !self.awaited.contains(&frame);
            if wanted.rank[frame] != usize::MAX || self.slots[frame] == Slot::Failed {
                continue;
            }
            if in_hand {
                wanted.in_hand_bytes = self.expected_bytes(frame);
                continue;
            }
            wanted.rank[frame] = wanted.order.len();
            wanted.order.push(frame);
            bytes = bytes.saturating_add(self.expected_bytes(frame));
            let first = wanted.order.len() == 1;
            wanted.begin += usize::from(first || bytes <= budget.fill);
            wanted.keep += usize::from(first || bytes <= budget.keep);
        }
        wanted
    }

    fn cancel_unwanted(&mut self, wanted: &Wanted, actions: &mut Vec<Action>) {
        for (frame, slot) in self.slots.iter_mut().enumerate() {
            if let Slot::Reading { cancelled: cancelled @ false, .. } = slot
                && wanted.rank[frame] >= wanted.keep
            {
                *cancelled = true;
                actions.push(Action::Cancel(frame));
            }
        }
    }

    /// Drops ready frames, least useful first, until all fits. The most useful of all stays.
    fn drop_down_to(&mut self, limit: u64, wanted: &Wanted, actions: &mut Vec<Action>) {
        while self.held_bytes() > limit
            && let Some(frame) = self.least_useful(wanted)
            && (wanted.rank[frame] > 0 && self.holds_others(frame))
        {
            self.slots[frame] = Slot::Absent;
            actions.push(Action::Drop(frame));
        }
    }

    fn start_reads(&mut self, limit: u64, now: Duration, wanted: &Wanted, actions: &mut Vec<Action>) {
        let mut idle = self.rules.readers - self.running() - self.lost.len();
        // It will be given back, and wants its place then.
        let limit = limit.saturating_sub(wanted.in_hand_bytes);
        let mut missing = 0;
        for &frame in &wanted.order[..wanted.begin] {
            if idle == 0 {
                break;
            }
            if let Slot::Reading { .. } | Slot::Absent = self.slots[frame] {
                missing += 1;
            }
            if self.slots[frame] != Slot::Absent {
                continue;
            }
            let mut bytes = self.source_bytes[frame].saturating_add(self.expected_bytes(frame));
            let coarse = self.rules.coarse_share.filter(|_| self.aimed && wanted.rank[frame] == 0);
            if let Some(share) = coarse {
                bytes = bytes.saturating_add(bytes / u64::from(share.max(1)));
            }
            let rank = wanted.rank[frame];
            let protected = if self.is_due_soon(rank, missing) { 0 } else { wanted.keep };
            if !self.make_room(bytes, limit, wanted, rank.max(protected.saturating_sub(1)), actions) {
                // Nothing later may overtake it.
                break;
            }
            self.slots[frame] = Slot::Reading { bytes, since: now, cancelled: false };
            actions.push(Action::Start { frame, coarse: coarse.is_some() });
            idle -= 1;
        }
    }

    /// Whether there is just time to read the frame of `rank` and those missing before it, `missing` together, until it is shown.
    fn is_due_soon(&self, rank: usize, missing: usize) -> bool {
        let plays = matches!(self.plan, Plan::Play { step, .. } if step != 0);
        let awaited = rank < self.awaited.len();
        match self.pace.frames_shown_per_read().filter(|_| plays && !awaited) {
            // Twice the time: reads vary.
            Some(shown) => rank as f64 <= self.rules.readers as f64 + 2.0 * shown * missing as f64,
            None => true,
        }
    }

    /// Drops frames needed later than `rank` until `bytes` more fit or nothing is held; drops none if that is not enough.
    fn make_room(
        &mut self,
        bytes: u64,
        limit: u64,
        wanted: &Wanted,
        rank: usize,
        actions: &mut Vec<Action>,
    ) -> bool {
        let fits = |held: u64| held == 0 || held.saturating_add(bytes) <= limit;
        let later = |frame: usize| wanted.rank[frame] > rank;
        let droppable: u64 =
            self.ready().filter(|&frame| later(frame)).map(|frame| self.slots[frame].bytes()).sum();
        if !fits(self.held_bytes() - droppable) {
            return false;
        }
        while !fits(self.held_bytes()) {
            let Some(frame) = self.least_useful(wanted) else { return false };
            self.slots[frame] = Slot::Absent;
            actions.push(Action::Drop(frame));
        }
        true
    }

    /// Stops the read needed last when a frame that is waited for, or that the plan was just set for, could not be begun.
    fn make_way(&mut self, wanted: &Wanted, actions: &mut Vec<Action>) {
        let urgent = wanted.order.first().filter(|_| self.aimed || !self.awaited.is_empty());
        let blocked = urgent.is_some_and(|&frame| self.slots[frame] == Slot::Absent);
        let stopping = self.slots.iter().any(|slot| matches!(slot, Slot::Reading { cancelled: true, .. }));
        if !blocked || stopping {
            return;
        }
        let last = (0..self.slots.len())
            .filter(|&frame| matches!(self.slots[frame], Slot::Reading { .. }))
            .max_by_key(|&frame| wanted.rank[frame]);
        if let Some(frame) = last
            && let Slot::Reading { cancelled, .. } = &mut self.slots[frame]
        {
            *cancelled = true;
            actions.push(Action::Cancel(frame));
        }
    }

    fn running(&self) -> usize {
        self.slots.iter().filter(|slot| matches!(slot, Slot::Reading { .. })).count()
    }

    fn ready(&self) -> impl Iterator<Item = usize> {
        (0..self.slots.len()).filter(|&frame| matches!(self.slots[frame], Slot::Ready { .. }))
    }

    /// The ready frame shown last or never; among the latter the first of the series.
    fn least_useful(&self, wanted: &Wanted) -> Option<usize> {
        self.ready().max_by_key(|&frame| (wanted.rank[frame], std::cmp::Reverse(frame)))
    }

    fn holds_others(&self, frame: usize) -> bool {
        self.held_bytes() > self.slots[frame].bytes()
    }
}

impl Slot {
    fn bytes(&self) -> u64 {
        match *self {
            Self::Reading { bytes, .. } | Self::Ready { bytes } => bytes,
            Self::Absent | Self::Failed => 0,
        }
    }
}

/// The coming frames.
struct Wanted {
    /// In the order of showing, each once, without those that failed or are in somebody's hands.
    order: Vec<usize>,
    /// Place of each frame in `order`; `usize::MAX` where it has none.
    rank: Vec<usize>,
    /// How many of `order` fit into the budget for beginning reads.
    begin: usize,
    /// How many of `order` fit into the budget for keeping frames.
    keep: usize,
    /// Of the frame that somebody has, where it will be shown again.
    in_hand_bytes: u64,
}

/// How fast frames are read and shown.
#[derive(Debug, Default)]
struct Pace {
    read_s: Option<f64>,
    shown_s: Option<f64>,
    last_shown: Option<Duration>,
}

impl Pace {
    /// Share of a new time in the smoothed one: follows a change within a few frames, and no single odd frame.
    const NEW: f64 = 0.3;

    fn read(&mut self, time: Duration) {
        Self::learn(&mut self.read_s, time);
    }

    fn shown(&mut self, now: Duration) {
        if let Some(last) = self.last_shown.replace(now) {
            Self::learn(&mut self.shown_s, now.saturating_sub(last));
        }
    }

    fn learn(smoothed: &mut Option<f64>, time: Duration) {
        let new = time.as_secs_f64();
        let old = smoothed.get_or_insert(new);
        *old += Self::NEW * (new - *old);
    }

    /// Frames that are shown while one is read; `None` before both are known.
    fn frames_shown_per_read(&self) -> Option<f64> {
        Some(self.read_s? / self.shown_s?.max(1e-6))
    }
}
