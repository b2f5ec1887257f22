//! `meniscus render`.

mod captions;
mod lens;
mod look;
mod note;
mod output;
mod shots;

use std::sync::Arc;
use std::time::Instant;

use indicatif::ProgressBar;
use meniscus_core::{
    Camera, Channel, Flaw, FrameError, FrameErrorKind, FrameReport, FrameSource, PixelDepth, Pixels,
};
use meniscus_export::ExportError;
use meniscus_gpu::Timing;
use meniscus_io::Series;
use meniscus_overlay::Overlay;
use meniscus_pipeline::{Exposure, Picture, PreparedFrame, Registry};
use meniscus_prefetch::{Plan, PrefetchOptions, Prefetcher};
use meniscus_scene::Lens;
use meniscus_timeline::Sample;
use serde_json::json;

use self::captions::Captions;
use self::look::Look;
use self::note::Maker;
use self::output::Output;
pub use self::output::keep_film;
use self::shots::{Part, Shot, Shots};
use crate::args::{Global, RenderArgs};
use crate::failure::Failure;
use crate::picture::{self, Studio};
use crate::report::RenderReport;
use crate::terminal::{Terminal, interrupt};
use crate::trace::{Trace, TracedSource, Track};
use crate::values::Detail;
use crate::{input, report};

pub fn run(
    args: &RenderArgs,
    global: &Global,
    registry: Registry,
    terminal: &Terminal,
) -> Result<(), Failure> {
    let Some(mut settings) = picture::settings(&args.picture, &registry)? else { return Ok(()) };
    if let Detail::Rate(_) = args.picture.lod {
        return Err(Failure::Usage(format!(
            "--lod {}: pictures of `render` do not depend on how fast they are drawn; give a fraction or auto",
            args.picture.lod
        )));
    }
    settings.post.transparent |= args.transparent;
    let mut output = Output::parse(args, settings.transparent())?;
    for (flag, path) in [("--report", &args.report), ("--trace", &args.trace)] {
        path.as_deref().map_or(Ok(()), |path| picture::prepare_path(flag, path))?;
    }
    let trace = Arc::new(Trace::new(args.trace.is_some()));
    let cancel = interrupt();
    let series = Arc::new(input::open(&args.input, false, &cancel)?);
    let frames = args.wanted.within(series.frame_count())?;
    let shots = Shots::plan(args, &series, &frames, output.is_film(), &cancel)?;
    let film_choice = output.open(args, &shots)?;
    let mut studio = Studio::open(&series, &args.picture, settings, global, registry, terminal)?;
    let choices: Vec<_> = shots.choices.iter().cloned().chain(film_choice).collect();
    terminal.choices(&choices);
    let mut flaws = shots.flaws.clone();
    let is_smooth = args.exposure.samples().max(args.supersample) > 1;
    if studio.renderer.settings().post.anti_aliasing && !is_smooth && output.depth() != PixelDepth::Display8 {
        flaws.add(Flaw::EdgesNotSmoothed);
    }
    terminal.flaws(&flaws);
    studio.choices.extend(choices);
    studio.flaws.merge(&flaws);

    if args.report.is_some() && !studio.renderer.gpu().trusts_time_stamps() {
        // Nothing is lost on the software drivers that this is about: they run one pass after the other anyway.
        studio.renderer.set_timing(Timing::Isolated);
    }
    studio.renderer.set_counting(args.report.is_some());
    studio.renderer.set_tracing(args.trace.is_some());
    let look =
        Look::open(studio.camera, args.camera_path.as_deref(), &studio.world, shots.rate, shots.range)?;
    let probes = shots.probes.iter().map(|&moment| {
        let (Sample::Frame(frame) | Sample::Between { before: frame, .. }) = moment.sample;
        Ok::<_, Failure>((frame, look.at(&Part::whole(moment))?))
    });
    studio.meter(&*series, &probes.collect::<Result<Vec<_>, _>>()?, &cancel, terminal)?;
    let maker = Maker::new(&studio, args, output.depth());
    let captions = Captions::plan(args, &studio.world, &shots)?;
    let works = works(args, &series, &shots, &look, &captions, &maker, &mut output)?;
    let prefetcher = prefetcher(args, &studio, global, &shots, &works, &trace)?;
    let mut session = Session {
        args,
        report: RenderReport::new(&studio, &series),
        studio,
        output,
        trace: &trace,
        terminal,
        bar: terminal.progress(works.len() as u64, "pictures"),
        last: None,
        held: None,
        failures: Vec::new(),
    };
    let mut stopped = None;
    for work in &works {
        if cancel.is_cancelled() {
            stopped = Some(Stop::Interrupted);
            break;
        }
        if let Err(stop) = session.picture(work, &prefetcher, works.len() == 1) {
            stopped = Some(stop);
            break;
        }
        session.bar.inc(1);
    }
    session.bar.finish_and_clear();
    let Session { report, output, failures, .. } = session;
    let ended = match stopped {
        None => output.finish().map_err(Failure::Output),
        Some(Stop::Failed(failure)) => return Err(failure),
        Some(Stop::Unwritable(error)) if shots.shots.len() == 1 => Err(Failure::Output(error)),
        Some(Stop::Interrupted) => Err(Failure::InterruptedOutput { kept: output.keep(&shots) }),
        Some(Stop::Unwritable(error)) => Err(Failure::Unfinished { error, kept: output.keep(&shots) }),
    };
    if let Some(path) = &args.report {
        report::write(path, &report)?;
    }
    if let Some(path) = &args.trace {
        // Reads that nobody waits for any more end here, with their spans.
        drop(prefetcher);
        trace.write(path)?;
    }
    let written = ended?;
    if let Some(first) = failures.first() {
        let (failed, wanted) = (failures.len(), works.len());
        return Err(Failure::FramesMissing { failed, wanted, first: first.clone() });
    }
    terminal.say(format_args!("wrote {written}"));
    Ok(())
}

/// A picture to be made.
struct Work<'a> {
    shot: &'a Shot,
    /// One per part.
    cameras: Vec<Camera>,
    overlay: Overlay,
    note: String,
    /// Whether it is the one before once more.
    is_repeated: bool,
}

/// What is left to do: with `--resume`, what is not there.
fn works<'a>(
    args: &RenderArgs,
    series: &Series,
    shots: &'a Shots,
    look: &Look,
    captions: &Captions,
    maker: &Maker,
    output: &mut Output,
) -> Result<Vec<Work<'a>>, Failure> {
    let mut works: Vec<Work<'a>> = Vec::new();
    let (size, exposure) = (args.picture.size.0, &args.exposure);
    let lens = Lens {
        aperture_world: exposure.aperture.unwrap_or(0.0) as f32,
        focus_world: exposure.focus.map(|distance| distance as f32),
    };
    for shot in &shots.shots {
        let number = shot.moment.number;
        let camera = |part: &Part| {
            let camera = look.at(part)?;
            lens::check(&lens, &camera)?;
            Ok::<_, Failure>(part.sample.map_or(camera, |sample| lens.camera(&camera, sample, size)))
        };
        let cameras = shot.parts.iter().map(camera).collect::<Result<Vec<_>, _>>()?;
        let samples = || shot.parts.iter().map(|part| part.moment.sample);
        let parts: Vec<_> = samples().zip(cameras.iter().copied()).collect();
        let camera = look.at(&Part::whole(shot.moment))?;
        let overlay = captions.of(&shot.moment, &camera, size);
        let note = maker.note(&parts, &overlay);
        if args.time.resume {
            let files: Vec<_> = samples().flat_map(|sample| files(series, &sample)).collect();
            if output.has(number, size, &note, &files) {
                output.skip(number);
                continue;
            }
        }
        let is_repeated = works.last().is_some_and(|last| last.note == note);
        works.push(Work { shot, cameras, overlay, note, is_repeated });
    }
    Ok(works)
}

/// The files that a picture is made of.
fn files(series: &Series, sample: &Sample) -> Vec<std::path::PathBuf> {
    match *sample {
        Sample::Frame(frame) => series.files(frame).to_vec(),
        Sample::Between { before, after, .. } => [series.files(before), series.files(after)].concat(),
    }
}

/// Reads ahead what `works` need.
fn prefetcher(
    args: &RenderArgs,
    studio: &Studio,
    global: &Global,
    shots: &Shots,
    works: &[Work<'_>],
    trace: &Arc<Trace>,
) -> Result<Prefetcher<PreparedFrame>, Failure> {
    let preparer = studio.renderer.preparer(&studio.world);
    let mut options = PrefetchOptions::default();
    options.threads = global.threads.map_or(options.threads, usize::from);
    options.request = studio.world.request().clone();
    options.memory = args.memory.map_or(options.memory, |size| size.0);
    let reader_trace = Arc::clone(trace);
    let prefetcher = Prefetcher::new(
        Arc::new(TracedSource::new(Arc::clone(&shots.source), Arc::clone(trace))),
        move |frame| {
            let (begin, index) = (Instant::now(), frame.index);
            let prepared = preparer.prepare(frame);
            reader_trace.on_this_thread("prepare", begin, json!({ "frame": index }));
            prepared
        },
        PreparedFrame::bytes,
        options,
    )?;
    let wanted = works.iter().filter(|work| !work.is_repeated);
    let wanted = wanted.flat_map(|work| work.shot.parts.iter().map(|part| part.index));
    let mut wanted: Vec<usize> = wanted.collect();
    wanted.dedup();
    prefetcher.set_plan(Plan::Frames(wanted));
    Ok(prefetcher)
}

/// Why no more pictures are made.
enum Stop {
    Interrupted,
    /// The output takes no more.
    Unwritable(ExportError),
    Failed(Failure),
}

impl<E: Into<Failure>> From<E> for Stop {
    fn from(error: E) -> Self {
        Self::Failed(error.into())
    }
}

/// A picture that was drawn, and what it says about itself.
struct Drawn {
    pixels: Pixels,
    channels: Vec<Channel>,
    report: FrameReport,
}

/// A run on its way.
struct Session<'a> {
    args: &'a RenderArgs,
    studio: Studio,
    output: Output,
    report: RenderReport,
    trace: &'a Trace,
    terminal: &'a Terminal,
    bar: ProgressBar,
    /// The picture before.
    last: Option<Drawn>,
    /// The frame drawn last and its index in [`Shots::source`]: slow films show it again, from elsewhere.
    held: Option<(usize, PreparedFrame)>,
    failures: Vec<String>,
}

impl Session<'_> {
    /// Makes one picture; with `is_only`, a frame that cannot be read is the end.
    fn picture(
        &mut self,
        work: &Work<'_>,
        prefetcher: &Prefetcher<PreparedFrame>,
        is_only: bool,
    ) -> Result<(), Stop> {
        let (number, time) = (work.shot.moment.number, work.shot.moment.time);
        if work.is_repeated {
            if let Some(Drawn { report, .. }) = &self.last {
                let report = FrameReport { frame: number, time, ..report.clone() };
                self.report.add(report);
                return self.write(work);
            }
            return self.output.miss().map_err(Stop::Unwritable);
        }
        self.last = None;
        let begin = Instant::now();
        match self.take_and_draw(work, prefetcher)? {
            Ok(drawn) => {
                let report = drawn.report.clone();
                self.last = Some(drawn);
                self.write(work)?;
                self.trace.span(Track::Frames, "frame", begin, json!({ "frame": number, "time": time }));
                let known = &self.report.flaws;
                for flaw in report.flaws.iter().filter(|flaw| !known.iter().any(|f| f == *flaw)) {
                    self.bar.suspend(|| self.terminal.say(format_args!("note: frame {number}: {flaw}")));
                }
                self.report.add(report);
                Ok(())
            }
            Err(error) if is_only || error.kind == FrameErrorKind::Usage => Err(error.into()),
            Err(error) => {
                let flaw = Flaw::FrameMissing { frame: number, reason: error.to_string() };
                self.bar.suspend(|| self.terminal.say(format_args!("note: {flaw}")));
                self.failures.push(error.to_string());
                self.report.add(FrameReport {
                    frame: number,
                    flaws: [flaw].into_iter().collect(),
                    ..Default::default()
                });
                self.output.miss().map_err(Stop::Unwritable)
            }
        }
    }

    /// The pixels of a picture: of its only part, or the mean of all; or why one of its frames cannot be read.
    fn take_and_draw(
        &mut self,
        work: &Work<'_>,
        prefetcher: &Prefetcher<PreparedFrame>,
    ) -> Result<Result<Drawn, FrameError>, Failure> {
        let (number, time) = (work.shot.moment.number, work.shot.moment.time);
        let mut exposure = Exposure::default();
        let mut channels = Vec::new();
        let mut picture: Option<Picture> = None;
        let is_mean = work.shot.parts.len() > 1;
        for (part, camera) in std::iter::zip(&work.shot.parts, &work.cameras) {
            let mut frame = match self.take(part, prefetcher) {
                Ok(frame) => frame,
                Err(error) => return Ok(Err(error)),
            };
            let mut drawn = self.draw(&frame, number, camera)?;
            if !self.args.layers.is_empty() {
                let (renderer, world) = (&self.studio.renderer, &self.studio.world);
                channels = renderer.layers(&self.args.layers, &frame, world, camera)?;
            }
            // What reading it took is told once.
            frame.read = None;
            self.held = Some((part.index, frame));
            if is_mean {
                self.studio.renderer.expose(&mut exposure)?;
            }
            if let Some(before) = &picture {
                drawn.report.add(&before.report);
            }
            picture = Some(drawn);
        }
        let Picture { mut pixels, report } = picture.expect("every picture has a part");
        if is_mean {
            pixels = self.studio.renderer.fix(&exposure)?;
        }
        let (size, factor) = (self.studio.size, self.args.supersample);
        let mut pixels = self.studio.renderer.develop(pixels, self.output.depth(), size, factor)?;
        work.overlay.draw(&mut pixels, size);
        // A frame of a film is known by the picture's number and time.
        let time = time.or(report.time);
        Ok(Ok(Drawn { pixels, channels, report: FrameReport { frame: number, time, ..report } }))
    }

    fn take(
        &mut self,
        part: &Part,
        prefetcher: &Prefetcher<PreparedFrame>,
    ) -> Result<PreparedFrame, FrameError> {
        let is_traced = self.args.trace.is_some();
        let stalls = if is_traced { prefetcher.stats().stalls } else { 0 };
        let asked = Instant::now();
        let taken = match self.held.take() {
            Some((of, frame)) if of == part.index => Ok(frame),
            // The one before goes first: there may be room for one only.
            before => {
                drop(before);
                prefetcher.take(part.index)
            }
        };
        if is_traced {
            let waited = prefetcher.stats().stalls > stalls;
            let name = if waited { "wait for the frame" } else { "take the frame" };
            let frame = part.moment.number;
            self.trace.span(Track::Drawing, name, asked, json!({ "frame": frame, "ready": !waited }));
        }
        taken
    }

    fn draw(&mut self, frame: &PreparedFrame, number: usize, camera: &Camera) -> Result<Picture, Failure> {
        let begin = Instant::now();
        let size = self.studio.size.map(|side| side * self.args.supersample);
        let (world, renderer) = (&self.studio.world, &mut self.studio.renderer);
        let mut picture = renderer.render(frame, world, camera, size)?;
        if let Some(view) = self.args.show {
            renderer.paint_lod(&mut picture, view, frame, world, camera)?;
        }
        self.trace.renderer(renderer.take_spans());
        let stages = &picture.report.stages;
        self.trace.span(Track::Drawing, "draw", begin, json!({ "frame": number, "stages": stages }));
        self.trace.counter("frame bytes", frame.bytes());
        self.trace.counter("GPU bytes at most", renderer.gpu().memory().peak());
        Ok(picture)
    }

    /// Writes the last picture that was drawn.
    fn write(&mut self, work: &Work<'_>) -> Result<(), Stop> {
        let Some(Drawn { pixels, channels, .. }) = &self.last else { return Ok(()) };
        let begin = Instant::now();
        let number = work.shot.moment.number;
        let with_alpha = self.studio.renderer.settings().transparent();
        self.output
            .push(number, self.studio.size, (pixels, channels), with_alpha, &work.note)
            .map_err(Stop::Unwritable)?;
        self.trace.span(Track::Drawing, "encode and write", begin, json!({ "frame": number }));
        Ok(())
    }
}
