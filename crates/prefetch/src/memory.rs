//! How much memory is free.

use sysinfo::{CGroupLimits, MemoryRefreshKind, Pid, ProcessRefreshKind, ProcessesToUpdate, System};

use crate::PrefetchError;

/// Tells how much memory could still be taken.
pub trait MemoryProbe: Send {
    /// Bytes that this process could take without pushing others out: free memory and what the system gives back on
    /// demand, within the limits set on this process.
    fn available_bytes(&mut self) -> u64;
}

/// The memory of this machine; of the control group (container) that this process runs in, where that has less; and what the
/// limits of the process itself (`ulimit -v`, `-d`) leave.
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

    /// The limit of this process's group, the strictest of those above it included, else of the container.
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
        let group = self.group_limits().map(|group| group.total_memory.saturating_sub(group.rss));
        [group, left_by_own_limits()].into_iter().flatten().fold(machine, u64::min)
    }
}

/// What the limits on the process's own address space and data leave; `None` where there are none. Allocations beyond them fail,
/// which ends the process.
#[cfg(target_os = "linux")]
fn left_by_own_limits() -> Option<u64> {
    use rustix::process::{Resource, getrlimit};

    let limits = [(Resource::As, "VmSize:"), (Resource::Data, "VmData:")];
    let limits = limits.map(|(resource, used)| (getrlimit(resource).current, used));
    if limits.iter().all(|(limit, _)| limit.is_none()) {
        return None;
    }
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    limits.into_iter().filter_map(|(limit, used)| Some(limit?.saturating_sub(bytes_in(&status, used)?))).min()
}

#[cfg(not(target_os = "linux"))]
fn left_by_own_limits() -> Option<u64> {
    None
}

/// The bytes that the line of a `/proc/.../status` states which starts with `name`.
#[cfg(target_os = "linux")]
fn bytes_in(status: &str, name: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_machine_has_memory() {
        let available = SystemMemory::new().expect("memory figures").available_bytes();
        assert!(available > 1 << 20, "{available}");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn figures_of_the_process_are_in_kib() {
        let status = "Name:\tx\nVmPeak:\t 9 kB\nVmSize:\t   12344 kB\nVmData:\t 7 kB\n";
        assert_eq!(bytes_in(status, "VmSize:"), Some(12344 << 10));
        assert_eq!(bytes_in(status, "VmLck:"), None);
    }
}
