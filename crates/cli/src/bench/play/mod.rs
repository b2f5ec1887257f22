//! `bench --play`: the series as a viewer plays it.

mod apart;
mod jumps;
mod medium;
mod report;
mod table;

use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use meniscus_core::{Cancel, Flaw, Flaws, FrameSource, SetFrame};
use meniscus_gpu::process_cpu_ms;
use meniscus_io::Series;
use meniscus_pipeline::{PreparedFrame, Preparer, Registry, SetStoreStats};
use meniscus_prefetch::{FrameState, Plan, PrefetchError, PrefetchOptions, PrefetchStats, Prefetcher};
use serde_json::json;

use self::apart::Apart;
use self::jumps::JumpReport;
use self::medium::{SlowSource, Speed};
use self::report::{ApartReport, FrameEntry, MemoryReport, PlayFigures, PlayReport};
use super::spread::Spread;
use super::{Orbit, ms_since, setup, warm_up};
use crate::args::{BenchArgs, Global};
use crate::failure::Failure;
use crate::input;
use crate::picture::{self, Studio};
use crate::terminal::{Terminal, interrupt, print};
use crate::trace::{Trace, TracedSource, Track};
use crate::values::MediumSpeed;

/// How long the files are read to see how fast the medium is.
const MEDIUM_TIME: Duration = Duration::from_secs(3);

pub fn run(
    args: &BenchArgs,
    global: &Global,
    registry: Registry,
    terminal: &Terminal,
) -> Result<(), Failure> {
    let Some(settings) = picture::settings(&args.picture, &registry)? else { return Ok(()) };
    let cancel = interrupt();
    let series = Arc::new(input::open(&args.input, false, &cancel)?);
    super::check_frame(args.frame, &series)?;
    let trace = Arc::new(Trace::new(args.trace.is_some()));
    let mut studio = Studio::open(&series, &args.picture, settings, global, registry, terminal)?;
    let camera = studio.camera;
    studio.meter(&*series, &[(args.frame, camera)], &cancel, terminal)?;
    let preparer = studio.renderer.preparer(&studio.world);

    let order = order(args, series.frame_count());
    let bar = terminal.progress(order.len() as u64, "frames, one after the other");
    warm(args, &series, &preparer, &mut studio, &cancel)?;
    let mut orbit = Orbit::new(&args.picture);
    let source: &dyn FrameSource = &*series;
    let apart = Apart::measure(source, &preparer, &order, &mut studio, &mut orbit, &cancel, || bar.inc(1))?;
    bar.finish_and_clear();
    let apart = Arc::new(apart);

    let files: Vec<_> = order.iter().flat_map(|&frame| series.files(frame)).collect();
    if args.play.cold {
        medium::forget(&files);
    }
    let emulated = args.play.medium.map(|speed| {
        let speed = match speed {
            MediumSpeed::Rate(bytes_per_second) => Speed::Rate(bytes_per_second),
            MediumSpeed::DrawTimes(times) => {
                let time = Duration::from_secs_f64(times * apart.mean().draw_ms / 1e3);
                Speed::FrameTime(Mutex::new(time))
            }
        };
        let (costs, speed) = (Arc::clone(&apart), Arc::new(speed));
        let source = Arc::clone(&series) as Arc<dyn FrameSource>;
        let file_bytes = move |frame| costs.cost(frame).file_bytes;
        (Arc::new(SlowSource::new(source, Arc::clone(&speed), file_bytes)), speed)
    });
    let source: Arc<dyn FrameSource> = match &emulated {
        Some((slow, _)) => Arc::clone(slow) as _,
        None => Arc::clone(&series) as _,
    };
    let source = Arc::new(TracedSource::new(source, Arc::clone(&trace)));
    let speed = emulated.as_ref().map(|(_, speed)| &**speed);
    let played = Player { args, global, trace: &trace, terminal, cancel: &cancel, speed }.play(
        &series,
        source,
        preparer,
        &mut studio,
        order.len(),
    )?;

    let (rate, medium) = match &emulated {
        Some((slow, _)) => (slow.rate(), "emulated"),
        None if medium::forget(&files) => (medium::rate_of(&files, MEDIUM_TIME), "files, not cached"),
        None => (medium::rate_of(&files, MEDIUM_TIME), "files, cached"),
    };
    let report = report(args, &studio, &series, &apart, &played, rate.map(|rate| (rate, medium)));
    if args.json {
        print(serde_json::to_string_pretty(&report).unwrap_or_default());
    } else {
        table::print_table(&report);
    }
    args.trace.as_ref().map_or(Ok(()), |path| trace.write(path))
}

/// The frames of a round in the order shown.
fn order(args: &BenchArgs, count: usize) -> Vec<usize> {
    let next = |frame: &usize| following(args, *frame, count);
    let mut seen = vec![false; count];
    std::iter::successors(Some(args.frame), next)
        .take_while(|&frame| !std::mem::replace(&mut seen[frame], true))
        .collect()
}

/// The frame after `frame` of `count`.
fn following(args: &BenchArgs, frame: usize, count: usize) -> Option<usize> {
    let step = args.play.step;
    if args.play.rounds > 1 {
        return Some((frame + step.rem_euclid(count as isize) as usize) % count);
    }
    frame.checked_add_signed(step).filter(|&next| next < count)
}

/// Compiles and allocates what the first pictures need.
fn warm(
    args: &BenchArgs,
    series: &Series,
    preparer: &Preparer,
    studio: &mut Studio,
    cancel: &Cancel,
) -> Result<(), Failure> {
    // What cannot be read is said when it is played.
    let Ok(frame) = series.read(args.frame, studio.world.request(), cancel) else { return Ok(()) };
    let frame = preparer.prepare(frame);
    let mut orbit = Orbit::new(&args.picture);
    warm_up(args.warmup, || {
        let started = Instant::now();
        orbit.draw(studio, &frame, cancel)?;
        Ok(ms_since(started))
    })?;
    Ok(())
}

/// What playing needs besides the frames.
struct Player<'a> {
    args: &'a BenchArgs,
    global: &'a Global,
    trace: &'a Arc<Trace>,
    terminal: &'a Terminal,
    cancel: &'a Cancel,
    /// Of an emulated medium.
    speed: Option<&'a Speed>,
}

/// What was seen while playing.
#[derive(Default)]
struct Played {
    /// The frames drawn, in order.
    pictures: Vec<usize>,
    missing: u64,
    start_ms: f64,
    wall_ms: f64,
    picture_ms: Vec<f64>,
    draw_ms: Vec<f64>,
    stalls: u64,
    stalled_ms: f64,
    cpu_ms: f64,
    readers: usize,
    added: usize,
    stats: PrefetchStats,
    frames: Vec<FrameEntry>,
    jumps: Option<JumpReport>,
    resident_before: Option<u64>,
    resident_peak: Option<u64>,
    uploads: SetStoreStats,
    flaws: Flaws,
}

impl Played {
    /// Adds what the prefetcher has seen since the process had taken `cpu_ms` and the series had `known` frames.
    fn finish(mut self, prefetcher: &Prefetcher<Arc<PreparedFrame>>, cpu_ms: f64, known: usize) -> Self {
        self.cpu_ms = process_cpu_ms() - cpu_ms;
        self.stats = prefetcher.stats();
        let records = prefetcher.records();
        self.added = records.len() - known.min(records.len());
        self.frames = records.iter().enumerate().map(|(i, record)| FrameEntry::new(i, record)).collect();
        self
    }
}

impl Player<'_> {
    fn play(
        &self,
        series: &Arc<Series>,
        source: Arc<dyn FrameSource>,
        preparer: Preparer,
        studio: &mut Studio,
        round: usize,
    ) -> Result<Played, Failure> {
        let play = &self.args.play;
        let mut options = PrefetchOptions::default();
        options.threads = self.global.threads.map_or(options.threads, usize::from);
        options.request = studio.world.request().clone();
        options.memory = play.memory.map_or(options.memory, |size| size.0);
        let mut played =
            Played { readers: options.threads, resident_before: resident_bytes(), ..Played::default() };
        let known = series.frame_count();
        let _follow = play.follow.then(|| series.follow());
        let reader_trace = Arc::clone(self.trace);
        let prepare = move |frame: SetFrame| {
            let (begin, index) = (Instant::now(), frame.index);
            let prepared = Arc::new(preparer.prepare(frame));
            reader_trace.on_this_thread("prepare", begin, json!({ "frame": index }));
            prepared
        };
        let (asked, cpu) = (Instant::now(), process_cpu_ms());
        options.coarse_share = play.jumps.map(|_| jumps::COARSE_SHARE);
        let prefetcher =
            Prefetcher::new(source, prepare, |frame: &Arc<PreparedFrame>| frame.bytes(), options)?;
        if let Some(count) = play.jumps {
            let mut orbit = Orbit::new(&self.args.picture);
            let report = jumps::run(&prefetcher, studio, &mut orbit, count, self.cancel)?;
            played.jumps = Some(report);
            played.resident_peak = resident_bytes();
            played.wall_ms = ms_since(asked);
            return Ok(played.finish(&prefetcher, cpu, known));
        }
        let looping = play.rounds > 1;
        let gpu_memory = play.gpu_memory.map_or_else(|| gpu_memory(studio), |bytes| bytes.0);
        studio.renderer.set_gpu_memory(gpu_memory);
        let uploads = (gpu_memory > 0).then(|| studio.renderer.upload_ahead()).transpose();
        let uploads = uploads.map_err(PrefetchError::from)?;
        prefetcher.set_plan(Plan::Play { playhead: self.args.frame, step: play.step, looping });

        let wanted = round as u64 * u64::from(play.rounds);
        self.terminal.say(format_args!("playing {wanted} pictures of {} frames", series.frame_count()));
        let bar = self.terminal.progress(wanted, "pictures");
        let mut orbit = Orbit::new(&self.args.picture);
        self.wait_for_start(&prefetcher, played.readers);
        let mut clock = Clock::new(play.fps);
        // A series that grows is longer than was known.
        let goes_on = |shown: u64| shown < wanted || (play.follow && !looping);
        let mut next = Some(self.args.frame).filter(|_| goes_on(0));
        let mut began = asked;
        while let Some(index) = next {
            // Who stops playing wants to know how it was so far.
            if self.cancel.is_cancelled() {
                break;
            }
            clock.wait();
            let since = Instant::now();
            let ready = prefetcher.take_ready(index);
            let stalled = ready.is_none();
            let taken = ready.unwrap_or_else(|| prefetcher.take(index));
            let name = if stalled { "wait for the frame" } else { "take the frame" };
            self.trace.span(Track::Drawing, name, since, json!({ "frame": index, "ready": !stalled }));
            let shown = played.pictures.len() as u64 + played.missing;
            let first = shown == 0;
            if first {
                began = Instant::now();
                played.start_ms = ms_since(asked);
                clock = Clock::new(play.fps);
            } else if stalled {
                played.stalls += 1;
                played.stalled_ms += ms_since(since);
                clock.late();
            }
            let drawing = Instant::now();
            next = following(self.args, index, prefetcher.frame_count()).filter(|_| goes_on(shown + 1));
            if let (Some(uploads), Some(next)) = (&uploads, next)
                && let Some(coming) = prefetcher.peek(next)
            {
                uploads.begin(coming);
            }
            match taken {
                Ok(frame) => {
                    match orbit.draw(studio, &frame, self.cancel) {
                        Err(Failure::Interrupted) => break,
                        drawn => drawn?,
                    }
                    played.pictures.push(index);
                    played.draw_ms.push(ms_since(drawing));
                    self.pace_medium(&played.draw_ms);
                    self.trace.span(Track::Drawing, "draw", drawing, json!({ "frame": index }));
                    if looping {
                        prefetcher.give_back(index, frame);
                    }
                }
                Err(error) => {
                    played.missing += 1;
                    let flaw = Flaw::FrameMissing { frame: index, reason: error.to_string() };
                    // Once, not every round.
                    if !played.flaws.iter().any(|said| *said == flaw) {
                        bar.suspend(|| self.terminal.say(format_args!("note: {flaw}")));
                        played.flaws.add(flaw);
                    }
                }
            }
            if !first {
                played.picture_ms.push(ms_since(since));
            }
            self.trace.span(Track::Frames, "frame", since, json!({ "frame": index }));
            self.trace.counter("bytes of frames", prefetcher.stats().held_bytes);
            played.resident_peak = played.resident_peak.max(resident_bytes());
            bar.inc(1);
        }
        bar.finish_and_clear();
        played.wall_ms = ms_since(began);
        played.uploads = studio.renderer.uploads();
        Ok(played.finish(&prefetcher, cpu, known))
    }
}

impl Player<'_> {
    /// Waits until playing can begin: as many frames are there as are read at once, or as can be.
    fn wait_for_start(&self, prefetcher: &Prefetcher<Arc<PreparedFrame>>, readers: usize) {
        loop {
            let states = prefetcher.status();
            let count = |is: fn(&FrameState) -> bool| states.iter().filter(|state| is(state)).count();
            let ready = count(|state| matches!(state, FrameState::Ready { .. }));
            let reading = count(|state| *state == FrameState::Reading);
            let known = !matches!(states[self.args.frame], FrameState::Requested | FrameState::Reading);
            if known && (ready >= readers || reading == 0) || self.cancel.is_cancelled() {
                return;
            }
            // Not so often that asking costs time that counts.
            thread::sleep(Duration::from_millis(10));
        }
    }

    /// An emulated medium that is as fast as drawing follows how long that takes at present, over a few pictures.
    fn pace_medium(&self, draw_ms: &[f64]) {
        if let (Some(MediumSpeed::DrawTimes(times)), Some(speed)) = (self.args.play.medium, self.speed) {
            let recent = &draw_ms[draw_ms.len().saturating_sub(RECENT_PICTURES)..];
            let mean_ms = recent.iter().sum::<f64>() / recent.len() as f64;
            speed.set_frame_time(Duration::from_secs_f64(times * mean_ms / 1e3));
        }
    }
}

/// What particles may take of the GPU's memory where nothing is said. Software draws from the memory that frames are read into:
/// uploading ahead would only take the cores from drawing, and what is kept from reading ahead.
fn gpu_memory(studio: &Studio) -> u64 {
    /// Less than what graphics cards have had for ten years, and some fifty frames of a million particles.
    const OF_GPUS: u64 = 1_000_000_000;
    if studio.renderer.gpu().summary().is_software() { 0 } else { OF_GPUS }
}

/// Pictures over which the time of drawing is averaged for a medium that follows it: of fewer, one that another program delayed
/// would make the medium slow for pictures that are not.
const RECENT_PICTURES: usize = 16;

/// When pictures are due.
struct Clock {
    interval: Option<Duration>,
    next: Instant,
}

impl Clock {
    fn new(fps: Option<f64>) -> Self {
        let interval = fps.map(|fps| Duration::from_secs_f64(1.0 / fps));
        Self { interval, next: Instant::now() + interval.unwrap_or_default() }
    }

    /// Sleeps until the next picture is due.
    fn wait(&mut self) {
        if let Some(interval) = self.interval {
            thread::sleep(self.next.saturating_duration_since(Instant::now()));
            self.next += interval;
        }
    }

    /// The picture that is due comes now: those behind it are not hurried.
    fn late(&mut self) {
        self.next = Instant::now() + self.interval.unwrap_or_default();
    }
}

fn report(
    args: &BenchArgs,
    studio: &Studio,
    series: &Series,
    apart: &Apart,
    played: &Played,
    medium: Option<(f64, &'static str)>,
) -> PlayReport {
    let summary = studio.renderer.gpu().summary().clone();
    let spread = |figure: fn(&apart::FrameCost) -> f64| Spread::of(&apart.each(figure));
    let reads =
        played.frames.iter().map(|frame| f64::from(frame.reads) * apart.cost(frame.frame).read_cpu_ms);
    let draws = played.pictures.iter().map(|&frame| apart.cost(frame).draw_cpu_ms);
    let mut flaws = studio.flaws.clone();
    flaws.merge(&played.flaws);
    let stats = &played.stats;
    PlayReport {
        command: std::env::args_os().map(|arg| arg.to_string_lossy().into_owned()).collect(),
        unix_time_s: SystemTime::UNIX_EPOCH.elapsed().map_or(0, |age| age.as_secs()),
        setup: setup(studio, series),
        input: args.input.input.clone(),
        adapter: summary.name,
        driver: summary.driver,
        size: studio.size,
        threads: rayon::current_num_threads(),
        readers: played.readers,
        apart: ApartReport {
            read_ms: spread(|cost| cost.read_ms),
            read_cpu_ms: spread(|cost| cost.read_cpu_ms),
            draw_ms: spread(|cost| cost.draw_ms),
            draw_cpu_ms: spread(|cost| cost.draw_cpu_ms),
        },
        play: PlayFigures {
            pictures: played.pictures.len() as u64,
            missing: played.missing,
            start_ms: played.start_ms,
            wall_ms: played.wall_ms,
            picture_ms: Spread::of(&played.picture_ms),
            draw_ms: Spread::of(&played.draw_ms),
            stalls: played.stalls,
            stall_share: played.stalls as f64 / (played.pictures.len().max(1) as f64),
            stalled_ms: played.stalled_ms,
            cpu_ms: played.cpu_ms,
            cpu_apart_ms: reads.sum::<f64>() + draws.sum::<f64>(),
            frames_read: stats.frames_read,
            reads_cancelled: stats.reads_cancelled,
            reads_failed: stats.frames_failed,
            frames_changed: stats.frames_changed,
            frames_added: played.added,
            uploads: played.uploads.uploads,
            uploads_ahead: played.uploads.uploads_ahead,
            found_on_gpu: played.uploads.found,
            delivered_mb_per_s: stats.file_bytes_per_second().map(|rate| rate / 1e6),
            medium_mb_per_s: medium.map(|(rate, _)| rate / 1e6),
            medium: medium.map_or("unknown", |(_, name)| name),
        },
        jumps: played.jumps.clone(),
        memory: MemoryReport {
            budget_bytes: stats.budget_bytes,
            peak_held_bytes: stats.peak_held_bytes,
            peak_over_budget_bytes: stats.peak_over_budget_bytes,
            resident_before_bytes: played.resident_before,
            resident_peak_bytes: played.resident_peak,
            gpu_budget_bytes: played.uploads.limit_bytes,
            gpu_peak_particle_bytes: played.uploads.peak_bytes,
            gpu_peak_bytes: studio.renderer.gpu().memory().peak(),
        },
        frames: played.frames.clone(),
        flaws,
    }
}

/// Memory of the process that is in RAM, without pages of mapped files, which the system takes back when it needs them; `None`
/// where it does not tell.
fn resident_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("RssAnon:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib * 1024)
}
