//! `meniscus render`.

use std::sync::Arc;

use meniscus_core::{Flaw, FrameErrorKind, FrameReport, FrameRequest, FrameSource};
use meniscus_export::{OutputPattern, write_png};
use meniscus_gpu::Timing;
use meniscus_pipeline::{PreparedFrame, Registry};
use meniscus_prefetch::{Plan, PrefetchOptions, Prefetcher};

use crate::args::{Global, RenderArgs};
use crate::failure::Failure;
use crate::picture::{self, Studio};
use crate::report::RenderReport;
use crate::terminal::{Terminal, interrupt};
use crate::{input, report};

pub fn run(
    args: &RenderArgs,
    global: &Global,
    registry: Registry,
    terminal: &Terminal,
) -> Result<(), Failure> {
    let Some(settings) = picture::settings(&args.picture, &registry)? else { return Ok(()) };
    let pattern = OutputPattern::parse(&args.output)?;
    args.report.as_deref().map_or(Ok(()), picture::prepare_report_path)?;
    let cancel = interrupt();
    let series = Arc::new(input::open(&args.input, &cancel)?);
    let frames = wanted_frames(args, series.frame_count())?;
    pattern.check(frames.len())?;
    let mut studio = Studio::open(&series, &args.picture, settings, global, registry, terminal)?;

    if args.report.is_some() && !studio.renderer.gpu().trusts_time_stamps() {
        // Nothing is lost on the software drivers that this is about: they run one pass after the other anyway.
        studio.renderer.set_timing(Timing::Isolated);
    }
    let preparer = studio.renderer.preparer(&studio.world);
    let threads = global.threads.map_or(PrefetchOptions::default().threads, usize::from);
    let options = PrefetchOptions { threads, request: FrameRequest::default(), ..Default::default() };
    let prefetcher = Prefetcher::new(
        Arc::clone(&series) as Arc<dyn FrameSource>,
        move |frame| preparer.prepare(frame),
        PreparedFrame::bytes,
        options,
    )?;
    prefetcher.set_plan(Plan::Frames(frames.clone()));

    let mut report = RenderReport::new(&studio, &series);
    let bar = terminal.progress(frames.len() as u64, "frames");
    let mut failures: Vec<String> = Vec::new();
    let mut interrupted = false;
    for &index in &frames {
        if cancel.is_cancelled() {
            interrupted = true;
            break;
        }
        match prefetcher.take(index) {
            Ok(frame) => {
                let frame_report = draw(&mut studio, &frame, &pattern, index)?;
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
) -> Result<FrameReport, Failure> {
    let picture = studio.renderer.render(frame, &studio.world, &studio.camera, studio.size)?;
    write_png(&pattern.path(index), studio.size, &picture.pixels, studio.renderer.settings().transparent())?;
    Ok(picture.report)
}

fn wanted_frames(args: &RenderArgs, count: usize) -> Result<Vec<usize>, Failure> {
    match (args.frame, args.frames) {
        (Some(frame), _) if frame >= count => {
            Err(Failure::Usage(format!("--frame {frame}: the series has frames 0 to {}", count.max(1) - 1)))
        }
        (Some(frame), _) => Ok(vec![frame]),
        (None, Some(range)) => Ok(range.within(count).map_err(Failure::Usage)?.collect()),
        (None, None) => Ok((0..count).collect()),
    }
}
