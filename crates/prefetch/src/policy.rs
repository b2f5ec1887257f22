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
    /// Could not be read. Read again when it is taken again.
    Failed,
    /// Taken last, and not given back.
    Taken,
}

/// What is to be done, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    /// Let go of the ready frame.
    Drop(usize),
    /// Ask the running read to stop. Its end is still reported.
    Cancel(usize),
    /// Let an idle reader read the frame.
    Start(usize),
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
    Reading { bytes: u64, cancelled: bool },
    Ready { bytes: u64 },
    Failed,
}

/// Decides what is read, stopped and kept. Told what happens; asked by [`Policy::decide`] what to do.
///
/// * Frames are read in the order in which they will be shown; a frame that somebody waits for comes before all.
/// * Wanted is the longest run of coming frames that fits into the budget, and always the first one. A running read of any
///   other frame is stopped.
/// * A frame is begun when it fits beside what is held, dropping what is needed later - or when nothing else is held, so
///   that a budget below one frame still shows frames.
/// * Frames that are not needed stay as long as there is room.
/// * While it is read, a frame counts twice: as the source delivers it and as it is prepared from that.
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
    readers: usize,
    /// Frames that are waited for, in the order asked.
    awaited: Vec<usize>,
    taken: Option<usize>,
}

impl Policy {
    /// For frames of `source_bytes` each and `readers` parallel reads.
    pub(crate) fn new(source_bytes: Vec<u64>, readers: usize) -> Self {
        let count = source_bytes.len();
        Self {
            plan: Plan::IDLE,
            slots: vec![Slot::Absent; count],
            source_bytes,
            prepared_bytes: vec![None; count],
            bytes_ratio: 1.0,
            readers,
            awaited: Vec::new(),
            taken: None,
        }
    }

    pub(crate) fn set_plan(&mut self, plan: Plan) {
        self.plan = plan;
    }

    /// Somebody waits for `frame`. One that failed is tried again.
    pub(crate) fn await_frame(&mut self, frame: usize) {
        if self.slots[frame] == Slot::Failed {
            self.slots[frame] = Slot::Absent;
        }
        self.awaited.push(frame);
    }

    /// `frame` was handed out, as a frame or as its error: it is no longer here, and the plan moves on.
    pub(crate) fn taken(&mut self, frame: usize) {
        if let Some(place) = self.awaited.iter().position(|&awaited| awaited == frame) {
            self.awaited.remove(place);
        }
        if let Slot::Ready { .. } = self.slots[frame] {
            self.slots[frame] = Slot::Absent;
            self.taken = Some(frame);
        }
        self.plan.advance_past(frame, self.slots.len());
    }

    /// `frame` was given back. Returns whether it is kept: not where it is here again or being read already, and not where
    /// it was never handed out.
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

    /// The read of `frame` ended.
    pub(crate) fn finished(&mut self, frame: usize, outcome: Outcome) {
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
        self.slots.iter().map(|slot| slot.bytes()).sum()
    }

    /// Bytes of the ready frames.
    pub(crate) fn ready_bytes(&self) -> u64 {
        self.ready().map(|frame| self.slots[frame].bytes()).sum()
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

    /// What to do within `budget`. The actions count as done.
    pub(crate) fn decide(&mut self, budget: Budget) -> Vec<Action> {
        let wanted = self.wanted(budget);
        let mut actions = Vec::new();
        self.cancel_unwanted(&wanted, &mut actions);
        self.drop_down_to(budget.keep, &wanted, &mut actions);
        self.start_reads(budget.fill, &wanted, &mut actions);
        self.make_way(&wanted, &mut actions);
        actions
    }

    fn wanted(&self, budget: Budget) -> Wanted {
        let mut wanted =
            Wanted { order: Vec::new(), rank: vec![usize::MAX; self.slots.len()], begin: 0, keep: 0 };
        let mut bytes = 0_u64;
        for frame in self.awaited.iter().copied().chain(self.plan.upcoming(self.slots.len())) {
            let in_hand = self.taken == Some(frame) && !self.awaited.contains(&frame);
            if wanted.rank[frame] != usize::MAX || self.slots[frame] == Slot::Failed || in_hand {
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

    fn start_reads(&mut self, limit: u64, wanted: &Wanted, actions: &mut Vec<Action>) {
        let mut idle = self.readers - self.running();
        for &frame in &wanted.order[..wanted.begin] {
            if idle == 0 {
                break;
            }
            if self.slots[frame] != Slot::Absent {
                continue;
            }
            let bytes = self.source_bytes[frame].saturating_add(self.expected_bytes(frame));
            if !self.make_room(bytes, limit, wanted, wanted.rank[frame], actions) {
                // Nothing later may overtake it.
                break;
            }
            self.slots[frame] = Slot::Reading { bytes, cancelled: false };
            actions.push(Action::Start(frame));
            idle -= 1;
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

    /// Stops the read needed last when a frame that is waited for could not be begun.
    fn make_way(&mut self, wanted: &Wanted, actions: &mut Vec<Action>) {
        let blocked = self.awaited.first().is_some_and(|&frame| self.slots[frame] == Slot::Absent);
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
}
