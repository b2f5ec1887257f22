//! `meniscus render`.

use std::sync::Arc;
use std::time::Instant;

use meniscus_core::{Flaw, FrameErrorKind, FrameReport, FrameRequest, FrameSource};
use meniscus_export::{OutputPattern, write_png};
use meniscus_gpu::Timing;
use meniscus_pipeline::{PreparedFrame, Registry};
use meniscus_prefetch::{Plan, PrefetchOptions, Prefetcher};
use serde_json::json;

use crate::args::{Global, RenderArgs};
use crate::failure::Failure;
use crate::picture::{self, Studio};
use crate::report::RenderReport;
use crate::terminal::{Terminal, interrupt};
use crate::trace::{Trace, TracedSource, Track};
use crate::{input, report};

pub fn run(
    args: &RenderArgs,
    global: &Global,
    registry: Registry,
    terminal: &Terminal,
) -> Result<(), Failure> {
    let Some(settings) = picture::settings(&args.picture, &registry)? else { return Ok(()) };
    let pattern = OutputPattern::parse(&args.output)?;
    for (flag, path) in [("--report", &args.report), ("--trace", &args.trace)] {
        path.as_deref().map_or(Ok(()), |path| picture::prepare_path(flag, path))?;
    }
    let trace = Arc::new(Trace::new(args.trace.is_some()));
    let cancel = interrupt();
    let series = Arc::new(input::open(&args.input, &cancel)?);
    let frames = args.wanted.within(series.frame_count())?;
    pattern.check(frames.len())?;
    let mut studio = Studio::open(&series, &args.picture, settings, global, registry, terminal)?;

    if args.report.is_some() && !studio.renderer.gpu().trusts_time_stamps() {
        // Nothing is lost on the software drivers that this is about: they run one pass after the other anyway.
        studio.renderer.set_timing(Timing::Isolated);
    }
    studio.renderer.set_counting(args.report.is_some());
    let preparer = studio.renderer.preparer(&studio.world);
    let threads = global.threads.map_or(PrefetchOptions::default().threads, usize::from);
    let options = PrefetchOptions { threads, request: FrameRequest::default(), ..Default::default() };
    let reader_trace = Arc::clone(&trace);
    let prefetcher = Prefetcher::new(
        Arc::new(TracedSource::new(Arc::clone(&series) as Arc<dyn FrameSource>, Arc::clone(&trace))),
        move |frame| {
            let (begin, index) = (Instant::now(), frame.index);
            let prepared = preparer.prepare(frame);
            reader_trace.on_this_thread("prepare", begin, json!({ "frame": index }));
            prepared
        },
        PreparedFrame::bytes,
        options,
    )?;
    prefetcher.set_plan(Plan::Frames(frames.clone()));

    studio.renderer.set_tracing(args.trace.is_some());
    let mut report = RenderReport::new(&studio, &series);
    let bar = terminal.progress(frames.len() as u64, "frames");
    let mut failures: Vec<String> = Vec::new();
    let mut interrupted = false;
    for &index in &frames {
        if cancel.is_cancelled() {
            interrupted = true;
            break;
        }
        let (begin, stalls) =
            (Instant::now(), if args.trace.is_some() { prefetcher.stats().stalls } else { 0 });
        let asked = Instant::now();
        let taken = prefetcher.take(index);
        if args.trace.is_some() {
            let waited = prefetcher.stats().stalls > stalls;
            let name = if waited { "wait for the frame" } else { "take the frame" };
            trace.span(Track::Drawing, name, asked, json!({ "frame": index, "ready": !waited }));
        }
        match taken {
            Ok(frame) => {
                let frame_report = draw(&mut studio, &frame, &pattern, index, &trace)?;
                trace.span(Track::Frames, "frame", begin, json!({ "frame": index, "time": frame.time }));
                frame_report.flaws.iter().filter(|flaw| !report.flaws.iter().any(|f| f == *flaw)).for_each(
                    |flaw| {
                        bar.suspend(|| terminal.say(format_args!("note: frame {index}: {flaw}")));
                    },
                );
                report.add(frame_report);
            }
            Err(error) if frames.len() == 1 || error.kind == FrameErrorKind::Usage => {
                return Err(error.into());
            }
            Err(error) => {
                let flaw = Flaw::FrameMissing { frame: index, reason: error.to_string() };
                bar.suspend(|| terminal.say(format_args!("note: {flaw}")));
                failures.push(error.to_string());
                report.add(FrameReport {
                    frame: index,
                    flaws: [flaw].into_iter().collect(),
                    ..Default::default()
                });
            }
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    if let Some(path) = &args.report {
        report::write(path, &report)?;
    }
    if let Some(path) = &args.trace {
        // Reads that nobody waits for any more end here, with their spans.
        drop(prefetcher);
        trace.write(path)?;
    }
    if interrupted {
        return Err(Failure::Interrupted);
    }
    match failures.first() {
        Some(first) => {
            Err(Failure::FramesMissing { failed: failures.len(), wanted: frames.len(), first: first.clone() })
        }
        None => {
            let last = pattern.path(frames[frames.len() - 1]);
            terminal.say(format_args!(
                "wrote {}",
                if frames.len() == 1 {
                    last.display().to_string()
                } else {
                    format!("{} to {}", pattern.path(frames[0]).display(), last.display())
                }
            ));
            Ok(())
        }
    }
}

fn draw(
    studio: &mut Studio,
    frame: &PreparedFrame,
    pattern: &OutputPattern,
    index: usize,
    trace: &Trace,
) -> Result<FrameReport, Failure> {
    let begin = Instant::now();
    let picture = studio.renderer.render(frame, &studio.world, &studio.camera, studio.size)?;
    trace.renderer(studio.renderer.take_spans());
    trace.span(Track::Drawing, "draw", begin, json!({ "frame": index, "stages": picture.report.stages }));
    trace.counter("frame bytes", frame.bytes());
    trace.counter("GPU bytes at most", studio.renderer.gpu().memory().peak());
    let begin = Instant::now();
    write_png(&pattern.path(index), studio.size, &picture.pixels, studio.renderer.settings().transparent())?;
    trace.span(Track::Drawing, "encode and write", begin, json!({ "frame": index }));
    Ok(picture.report)
}
