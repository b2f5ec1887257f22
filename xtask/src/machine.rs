//! Is this machine fit to measure on?

use std::{fs, time::Duration};

/// Share of the cores that others may use before figures are worth a warning.
const BUSY: f64 = 0.1;

/// Cores, and how much others use them now; takes a second. Where the system does not tell, cores alone.
pub fn state() -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let before = fs::read_to_string("/proc/stat").unwrap_or_default();
    std::thread::sleep(Duration::from_secs(1));
    let after = fs::read_to_string("/proc/stat").unwrap_or_default();
    let load = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let load = load.split_whitespace().next().map_or(String::new(), |load| format!(", load average {load}"));
    let mut text = format!("{cores} cores{load}");
    if let Some(busy) = busy_share(&before, &after) {
        text += &format!(", {:.0} % in use by others", 100.0 * busy);
        if busy > BUSY {
            text += "\nwarning: this machine is busy; wall times are too long, compare CPU times or wait";
        }
    }
    text
}

/// Share of the time of all cores that was not idle between two readings of `/proc/stat`.
fn busy_share(before: &str, after: &str) -> Option<f64> {
    let times = |text: &str| -> Option<(u64, u64)> {
        let line = text.lines().find_map(|line| line.strip_prefix("cpu "))?;
        let numbers: Vec<u64> = line.split_whitespace().map_while(|n| n.parse().ok()).collect();
        // user, nice, system, idle, iowait, irq, softirq, steal; guests are part of user.
        let all = numbers.get(..8)?.iter().sum();
        Some((all, numbers[3] + numbers[4]))
    };
    let ((all_before, idle_before), (all_after, idle_after)) = (times(before)?, times(after)?);
    let all = all_after.checked_sub(all_before).filter(|all| *all > 0)?;
    Some(1.0 - idle_after.saturating_sub(idle_before) as f64 / all as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn busy_is_what_is_neither_idle_nor_waiting() {
        let before = "cpu  100 0 100 700 100 0 0 0 0 0\ncpu0 1 2 3\n";
        let after = "cpu  130 0 120 740 110 0 0 0 0 0\n";
        assert!((busy_share(before, after).unwrap() - 0.5).abs() < 1e-12);
        assert_eq!(busy_share(before, before), None);
        assert_eq!(busy_share("", after), None);
    }
}
