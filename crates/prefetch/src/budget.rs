use crate::PrefetchError;

/// How much memory prefetched frames may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MemoryLimit {
    /// This share of the free memory, above 0 and at most 1. What is taken counts as free here, so the share does not shrink
    /// while it is used. The nearer to 1, the slower memory goes back to programs that need it; at 1 none does.
    Share(f64),
    /// This many bytes, and never more than nine tenths of the free memory.
    Bytes(u64),
}

/// Share of the free memory that stays the bound of a limit in bytes: the rest is for everybody else, who take some before it
/// is noticed.
const MOST: f64 = 0.9;

impl MemoryLimit {
    pub(crate) fn validate(self) -> Result<(), PrefetchError> {
        match self {
            Self::Share(share) if !(share > 0.0 && share <= 1.0) => {
                Err(PrefetchError::MemoryShare { found: share })
            }
            _ => Ok(()),
        }
    }

    /// What it leaves to frames when `free` bytes are free or theirs.
    fn of(self, free: u64) -> u64 {
        match self {
            Self::Share(share) => (share * free as f64) as u64,
            Self::Bytes(bytes) => bytes.min((MOST * free as f64) as u64),
        }
    }
}

/// How much may be held. Two limits, because it is not known how much of a running read has been allocated yet, and so that
/// small changes of the free memory do not drop frames that are read again right after.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Budget {
    /// Reads are begun up to here: as if running reads had allocated nothing, less one sixteenth.
    pub fill: u64,
    /// Frames are dropped from here on: as if running reads had allocated everything.
    pub keep: u64,
}

impl Budget {
    /// What `limit` makes of what is `available` and what is held already - in `ready` frames and in running reads that will
    /// take `reading` bytes. Counting what is held keeps the budget in place while it is used up.
    pub(crate) fn new(limit: MemoryLimit, available: u64, ready: u64, reading: u64) -> Self {
        let settled = available.saturating_add(ready);
        let fill = limit.of(settled);
        Self { fill: fill - fill / 16, keep: limit.of(settled.saturating_add(reading)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HALF: MemoryLimit = MemoryLimit::Share(0.5);

    #[test]
    fn using_the_budget_does_not_change_it() {
        let free = 1600;
        assert_eq!(Budget::new(HALF, free, 0, 0), Budget { fill: 750, keep: 800 });
        for ready in [1, 250, 500] {
            assert_eq!(Budget::new(HALF, free - ready, ready, 0), Budget { fill: 750, keep: 800 });
        }
        // A read of 200 that has allocated half of it: the truth lies between the limits.
        assert_eq!(Budget::new(HALF, free - 100, 0, 200), Budget { fill: 704, keep: 850 });
        // Somebody else took all that was left beside 400 of ours.
        assert_eq!(Budget::new(HALF, 0, 400, 0).keep, 200);
    }

    #[test]
    fn bytes_are_a_limit_only_where_there_is_as_much() {
        let limit = MemoryLimit::Bytes(1600);
        assert_eq!(Budget::new(limit, 1 << 20, 500, 0), Budget { fill: 1500, keep: 1600 });
        assert_eq!(Budget::new(limit, 500, 500, 0).keep, 900);
    }

    #[test]
    fn shares_are_fractions() {
        for share in [0.0, -1.0, 1.1, f64::NAN] {
            assert!(MemoryLimit::Share(share).validate().is_err(), "{share}");
        }
        assert!(MemoryLimit::Share(1.0).validate().is_ok() && MemoryLimit::Bytes(0).validate().is_ok());
    }
}
