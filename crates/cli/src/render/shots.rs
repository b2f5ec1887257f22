//! Which moments are shown, and where their particles come from.

use std::sync::Arc;

use meniscus_core::{Cancel, Choice, Flaw, Flaws, FrameSource, Short};
use meniscus_export::FrameRate;
use meniscus_io::Series;
use meniscus_timeline::{Moment, Resampled, Sample, Sampling, Shutter, Timeline, usual_step};

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
    /// Least time between two pictures, those of other shards included; `None` where that is not known.
    pub least_step: Option<f64>,
    /// Numbers of the first picture and of the last, those of other shards included.
    pub range: [usize; 2],
    /// The first picture, the one in the middle and the last, those of other shards included: what is found once for all.
    pub probes: Vec<Moment>,
    /// What was chosen.
    pub choices: Vec<Choice>,
    /// What is not as asked.
    pub flaws: Flaws,
}

/// One picture.
#[derive(Clone, Debug)]
pub struct Shot {
    /// What it shows.
    pub moment: Moment,
    /// What it is the mean of, one after the other: itself, once or several times, or moments while the shutter is open.
    pub parts: Vec<Part>,
}

/// What is drawn for a picture.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    pub moment: Moment,
    /// How much later than the picture's own moment it is, in pictures.
    pub later: f64,
    /// Its number among the parts of the picture, by which they differ; `None` where it is the only one.
    pub sample: Option<u32>,
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
        let (mut choices, mut flaws) = (Vec::new(), Flaws::default());
        let blur = Blur::plan(args, series, rate, cancel, &mut flaws)?;
        let timeline = if on_time {
            let times = times(series, frames, rate, cancel, &mut choices)?;
            let step = step(args, &times, rate, &mut choices);
            at_constant_speed(args, series, &times.list, step, &mut flaws)?
        } else {
            Timeline::every_frame(frames, |frame| series.time(frame))
        };
        let number = |moment: Option<&Moment>| moment.map_or(0, |moment| moment.number);
        let range = [number(timeline.moments().first()), number(timeline.moments().last())];
        let probes = probes(timeline.moments());
        let times = timeline.moments().windows(2).filter_map(|pair| Some(pair[1].time? - pair[0].time?));
        let least_step = times.filter(|step| *step > 0.0).reduce(f64::min);
        let mine = args.time.shard.map_or_else(|| timeline.clone(), |s| timeline.shard(s.index, s.count));

        let mut shots: Vec<Shot> = mine
            .moments()
            .iter()
            .map(|&moment| Shot { moment, parts: parts(moment, args.exposure.samples(), blur.as_ref()) })
            .collect();
        let is_resampled = on_time || blur.is_some();
        let source: Arc<dyn FrameSource> = if is_resampled {
            // What is shown several times in a row is read once.
            let mut moments: Vec<Moment> = Vec::new();
            for part in shots.iter_mut().flat_map(|shot| &mut shot.parts) {
                if moments.last().is_none_or(|before| before.sample != part.moment.sample) {
                    moments.push(part.moment);
                }
                part.index = moments.len() - 1;
            }
            Arc::new(Resampled::new(
                Arc::clone(series) as Arc<dyn FrameSource>,
                moments,
                series.velocity().map(ToOwned::to_owned),
                series.space().spacing as f32,
            ))
        } else {
            Arc::clone(series) as Arc<dyn FrameSource>
        };
        Ok(Self { source, shots, rate, least_step, range, probes, choices, flaws })
    }
}

impl Part {
    /// All of a picture. Its frame is the one of its number, as in the series.
    pub fn whole(moment: Moment) -> Self {
        Self { moment, later: 0.0, sample: None, index: moment.number }
    }
}

/// The first, the middle and the last of `moments`, as far as they differ.
fn probes(moments: &[Moment]) -> Vec<Moment> {
    let last = moments.len().saturating_sub(1);
    let mut places = vec![0, last / 2, last];
    places.dedup();
    places.into_iter().filter_map(|place| moments.get(place).copied()).collect()
}

/// What the picture of `moment` is the mean of.
fn parts(moment: Moment, samples: u32, blur: Option<&Blur>) -> Vec<Part> {
    let mut parts =
        blur.map_or_else(|| vec![Part::whole(moment); samples as usize], |blur| blur.parts(moment));
    if parts.len() > 1 {
        for (sample, part) in (0..).zip(&mut parts) {
            part.sample = Some(sample);
        }
    }
    parts
}

/// Motion blur of pictures of a series.
struct Blur {
    shutter: Shutter,
    /// Simulation time from picture to picture.
    step: f64,
    /// All frames of the series with their times.
    frames: Vec<(usize, f64)>,
}

impl Blur {
    /// What `args` ask for; `None` for none, or where particles cannot be followed.
    fn plan(
        args: &RenderArgs,
        series: &Series,
        rate: FrameRate,
        cancel: &Cancel,
        flaws: &mut Flaws,
    ) -> Result<Option<Self>, Failure> {
        let Some(share) = args.exposure.motion_blur else { return Ok(None) };
        let mut because = |reason: &str| {
            flaws.add(Flaw::MotionNotBlurred { reason: reason.into() });
            Ok(None)
        };
        if series.frame_count() < 2 {
            return because("there is one frame only");
        }
        if !series.has_ids() {
            return because("the files have no ids, by which particles are followed between frames");
        }
        let all: Vec<usize> = (0..series.frame_count()).collect();
        let times = times(series, &all, rate, cancel, &mut Vec::new())?;
        let step = step(args, &times, rate, &mut Vec::new());
        let frames = times.list;
        // Refuses times that do not rise.
        Timeline::at_constant_speed(&frames, step, Sampling::Nearest)
            .map_err(|error| Failure::Usage(error.to_string()))?;
        let shutter = Shutter { open: share * step, samples: args.exposure.samples() };
        Ok(Some(Self { shutter, step, frames }))
    }

    fn parts(&self, moment: Moment) -> Vec<Part> {
        let time = match moment.sample {
            Sample::Frame(frame) => self.frames[frame].1,
            Sample::Between { before, after, share } => {
                let [from, to] = [before, after].map(|frame| self.frames[frame].1);
                from + share * (to - from)
            }
        };
        let part = |part: Moment| {
            let later = (part.time.unwrap_or(time) - time) / self.step;
            Part { moment: part, later, sample: None, index: 0 }
        };
        self.shutter.moments(moment.number, time, &self.frames).into_iter().map(part).collect()
    }
}

/// Pictures every `step` of simulation time, from the first of `times` to the last.
fn at_constant_speed(
    args: &RenderArgs,
    series: &Series,
    times: &[(usize, f64)],
    step: f64,
    flaws: &mut Flaws,
) -> Result<Timeline, Failure> {
    let (is_asked, can_follow) =
        (args.time.interpolate || args.exposure.motion_blur.is_some(), series.has_ids());
    let sampling = if is_asked && can_follow { Sampling::Interpolated } else { Sampling::Nearest };
    let timeline = Timeline::at_constant_speed(times, step, sampling)
        .map_err(|error| Failure::Usage(error.to_string()))?;
    let (pictures, at_most) = timeline.held();
    if pictures > 0 {
        let advice = if can_follow {
            "move particles between frames with --interpolate"
        } else {
            "the files have no ids, by which --interpolate follows particles"
        };
        let of = timeline.moments().len();
        flaws.add(Flaw::FramesHeld { pictures, of, at_most, advice: advice.into() });
    }
    Ok(timeline)
}

/// Frames with their times.
struct Times {
    list: Vec<(usize, f64)>,
    /// Whether the series states them.
    are_stated: bool,
}

/// Where the series states no times, every frame is a picture.
fn times(
    series: &Series,
    frames: &[usize],
    rate: FrameRate,
    cancel: &Cancel,
    choices: &mut Vec<Choice>,
) -> Result<Times, Failure> {
    let known = series.times_in_files(cancel)?;
    let stated: Option<Vec<(usize, f64)>> =
        frames.iter().map(|&frame| Some((frame, known[frame]?))).collect();
    if let Some(list) = stated {
        return Ok(Times { list, are_stated: true });
    }
    choices.push(Choice {
        what: "times".into(),
        value: "every frame is a picture".into(),
        reason: "the series does not state the time of all frames".into(),
        flag: "--dt SECONDS".into(),
    });
    let list = frames.iter().map(|&frame| (frame, rate.seconds(frame as u64))).collect();
    Ok(Times { list, are_stated: false })
}

/// Simulation time from picture to picture.
fn step(args: &RenderArgs, times: &Times, rate: FrameRate, choices: &mut Vec<Choice>) -> f64 {
    if let Some(speed) = args.time.speed {
        return speed * rate.seconds(1);
    }
    let list: Vec<f64> = times.list.iter().map(|(_, time)| *time).collect();
    let Some(step) = usual_step(&list).filter(|step| *step > 0.0) else { return rate.seconds(1) };
    choices.extend(speed(times, step, rate));
    step
}

/// What is said of the speed; of times that nobody stated there is nothing to say.
fn speed(times: &Times, step: f64, rate: FrameRate) -> Option<Choice> {
    times.are_stated.then(|| Choice {
        what: "speed".into(),
        value: format!("{} of real time", Short(step / rate.seconds(1))),
        reason: format!(
            "the usual step between frames, {} s, is a picture of {rate} in a second",
            Short(step)
        ),
        flag: "--speed".into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_speed_is_that_of_times_that_are_stated() {
        let rate: FrameRate = "25".parse().unwrap();
        let of = |are_stated| speed(&Times { list: vec![(0, 0.0), (1, 1e-6)], are_stated }, 1e-6, rate);
        let said = of(true).map(|choice| choice.to_string()).unwrap_or_default();
        assert!(
            said.starts_with("speed: 0.000025 of real time (the usual step between frames, 1e-6 s,"),
            "{said}"
        );
        assert_eq!(of(false), None);
    }
}
