//! `meniscus bench`: the steady state, as the user's machine has it.

mod report;
mod spread;
mod stages;
mod table;

use std::time::Instant;

use meniscus_core::{Cancel, FrameRequest, FrameSource, StageCost};
use meniscus_gpu::{Timing, process_cpu_ms};
use meniscus_pipeline::{PreparedFrame, Registry};

use self::report::{BenchReport, FrameSpread};
use self::spread::Spread;
use self::stages::StageSamples;
use crate::args::{BenchArgs, Global};
use crate::failure::Failure;
use crate::input;
use crate::picture::{self, Studio};
use crate::terminal::{Terminal, interrupt, print};

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
        table::print_table(&report);
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
