use std::cell::OnceCell;
use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, Throughput};

#[cfg(feature = "gpu")]
use crate::GpuTime;
use crate::clock;
use crate::record::{Record, Sample};

/// Samples per bench; a frame of the largest view takes seconds on a software driver.
const SAMPLES: usize = 10;

/// The benches of a stage: criterion's, with a record of each beside it (CPU and GPU time, bytes moved and the share of
/// this machine's copy bandwidth that this is).
pub struct Stage<'c> {
    name: &'static str,
    group: BenchmarkGroup<'c, WallTime>,
    memcpy_gb_per_s: OnceCell<f64>,
}

impl<'c> Stage<'c> {
    /// The benches of `name`, the package's without its `bench-`.
    pub fn new(criterion: &'c mut Criterion, name: &'static str) -> Self {
        let mut group = criterion.benchmark_group(name);
        group.sample_size(SAMPLES);
        // Of a look, criterion makes the time of a measurement the most that it takes.
        let seconds = if crate::is_quick() { 1 } else { 3 };
        group.warm_up_time(Duration::from_secs(1)).measurement_time(Duration::from_secs(seconds));
        Self { name, group, memcpy_gb_per_s: OnceCell::new() }
    }

    /// Measures `work`, which runs on the CPU, as `bench` of `view`. `input` is made once, and only where no filter leaves
    /// the bench out. `elements` (particles, pixels, frames) are for criterion's rate; `bytes` is what the work has to read
    /// and write at least.
    pub fn cpu<I, T>(
        &mut self,
        [bench, view]: [&str; 2],
        elements: u64,
        input: impl FnOnce() -> I,
        bytes: impl FnOnce(&I) -> Option<u64>,
        mut work: impl FnMut(&I) -> T,
    ) {
        let (made, mut once) = (OnceCell::new(), Some(input));
        let samples = self.samples([bench, view], elements, |times| {
            let input = made.get_or_init(|| once.take().expect("made once")());
            clock::timed(times, || work(input))
        });
        let Some(input) = made.get() else { return };
        let copy = || *self.memcpy_gb_per_s.get_or_init(clock::memcpy_gb_per_s);
        report(self.name, [bench, view], "CPU", bytes(input), copy, &samples);
    }

    /// Measures the passes that `record` records and that have one of these `names`; all of them for no name. The rest is
    /// as for [`Self::cpu`]. Gives the least of every clock, nothing where a filter leaves the bench out or nothing is measured.
    #[cfg(feature = "gpu")]
    pub fn gpu<I>(
        &mut self,
        time: &GpuTime,
        ([bench, view], names): ([&str; 2], &[&str]),
        elements: u64,
        input: impl FnOnce() -> I,
        bytes: impl FnOnce(&I) -> Option<u64>,
        mut record: impl FnMut(&I, &mut meniscus_gpu::Recorder, &meniscus_gpu::Gpu),
    ) -> Option<Sample> {
        let (made, mut once) = (OnceCell::new(), Some(input));
        let samples = self.samples([bench, view], elements, |times| {
            let input = made.get_or_init(|| once.take().expect("made once")());
            time.measure(times, names, |recorder, gpu| record(input, recorder, gpu))
        });
        let bytes = bytes(made.get()?);
        report(self.name, [bench, view], time.device(), bytes, || time.copy_gb_per_s(), &samples)
    }

    /// Criterion's run of one bench. It asks for as many measurements as there are samples, after those that warm up.
    fn samples(
        &mut self,
        [bench, view]: [&str; 2],
        elements: u64,
        mut measure: impl FnMut(u64) -> Sample,
    ) -> Vec<Sample> {
        let mut samples = Vec::new();
        self.group.throughput(Throughput::Elements(elements));
        self.group.bench_function(BenchmarkId::new(bench, view), |b| {
            b.iter_custom(|times| {
                let sample = measure(times);
                samples.push(sample);
                Duration::from_secs_f64(sample.wall_ms * 1e-3 * times as f64)
            });
        });
        samples.split_off(samples.len().saturating_sub(SAMPLES))
    }
}

#[expect(clippy::print_stderr, reason = "beside criterion's own lines")]
fn report(
    stage: &str,
    [bench, view]: [&str; 2],
    device: &str,
    bytes: Option<u64>,
    copy_gb_per_s: impl FnOnce() -> f64,
    samples: &[Sample],
) -> Option<Sample> {
    if !crate::is_measured() {
        return None;
    }
    let copy_gb_per_s = copy_gb_per_s();
    Record { stage, bench, view, device, bytes, copy_gb_per_s, samples }.append();
    let least = Sample::least(samples)?;
    let gpu_ms = least.gpu_ms.map_or("-".to_owned(), |ms| format!("{ms:.3} ms"));
    eprintln!("{:24}least CPU: {:.3} ms, GPU: {gpu_ms}", "", least.cpu_ms);
    if let Some(bytes) = bytes {
        let rate = bytes as f64 / least.gpu_ms.unwrap_or(least.wall_ms) * 1e-6;
        let share = 100.0 * rate / copy_gb_per_s;
        eprintln!("{:24}{rate:.2} GB/s, {share:.1} % of a copy ({copy_gb_per_s:.1} GB/s)\n", "");
    }
    Some(least)
}
