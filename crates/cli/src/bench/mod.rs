//! `meniscus bench`: the steady state, as the user's machine has it.

mod compare;
mod play;
mod report;
mod spread;
mod stages;
mod table;

use std::time::{Instant, SystemTime};

use meniscus_core::{Cancel, FrameSource, StageCost};
use meniscus_gpu::{Timing, process_cpu_ms};
use meniscus_io::Series;
use meniscus_pipeline::{PreparedFrame, RateGovernor, Registry};
use serde_json::Value;

use self::report::{BenchReport, FrameSpread, StageSpread};
use self::spread::Spread;
use self::stages::StageSamples;
use crate::args::{BenchArgs, Global, PictureArgs};
use crate::failure::Failure;
use crate::input;
use crate::picture::{self, Studio};
use crate::report::RenderReport;
use crate::terminal::{Terminal, interrupt, print};
use crate::trace::{Trace, Track};
use crate::values::Detail;

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
    if !args.compare.is_empty() {
        return compare::run(&args.compare, args.json);
    }
    if args.play.play {
        return play::run(args, global, registry, terminal);
    }
    let Some(settings) = picture::settings(&args.picture, &registry)? else { return Ok(()) };
    let cancel = interrupt();
    let series = input::open(&args.input, false, &cancel)?;
    check_frame(args.frame, &series)?;
    let trace = Trace::new(args.trace.is_some());
    let mut studio = Studio::open(&series, &args.picture, settings, global, registry, terminal)?;
    let camera = studio.camera;
    studio.meter(&series, &[(args.frame, camera)], &cancel, terminal)?;
    let preparer = studio.renderer.preparer(&studio.world);
    let (mut read_ms, mut prepare_ms) = (Vec::new(), Vec::new());
    let frame = loop {
        let started = Instant::now();
        let frame = series.read(args.frame, studio.world.request(), &cancel)?;
        read_ms.push(ms_since(started));
        trace.span(Track::Drawing, "read", started, Value::Null);
        let (flaws, started) = (frame.flaws.clone(), Instant::now());
        let frame = preparer.prepare(frame);
        prepare_ms.push(ms_since(started));
        trace.span(Track::Drawing, "prepare", started, Value::Null);
        if read_ms.len() == READS {
            terminal.flaws(&flaws);
            break frame;
        }
    };
    let mut flaws = studio.flaws.clone();
    flaws.merge(&frame.flaws);

    let bar = terminal.progress(u64::from(args.warmup + args.frames + ISOLATED_FRAMES), "pictures");
    studio.renderer.set_tracing(args.trace.is_some());
    let mut orbit = Orbit::new(&args.picture);
    let warmup_ms = warm_up(args.warmup, || {
        let started = Instant::now();
        orbit.draw(&mut studio, &frame, &cancel)?;
        // Else the measured pictures would get the clocks of these.
        studio.renderer.take_costs();
        bar.inc(1);
        let elapsed_ms = ms_since(started);
        note(&trace, &mut studio, "warm-up picture", started);
        Ok(elapsed_ms)
    })?;
    let (mut wall, mut cpu, mut gpu) = (Vec::new(), Vec::new(), Vec::new());
    let mut stages = StageSamples::default();
    for _ in 0..args.frames {
        let (started, cpu_before) = (Instant::now(), process_cpu_ms());
        orbit.draw(&mut studio, &frame, &cancel)?;
        wall.push(ms_since(started));
        cpu.push(process_cpu_ms() - cpu_before);
        let costs = studio.renderer.take_costs();
        let stamps: Vec<f64> = costs.iter().filter_map(|c| c.gpu_ms).collect();
        if !stamps.is_empty() {
            gpu.push(stamps.iter().sum());
        }
        stages.add(costs);
        note(&trace, &mut studio, "picture", started);
        bar.inc(1);
    }
    // Counts belong to the measured frames; the isolated ones only add clocks.
    let counts = studio.renderer.counts();
    studio.renderer.set_timing(Timing::Isolated);
    for _ in 0..ISOLATED_FRAMES {
        let started = Instant::now();
        orbit.draw(&mut studio, &frame, &cancel)?;
        stages
            .add(studio.renderer.take_costs().into_iter().map(|c| StageCost { gpu_ms: None, ..c }).collect());
        note(&trace, &mut studio, "picture, pass by pass", started);
        bar.inc(1);
    }
    bar.finish_and_clear();
    // Passes that count take longer: in a picture of their own, as in production otherwise.
    studio.renderer.set_timing(Timing::Stamps);
    studio.renderer.set_counting(true);
    let started = Instant::now();
    orbit.draw(&mut studio, &frame, &cancel)?;
    let counters = studio.renderer.counters(&frame)?;
    note(&trace, &mut studio, "picture, counted", started);
    trace.counters(&counters);

    let summary = studio.renderer.gpu().summary().clone();
    let report = BenchReport {
        command: std::env::args_os().map(|arg| arg.to_string_lossy().into_owned()).collect(),
        unix_time_s: SystemTime::UNIX_EPOCH.elapsed().map_or(0, |age| age.as_secs()),
        setup: setup(&studio, &series),
        input: args.input.input.clone(),
        series_frame: args.frame,
        pictures: args.frames,
        warmup_pictures: warmup_ms.len() as u32,
        orbit_deg_per_picture: ORBIT_DEG_PER_FRAME,
        threads: rayon::current_num_threads(),
        adapter: summary.name,
        driver: summary.driver,
        size: studio.size,
        particles: counts.input,
        kept: counts.kept,
        covered_fraction: studio.renderer.covered_fraction()?,
        read_ms: Spread::of(&read_ms),
        prepare_ms: Spread::of(&prepare_ms),
        first_picture_ms: warmup_ms.first().copied(),
        frame: FrameSpread { wall_ms: Spread::of(&wall), cpu_ms: Spread::of(&cpu), gpu_ms: Spread::of(&gpu) },
        stages: StageSpread::all(&stages),
        counters,
        peak_bytes: studio.renderer.gpu().memory().peak(),
        flaws,
    };
    if args.json {
        print(serde_json::to_string_pretty(&report).unwrap_or_default());
    } else {
        table::print_table(&report);
    }
    // Last: a trace that cannot be written costs no measurement.
    args.trace.as_ref().map_or(Ok(()), |path| trace.write(path))
}

fn check_frame(frame: usize, series: &Series) -> Result<(), Failure> {
    if frame < series.frame_count() {
        return Ok(());
    }
    let last = series.frame_count().max(1) - 1;
    Err(Failure::Usage(format!("--frame {frame}: the series has frames 0 to {last}")))
}

/// How often the frame is read and prepared, to see how much that varies.
const READS: usize = 3;

/// Pictures that may be added to the warm-up.
const MOST_EXTRA_WARMUP: usize = 10;

/// A picture this much faster than the one before it says that the machine was not warm: drivers compile in the background.
/// Less is noise.
const STILL_WARMING: f64 = 0.75;

/// Draws at least `asked` pictures, and more while each is clearly faster than the one before; none for none. Gives the
/// milliseconds of each.
fn warm_up(asked: u32, mut draw: impl FnMut() -> Result<f64, Failure>) -> Result<Vec<f64>, Failure> {
    let mut times = Vec::new();
    if asked == 0 {
        return Ok(times);
    }
    let asked = asked as usize;
    loop {
        times.push(draw()?);
        let faster = matches!(times[..], [.., before, last] if last < STILL_WARMING * before);
        if times.len() >= asked && (!faster || times.len() >= asked + MOST_EXTRA_WARMUP) {
            return Ok(times);
        }
    }
}

/// Notes a picture and what the renderer did for it.
fn note(trace: &Trace, studio: &mut Studio, name: &'static str, started: Instant) {
    trace.span(Track::Frames, name, started, Value::Null);
    trace.renderer(studio.renderer.take_spans());
}

fn ms_since(started: Instant) -> f64 {
    started.elapsed().as_secs_f64() * 1e3
}

/// The entries of a render report that decide what a picture costs.
fn setup(studio: &Studio, series: &Series) -> serde_json::Map<String, Value> {
    let report = serde_json::to_value(RenderReport::new(studio, series)).unwrap_or_default();
    let keys = ["version", "device", "camera", "space", "settings", "choices"];
    keys.iter().map(|key| ((*key).to_owned(), report[key].clone())).collect()
}

/// The camera's way around the scene.
struct Orbit {
    step: u32,
    /// Where a rate is to be held.
    governor: Option<RateGovernor>,
}

impl Orbit {
    fn new(args: &PictureArgs) -> Self {
        let governor = match args.lod {
            Detail::Rate(rate) => Some(RateGovernor::new(rate)),
            Detail::Threshold(_) | Detail::Auto => None,
        };
        Self { step: 0, governor }
    }

    fn draw(&mut self, studio: &mut Studio, frame: &PreparedFrame, cancel: &Cancel) -> Result<(), Failure> {
        if cancel.is_cancelled() {
            return Err(Failure::Interrupted);
        }
        let mut camera = studio.camera;
        let angle = (self.step as f32 * ORBIT_DEG_PER_FRAME).to_radians();
        let axis = studio.world.space().up.vector();
        camera.eye = camera.target + glam::Quat::from_axis_angle(axis, angle) * (camera.eye - camera.target);
        self.step += 1;
        let Some(governor) = &mut self.governor else {
            return Ok(studio.renderer.draw_and_wait(frame, &studio.world, &camera, studio.size)?);
        };
        let moving = studio.lod;
        studio.renderer.set_lod(governor.params(&moving))?;
        let started = Instant::now();
        studio.renderer.draw_and_wait(frame, &studio.world, &camera, studio.size)?;
        governor.frame_took(ms_since(started));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of warm-up pictures when they take these times.
    fn pictures(asked: u32, times: &[f64]) -> usize {
        let mut times = times.iter();
        warm_up(asked, || Ok(*times.next().unwrap())).unwrap().len()
    }

    #[test]
    fn warming_up_goes_on_while_pictures_get_faster() {
        assert_eq!(pictures(0, &[]), 0);
        assert_eq!(pictures(1, &[100.0]), 1);
        assert_eq!(pictures(2, &[100.0, 99.0]), 2);
        assert_eq!(pictures(2, &[100.0, 50.0, 20.0, 19.0]), 4);
        let halves: Vec<f64> = (0..20).map(|i| 0.5_f64.powi(i)).collect();
        assert_eq!(pictures(3, &halves), 3 + MOST_EXTRA_WARMUP);
    }
}
