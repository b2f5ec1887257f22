use std::hint::black_box;
use std::time::Instant;

use crate::Sample;

/// Runs `work` `times` times; what one run took on average.
pub(crate) fn timed<T>(times: u64, mut work: impl FnMut() -> T) -> Sample {
    let (wall, cpu) = (Instant::now(), process_cpu_ms());
    for _ in 0..times {
        black_box(work());
    }
    let runs = times.max(1) as f64;
    Sample {
        wall_ms: wall.elapsed().as_secs_f64() * 1e3 / runs,
        cpu_ms: (process_cpu_ms() - cpu) / runs,
        gpu_ms: None,
    }
}

/// User + system milliseconds of this process so far. Not that of `meniscus-gpu`, which benches without a GPU do not build.
fn process_cpu_ms() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 * 1e-6
}

/// Bytes read and written per second, 1e9, by all cores together copying 64 MiB each: the best of five, since whoever else
/// uses the machine can only slow it down.
pub(crate) fn memcpy_gb_per_s() -> f64 {
    const BYTES: usize = 64 << 20;
    const RUNS: usize = 5;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut pairs: Vec<_> = (0..threads).map(|i| (vec![i as u8 + 1; BYTES], vec![1_u8; BYTES])).collect();
    let mut copy_all = || {
        std::thread::scope(|scope| {
            for (source, target) in &mut pairs {
                scope.spawn(|| black_box(&mut *target).copy_from_slice(black_box(source)));
            }
        });
    };
    let best_ms = (0..RUNS).map(|_| timed(1, &mut copy_all).wall_ms).fold(f64::MAX, f64::min);
    (2 * BYTES * threads) as f64 / best_ms * 1e-6
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sleep is never shorter than asked. The CPU clock is that of the whole process, in which other tests run.
    #[test]
    fn times_are_of_one_run() {
        let sample = timed(2, || std::thread::sleep(std::time::Duration::from_millis(20)));
        assert!(sample.wall_ms >= 20.0 && sample.cpu_ms >= 0.0, "{sample:?}");
    }
}
