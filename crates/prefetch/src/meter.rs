use std::time::Duration;

use crate::policy::{Outcome, Policy};

/// What prefetching did so far and how it stands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PrefetchStats {
    /// Frames read and prepared.
    pub frames_read: u64,
    /// Bytes of the prepared frames.
    pub bytes_read: u64,
    /// Bytes of files that were decoded for them, as stored, where the source counts.
    pub file_bytes_read: u64,
    /// Reads stopped because the frame was no longer wanted.
    pub reads_cancelled: u64,
    /// Reads that failed.
    pub frames_failed: u64,
    /// Reads that were given up because they did not end.
    pub reads_given_up: u64,
    /// Frames that were in memory or had failed and whose files changed, so that they were given up to be read again.
    pub frames_changed: u64,
    /// Prepared frames given up unseen, for memory.
    pub frames_dropped: u64,
    /// Wall-clock time during which at least one read was running.
    pub reading: Duration,
    /// Frames that were not ready when they were taken.
    pub stalls: u64,
    /// Time spent waiting for them.
    pub stalled: Duration,
    /// Bytes held now: ready frames, and those being read at their estimate.
    pub held_bytes: u64,
    /// The most of it so far.
    pub peak_held_bytes: u64,
    /// Bytes that may be held now, by what is known of the system's free memory.
    pub budget_bytes: u64,
    /// The most by which the ready frames have exceeded the budget of their time; what is read counts when it is ready.
    pub peak_over_budget_bytes: u64,
}

impl PrefetchStats {
    /// Bytes per second of prepared frames while reading; `None` before anything was read.
    pub fn bytes_per_second(&self) -> Option<f64> {
        self.per_second(self.bytes_read)
    }

    /// Bytes per second that the medium delivered while reading; `None` where nothing was read or the source does not count.
    pub fn file_bytes_per_second(&self) -> Option<f64> {
        self.per_second(self.file_bytes_read)
    }

    fn per_second(&self, bytes: u64) -> Option<f64> {
        (bytes > 0 && !self.reading.is_zero()).then(|| bytes as f64 / self.reading.as_secs_f64())
    }
}

/// Sums up what happens. All times are since the same, arbitrary start.
#[derive(Debug, Default)]
pub(crate) struct Meter {
    sums: PrefetchStats,
    running: usize,
    reading_since: Duration,
}

impl Meter {
    pub(crate) fn read_started(&mut self, now: Duration) {
        if self.running == 0 {
            self.reading_since = now;
        }
        self.running += 1;
    }

    pub(crate) fn read_ended(&mut self, now: Duration) {
        self.running -= 1;
        if self.running == 0 {
            self.sums.reading += now.saturating_sub(self.reading_since);
        }
    }

    pub(crate) fn finished(&mut self, outcome: Outcome, file_bytes: Option<u64>) {
        match outcome {
            Outcome::Ready { bytes } => {
                self.sums.frames_read += 1;
                self.sums.bytes_read += bytes;
                self.sums.file_bytes_read += file_bytes.unwrap_or(0);
            }
            Outcome::Cancelled => self.sums.reads_cancelled += 1,
            Outcome::Failed => self.sums.frames_failed += 1,
        }
    }

    pub(crate) fn read_given_up(&mut self) {
        self.sums.reads_given_up += 1;
    }

    pub(crate) fn frame_changed(&mut self) {
        self.sums.frames_changed += 1;
    }

    pub(crate) fn frame_dropped(&mut self) {
        self.sums.frames_dropped += 1;
    }

    pub(crate) fn stalled(&mut self, time: Duration) {
        self.sums.stalls += 1;
        self.sums.stalled += time;
    }

    /// Notes what is held after everything that was to be done within `budget_bytes`.
    pub(crate) fn settled(&mut self, policy: &Policy, budget_bytes: u64) {
        let over = policy.ready_bytes().saturating_sub(budget_bytes);
        // A single frame is held whatever the budget.
        if policy.ready_count() > 1 {
            self.sums.peak_over_budget_bytes = self.sums.peak_over_budget_bytes.max(over);
        }
        self.sums.peak_held_bytes = self.sums.peak_held_bytes.max(policy.held_bytes());
    }

    /// The sums so far, with a read that still runs counted up to `now`.
    pub(crate) fn stats(&self, now: Duration, policy: &Policy, budget_bytes: u64) -> PrefetchStats {
        let running = if self.running > 0 { now.saturating_sub(self.reading_since) } else { Duration::ZERO };
        PrefetchStats {
            reading: self.sums.reading + running,
            held_bytes: policy.held_bytes(),
            budget_bytes,
            ..self.sums.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::policy::Rules;

    #[test]
    fn parallel_reads_count_once() {
        let at = Duration::from_millis;
        let policy = Policy::new(vec![10; 2], Rules { readers: 2, patience: at(1000), coarse_share: None });
        let mut meter = Meter::default();
        meter.read_started(at(100));
        meter.read_started(at(200));
        assert_eq!(meter.stats(at(250), &policy, 0).reading, at(150));
        meter.read_ended(at(300));
        meter.read_ended(at(400));
        meter.finished(Outcome::Ready { bytes: 600 }, Some(150));
        let stats = meter.stats(at(900), &policy, 0);
        assert_eq!(stats.reading, at(300));
        assert_eq!(stats.bytes_per_second(), Some(2000.0));
        assert_eq!(stats.file_bytes_per_second(), Some(500.0));
        assert_eq!(PrefetchStats::default().bytes_per_second(), None);
    }
}
