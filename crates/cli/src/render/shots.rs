//! Which moments are shown, and where their particles come from.

use std::sync::Arc;

use meniscus_core::{Cancel, Choice, Flaw, Flaws, FrameSource};
use meniscus_export::FrameRate;
use meniscus_io::Series;
use meniscus_timeline::{Moment, Resampled, Sampling, Timeline, usual_step};

use crate::args::RenderArgs;
use crate::failure::Failure;

/// The pictures that are wanted.
pub struct Shots {
    /// Delivers the particles.
    pub source: Arc<dyn FrameSource>,
    /// In the order in which they are drawn.
    pub shots: Vec<Shot>,
    /// Pictures per second.
    pub rate: FrameRate,
    /// Numbers of the first picture and of the last, those of other shards included.
    pub range: [usize; 2],
    /// What was chosen.
    pub choices: Vec<Choice>,
    /// What is not as asked.
    pub flaws: Flaws,
}

/// One picture.
#[derive(Clone, Copy, Debug)]
pub struct Shot {
    /// What it shows.
    pub moment: Moment,
    /// Its frame in [`Shots::source`].
    pub index: usize,
}

impl Shots {
    /// The pictures of `frames` that `args` ask for. Films, and sequences that were asked to, run on the time of the simulation.
    pub fn plan(
        args: &RenderArgs,
        series: &Arc<Series>,
        frames: &[usize],
        is_film: bool,
        cancel: &Cancel,
    ) -> Result<Self, Failure> {
        let rate = args.encoding.rate();
        let on_time =
            is_film || args.encoding.fps.is_some() || args.time.speed.is_some() || args.time.interpolate;
        if !on_time {
            let timeline = Timeline::every_frame(frames, |frame| series.time(frame));
            let source = Arc::clone(series) as Arc<dyn FrameSource>;
            return Ok(Self::of(args, source, timeline, rate, |moment, _| moment.number));
        }
        let mut choices = Vec::new();
        let times = times(series, frames, rate, cancel, &mut choices)?;
        let step = step(args, &times, rate, &mut choices);
        let can_follow = series.has_ids();
        let sampling =
            if args.time.interpolate && can_follow { Sampling::Interpolated } else { Sampling::Nearest };
        let timeline = Timeline::at_constant_speed(&times, step, sampling)
            .map_err(|error| Failure::Usage(error.to_string()))?;
        let mut flaws = Flaws::default();
        let (pictures, at_most) = timeline.held();
        if pictures > 0 {
            let advice = match (args.time.interpolate, can_follow) {
                (_, false) => "the files have no ids, by which --interpolate follows particles",
                _ => "move particles between frames with --interpolate",
            };
            let of = timeline.moments().len();
            flaws.add(Flaw::FramesHeld { pictures, of, at_most, advice: advice.into() });
        }
        let mine = args.time.shard.map_or_else(|| timeline.clone(), |s| timeline.shard(s.index, s.count));
        let source = Resampled::new(
            Arc::clone(series) as Arc<dyn FrameSource>,
            mine.moments().to_vec(),
            series.velocity().map(ToOwned::to_owned),
            series.space().spacing as f32,
        );
        let shots = Self::of(args, Arc::new(source), timeline, rate, |_, place| place);
        Ok(Self { choices, flaws, ..shots })
    }

    fn of(
        args: &RenderArgs,
        source: Arc<dyn FrameSource>,
        timeline: Timeline,
        rate: FrameRate,
        index: impl Fn(&Moment, usize) -> usize,
    ) -> Self {
        let number = |moment: Option<&Moment>| moment.map_or(0, |moment| moment.number);
        let range = [number(timeline.moments().first()), number(timeline.moments().last())];
        let mine = args.time.shard.map_or_else(|| timeline.clone(), |s| timeline.shard(s.index, s.count));
        let shot = |(place, moment): (usize, &Moment)| Shot { moment: *moment, index: index(moment, place) };
        let shots = mine.moments().iter().enumerate().map(shot).collect();
        Self { source, shots, rate, range, choices: Vec::new(), flaws: Flaws::default() }
    }
}

/// Frames with their times. Where the series states none, every frame is a picture.
fn times(
    series: &Series,
    frames: &[usize],
    rate: FrameRate,
    cancel: &Cancel,
    choices: &mut Vec<Choice>,
) -> Result<Vec<(usize, f64)>, Failure> {
    let known = series.times_in_files(cancel)?;
    let stated: Option<Vec<(usize, f64)>> =
        frames.iter().map(|&frame| Some((frame, known[frame]?))).collect();
    Ok(stated.unwrap_or_else(|| {
        choices.push(Choice {
            what: "times".into(),
            value: "every frame is a picture".into(),
            reason: "the series does not state the time of all frames".into(),
            flag: "--dt SECONDS".into(),
        });
        frames.iter().map(|&frame| (frame, rate.seconds(frame as u64))).collect()
    }))
}

/// Simulation time from picture to picture.
fn step(args: &RenderArgs, times: &[(usize, f64)], rate: FrameRate, choices: &mut Vec<Choice>) -> f64 {
    if let Some(speed) = args.time.speed {
        return speed * rate.seconds(1);
    }
    let times: Vec<f64> = times.iter().map(|(_, time)| *time).collect();
    let Some(step) = usual_step(&times).filter(|step| *step > 0.0) else { return rate.seconds(1) };
    choices.push(Choice {
        what: "speed".into(),
        value: format!("{:.4} of real time", step / rate.seconds(1)),
        reason: format!("the usual step between frames, {step:.6} s, is a picture of {rate} in a second"),
        flag: "--speed".into(),
    });
    step
}
