//! `meniscus bench`: the steady state, as the user's machine has it.

use std::collections::BTreeMap;
use std::time::Instant;

use meniscus_core::{Cancel, Flaws, FrameRequest, FrameSource, StageCost};
use meniscus_gpu::{Timing, process_cpu_ms};
use meniscus_pipeline::{PreparedFrame, Registry};
use serde::Serialize;

use crate::args::{BenchArgs, Global};
use crate::failure::Failure;
use crate::input;
use crate::picture::{self, Studio};
use crate::terminal::{Terminal, interrupt, print};

/// Median, smallest and largest of some milliseconds.
#[derive(Clone, Copy, Debug, Serialize)]
struct Spread {
    median: f64,
    min: f64,
    max: f64,
}

impl Spread {
    /// `None` for no samples.
    fn of(samples: &[f64]) -> Option<Self> {
        let mut sorted = samples.to_vec();
        sorted.sort_by(f64::total_cmp);
        let middle = sorted.len() / 2;
        let median = match sorted.len() {
            0 => return None,
            n if n % 2 == 1 => sorted[middle],
            _ => 0.5 * (sorted[middle - 1] + sorted[middle]),
        };
        Some(Self { median, min: sorted[0], max: sorted[sorted.len() - 1] })
    }
}

#[derive(Debug, Serialize)]
struct BenchReport {
    adapter: String,
    driver: String,
    size: [u32; 2],
    particles: u64,
    kept: u64,
    covered_fraction: f64,
    frame: FrameSpread,
    stages: Vec<StageCost>,
    peak_bytes: u64,
    flaws: Flaws,
}

#[derive(Debug, Serialize)]
struct FrameSpread {
    wall_ms: Option<Spread>,
    cpu_ms: Option<Spread>,
    gpu_ms: Option<Spread>,
}

/// How far the camera goes around its target every frame.
const ORBIT_DEG_PER_FRAME: f32 = 0.5;

/// Pictures whose passes are run one by one for their wall and CPU time; medians of few are enough for a table.
const ISOLATED_FRAMES: u32 = 5;

pub fn run(
    args: &BenchArgs,
    global: &Global,
    registry: Registry,
    terminal: &Terminal,
) -> Result<(), Failure> {
    let Some(settings) = picture::settings(&args.picture, &registry)? else { return Ok(()) };
    let cancel = interrupt();
    let series = input::open(&args.input)?;
    if args.frame >= series.frame_count() {
        let last = series.frame_count().max(1) - 1;
        return Err(Failure::Usage(format!("--frame {}: the series has frames 0 to {last}", args.frame)));
    }
    let mut studio = Studio::open(&series, &args.picture, settings, global, registry, terminal)?;
    let frame = series.read(args.frame, &FrameRequest::default(), &cancel)?;
    terminal.flaws(&frame.flaws);
    let mut flaws = studio.flaws.clone();
    flaws.merge(&frame.flaws);
    let frame = studio.renderer.preparer(&studio.world).prepare(frame);

    let bar = terminal.progress(u64::from(args.warmup + args.frames + ISOLATED_FRAMES), "pictures");
    let mut orbit = Orbit { step: 0 };
    for _ in 0..args.warmup {
        orbit.draw(&mut studio, &frame, &cancel)?;
        bar.inc(1);
    }
    let (mut wall, mut cpu, mut gpu) = (Vec::new(), Vec::new(), Vec::new());
    let mut stages = StageSamples::default();
    for _ in 0..args.frames {
        let (started, cpu_before) = (Instant::now(), process_cpu_ms());
        orbit.draw(&mut studio, &frame, &cancel)?;
        wall.push(started.elapsed().as_secs_f64() * 1e3);
        cpu.push(process_cpu_ms() - cpu_before);
        let costs = studio.renderer.take_costs();
        let stamps: Vec<f64> = costs.iter().filter_map(|c| c.gpu_ms).collect();
        if !stamps.is_empty() {
            gpu.push(stamps.iter().sum());
        }
        stages.add(costs);
        bar.inc(1);
    }
    // Counts belong to the measured frames; the isolated ones only add clocks.
    let counts = studio.renderer.counts();
    studio.renderer.set_timing(Timing::Isolated);
    for _ in 0..ISOLATED_FRAMES {
        orbit.draw(&mut studio, &frame, &cancel)?;
        stages
            .add(studio.renderer.take_costs().into_iter().map(|c| StageCost { gpu_ms: None, ..c }).collect());
        bar.inc(1);
    }
    bar.finish_and_clear();

    let summary = studio.renderer.gpu().summary().clone();
    let report = BenchReport {
        adapter: summary.name,
        driver: summary.driver,
        size: studio.size,
        particles: counts.input,
        kept: counts.kept,
        covered_fraction: studio.renderer.covered_fraction()?,
        frame: FrameSpread { wall_ms: Spread::of(&wall), cpu_ms: Spread::of(&cpu), gpu_ms: Spread::of(&gpu) },
        stages: stages.medians(),
        peak_bytes: studio.renderer.gpu().memory().peak(),
        flaws,
    };
    if args.json {
        print(serde_json::to_string_pretty(&report).unwrap_or_default());
    } else {
        print_table(&report);
    }
    Ok(())
}

/// The camera's way around the scene.
struct Orbit {
    step: u32,
}

impl Orbit {
    fn draw(&mut self, studio: &mut Studio, frame: &PreparedFrame, cancel: &Cancel) -> Result<(), Failure> {
        if cancel.is_cancelled() {
            return Err(Failure::Interrupted);
        }
        let mut camera = studio.camera;
        let angle = (self.step as f32 * ORBIT_DEG_PER_FRAME).to_radians();
        let axis = studio.world.space().up.vector();
        camera.eye = camera.target + glam::Quat::from_axis_angle(axis, angle) * (camera.eye - camera.target);
        self.step += 1;
        Ok(studio.renderer.draw_and_wait(frame, &studio.world, &camera, studio.size)?)
    }
}

/// Clocks of every stage over all frames, in the order in which stages first ran.
#[derive(Default)]
struct StageSamples {
    order: Vec<String>,
    samples: BTreeMap<String, [Vec<f64>; 3]>,
}

impl StageSamples {
    fn add(&mut self, costs: Vec<StageCost>) {
        for cost in costs {
            if !self.samples.contains_key(&cost.name) {
                self.order.push(cost.name.clone());
            }
            let clocks = self.samples.entry(cost.name).or_default();
            for (clock, value) in clocks.iter_mut().zip([cost.gpu_ms, cost.wall_ms, cost.cpu_ms]) {
                clock.extend(value);
            }
        }
    }

    fn medians(&self) -> Vec<StageCost> {
        let median = |samples: &[f64]| Spread::of(samples).map(|s| s.median);
        self.order
            .iter()
            .map(|name| {
                let [gpu, wall, cpu] = &self.samples[name];
                StageCost {
                    name: name.clone(),
                    gpu_ms: median(gpu),
                    wall_ms: median(wall),
                    cpu_ms: median(cpu),
                }
            })
            .collect()
    }
}

fn print_table(report: &BenchReport) {
    print(format_args!("{} ({})", report.adapter, report.driver));
    print(format_args!(
        "{}x{}, {} particles, {} kept, {:.0} % of the picture covered, {:.0} MiB of GPU memory at most",
        report.size[0],
        report.size[1],
        report.particles,
        report.kept,
        report.covered_fraction * 100.0,
        report.peak_bytes as f64 / f64::from(1 << 20),
    ));
    print(format_args!("{:28} {:>10} {:>10} {:>10}", "ms, median", "gpu", "wall", "cpu"));
    let cell = |v: Option<f64>| v.map_or_else(|| "-".to_owned(), |v| format!("{v:.2}"));
    let spread = |s: Option<Spread>| cell(s.map(|s| s.median));
    let frame = &report.frame;
    print(format_args!(
        "{:28} {:>10} {:>10} {:>10}",
        "whole frame",
        spread(frame.gpu_ms),
        spread(frame.wall_ms),
        spread(frame.cpu_ms)
    ));
    for stage in &report.stages {
        print(format_args!(
            "  {:26} {:>10} {:>10} {:>10}",
            stage.name,
            cell(stage.gpu_ms),
            cell(stage.wall_ms),
            cell(stage.cpu_ms)
        ));
    }
    print(format_args!(
        "wall and cpu of a stage are of that stage run on its own; the whole frame is less than their sum"
    ));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_do_not_follow_outliers() {
        let spread = Spread::of(&[3.0, 1.0, 100.0, 2.0]).unwrap();
        assert_eq!((spread.median, spread.min, spread.max), (2.5, 1.0, 100.0));
        assert!(Spread::of(&[]).is_none());
    }

    #[test]
    fn stages_keep_their_order_and_a_missing_clock_stays_missing() {
        let cost = |name: &str, gpu_ms| StageCost { name: name.into(), gpu_ms, ..Default::default() };
        let mut samples = StageSamples::default();
        samples.add(vec![cost("b", Some(1.0)), cost("a", None)]);
        samples.add(vec![cost("b", Some(3.0)), cost("a", None)]);
        let medians = samples.medians();
        assert_eq!(medians[0], cost("b", Some(2.0)));
        assert_eq!(medians[1], cost("a", None));
    }
}
