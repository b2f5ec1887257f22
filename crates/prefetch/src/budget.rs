use sysinfo::{CGroupLimits, MemoryRefreshKind, Pid, ProcessRefreshKind, ProcessesToUpdate, System};

use crate::PrefetchError;

/// Tells how much memory could still be taken.
pub trait MemoryProbe: Send {
    /// Bytes that this process could take without pushing others out: free memory and what the system gives back on
    /// demand, within the limits set on this process.
    fn available_bytes(&mut self) -> u64;
}

/// The memory of this machine, or of the control group (container) that this process runs in where that has less.
#[derive(Debug)]
pub struct SystemMemory {
    system: System,
    own: Option<Pid>,
}

impl SystemMemory {
    /// Looks up where this system keeps its figures.
    ///
    /// # Errors
    /// [`PrefetchError::Memory`] where the system does not tell.
    pub fn new() -> Result<Self, PrefetchError> {
        let mut system = System::new()?;
        let own = sysinfo::get_current_pid().ok();
        if let Some(pid) = own {
            let nothing_of_it = ProcessRefreshKind::nothing();
            system.refresh_processes_specifics(ProcessesToUpdate::Some(&[pid]), true, nothing_of_it);
        }
        Ok(Self { system, own })
    }

    /// The limit of this process's group, else of the container.
    fn group_limits(&self) -> Option<CGroupLimits> {
        self.own
            .and_then(|pid| self.system.process(pid)?.cgroup_limits())
            .or_else(|| self.system.cgroup_limits())
    }
}

impl MemoryProbe for SystemMemory {
    fn available_bytes(&mut self) -> u64 {
        self.system.refresh_memory_specifics(MemoryRefreshKind::nothing().with_ram());
        let machine = self.system.available_memory();
        // Not the group's free memory: that counts cached file pages as used, which reading frames makes many of and
        // which are given back on demand.
        self.group_limits().map_or(machine, |group| machine.min(group.total_memory.saturating_sub(group.rss)))
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
    /// `share` (0 to 1) of what is `available` and what is held already - in `ready` frames and in running reads that will
    /// take `reading` bytes. Counting what is held keeps the budget in place while it is used up.
    pub(crate) fn new(share: f64, available: u64, ready: u64, reading: u64) -> Self {
        let of = |bytes: u64| (share * bytes as f64) as u64;
        let settled = available.saturating_add(ready);
        let fill = of(settled);
        Self { fill: fill - fill / 16, keep: of(settled.saturating_add(reading)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn using_the_budget_does_not_change_it() {
        let free = 1600;
        assert_eq!(Budget::new(0.5, free, 0, 0), Budget { fill: 750, keep: 800 });
        for ready in [1, 250, 500] {
            assert_eq!(Budget::new(0.5, free - ready, ready, 0), Budget { fill: 750, keep: 800 });
        }
        // A read of 200 that has allocated half of it: the truth lies between the limits.
        assert_eq!(Budget::new(0.5, free - 100, 0, 200), Budget { fill: 704, keep: 850 });
        // Somebody else took all that was left beside 400 of ours.
        assert_eq!(Budget::new(0.5, 0, 400, 0).keep, 200);
    }

    #[test]
    fn this_machine_has_memory() {
        let available = SystemMemory::new().expect("memory figures").available_bytes();
        assert!(available > 1 << 20, "{available}");
    }
}
