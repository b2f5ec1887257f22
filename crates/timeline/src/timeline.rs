/// More pictures than this are a mistake: eleven hours of film.
const MOST_PICTURES: f64 = 1e6;
/// A picture this near to a frame, as a share of the time between two pictures, is at its time: times are written with few
/// digits.
const SAME: f64 = 1e-3;

/// What of the data a picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sample {
    /// A frame.
    Frame(usize),
    /// The way from one frame to the next.
    Between {
        /// The frame before.
        before: usize,
        /// The frame after.
        after: usize,
        /// How much of the time between them has passed, in (0, 1).
        share: f64,
    },
}

/// The moment that a picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Number of the picture: from 0 in a film, the frame's index where every frame is a picture.
    pub number: usize,
    /// Time of the simulation.
    pub time: Option<f64>,
    /// What is shown.
    pub sample: Sample,
    /// How far the frame that is shown is from `time`; 0 where it is not held.
    pub off_by: f64,
}

/// What is shown between two frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// The nearest frame.
    Nearest,
    /// The particles on their way.
    Interpolated,
}

/// Why there is no film of this series.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TimelineError {
    /// Times that do not rise.
    #[error(
        "frame {frame} is at {time}, not after the frame before it at {before}; give the time between frames with --dt SECONDS"
    )]
    NotRising {
        /// Index of the frame.
        frame: usize,
        /// Its time.
        time: f64,
        /// That of the frame before.
        before: f64,
    },
    /// No end in sight.
    #[error("this would be a film of {pictures:.0} pictures; give a higher --speed or fewer --frames")]
    TooLong {
        /// How many.
        pictures: f64,
    },
}

/// The moments of all pictures, in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct Timeline {
    moments: Vec<Moment>,
}

impl Timeline {
    /// Every one of `frames` is a picture and gives it its number; `time` tells when it was.
    pub fn every_frame(frames: &[usize], time: impl Fn(usize) -> Option<f64>) -> Self {
        let moment = |&frame: &usize| Moment {
            number: frame,
            time: time(frame),
            sample: Sample::Frame(frame),
            off_by: 0.0,
        };
        Self { moments: frames.iter().map(moment).collect() }
    }

    /// A picture every `step` of simulation time, from the first to the last of `frames`, which are `(index, time)` in rising
    /// order.
    ///
    /// # Errors
    /// Times that do not rise, or more pictures than anybody wants.
    ///
    /// # Panics
    /// If `step` is not a positive number.
    pub fn at_constant_speed(
        frames: &[(usize, f64)],
        step: f64,
        sampling: Sampling,
    ) -> Result<Self, TimelineError> {
        assert!(step > 0.0 && step.is_finite(), "a step of {step} between pictures");
        for pair in frames.windows(2) {
            let [(_, before), (frame, time)] = [pair[0], pair[1]];
            if !(before.is_finite() && time > before) {
                return Err(TimelineError::NotRising { frame, time, before });
            }
        }
        let (Some((_, first)), Some((_, last))) = (frames.first(), frames.last()) else {
            return Ok(Self { moments: Vec::new() });
        };
        let pictures = ((last - first) / step + SAME).floor() + 1.0;
        if pictures.is_nan() || pictures > MOST_PICTURES {
            return Err(TimelineError::TooLong { pictures });
        }
        let moments = (0..pictures as usize).map(|number| {
            // Multiplied, not added up: the last picture is as exact as the first.
            let time = first + number as f64 * step;
            let (sample, off_by) = sample(frames, time, step * SAME, sampling);
            Moment { number, time: Some(time), sample, off_by }
        });
        Ok(Self { moments: moments.collect() })
    }

    /// The moments.
    pub fn moments(&self) -> &[Moment] {
        &self.moments
    }

    /// Number of pictures that are not at their time, and by how much they are off at most.
    pub fn held(&self) -> (usize, f64) {
        let off = || self.moments.iter().map(|moment| moment.off_by).filter(|off| *off > 0.0);
        (off().count(), off().fold(0.0, f64::max))
    }

    /// Every `count`-th picture from the `index`-th on, counted from 0.
    #[must_use]
    pub fn shard(&self, index: usize, count: usize) -> Self {
        Self { moments: self.moments.iter().copied().skip(index).step_by(count.max(1)).collect() }
    }
}

/// How long a picture is exposed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shutter {
    /// How long it is open, in the time of the simulation, centred on the picture's moment; > 0.
    pub open: f64,
    /// How many moments, evenly spread over that time, make the picture; at least 1.
    pub samples: u32,
}

impl Shutter {
    /// The moments that a picture at `time` is the mean of. Before the first and after the last of `frames`, which are `(index,
    /// time)` in rising order, nothing moves.
    ///
    /// # Panics
    /// Without any frame.
    pub fn moments(&self, number: usize, time: f64, frames: &[(usize, f64)]) -> Vec<Moment> {
        let count = self.samples.max(1);
        let moment = |i: u32| {
            let at = time + self.open * ((f64::from(i) + 0.5) / f64::from(count) - 0.5);
            let same = self.open / f64::from(count) * SAME;
            let (sample, off_by) = sample(frames, at, same, Sampling::Interpolated);
            Moment { number, time: Some(at), sample, off_by }
        };
        (0..count).map(moment).collect()
    }
}

/// What is shown at `time`, and how far that is from it. `frames` is not empty.
fn sample(frames: &[(usize, f64)], time: f64, same: f64, sampling: Sampling) -> (Sample, f64) {
    let next = frames.partition_point(|(_, at)| *at <= time);
    let before = frames[next.saturating_sub(1)];
    let Some(&after) = frames.get(next) else { return (Sample::Frame(before.0), 0.0) };
    let (since, until) = (time - before.1, after.1 - time);
    let (nearest, off_by) = if since <= until { (before.0, since) } else { (after.0, until) };
    if off_by <= same {
        (Sample::Frame(nearest), 0.0)
    } else if sampling == Sampling::Nearest {
        (Sample::Frame(nearest), off_by)
    } else {
        let share = since / (after.1 - before.1);
        (Sample::Between { before: before.0, after: after.0, share }, 0.0)
    }
}

/// The usual time between two of the frames at `times`: the median. `None` for fewer than two.
pub fn usual_step(times: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps of 4, then of 16, as some solvers write them.
    const UNEVEN: [(usize, f64); 5] = [(3, 0.0), (4, 4.0), (5, 8.0), (6, 24.0), (7, 40.0)];

    fn film(step: f64, sampling: Sampling) -> Vec<Moment> {
        Timeline::at_constant_speed(&UNEVEN, step, sampling).unwrap().moments().to_vec()
    }

    #[test]
    fn pictures_are_evenly_spaced_whatever_the_frames_are() {
        for sampling in [Sampling::Nearest, Sampling::Interpolated] {
            let moments = film(3.0, sampling);
            assert_eq!(moments.len(), 14);
            for (number, moment) in moments.iter().enumerate() {
                assert_eq!((moment.number, moment.time), (number, Some(3.0 * number as f64)));
            }
        }
    }

    #[test]
    fn between_frames_the_share_is_that_of_the_time() {
        let at = |number: usize| film(2.0, Sampling::Interpolated)[number].sample;
        assert_eq!(at(0), Sample::Frame(3));
        assert_eq!(at(1), Sample::Between { before: 3, after: 4, share: 0.5 });
        assert_eq!(at(2), Sample::Frame(4));
        assert_eq!(at(5), Sample::Between { before: 5, after: 6, share: 0.125 });
        assert_eq!(at(20), Sample::Frame(7));
    }

    #[test]
    fn the_nearest_frame_is_held_and_says_how_far_off_it_is() {
        let moments = film(2.0, Sampling::Nearest);
        assert_eq!((moments[5].sample, moments[5].off_by), (Sample::Frame(5), 2.0));
        assert_eq!((moments[9].sample, moments[9].off_by), (Sample::Frame(6), 6.0));
        let timeline = Timeline::at_constant_speed(&UNEVEN, 2.0, Sampling::Nearest).unwrap();
        // 2 and 6, 10 to 22, 26 to 38.
        assert_eq!(timeline.held(), (16, 8.0));
        let exact = Timeline::at_constant_speed(&UNEVEN, 8.0, Sampling::Nearest).unwrap();
        assert_eq!(exact.held(), (2, 8.0), "16 and 32 lie between frames");
        assert_eq!(
            Timeline::at_constant_speed(&UNEVEN, 2.0, Sampling::Interpolated).unwrap().held(),
            (0, 0.0)
        );
    }

    #[test]
    fn times_with_few_digits_still_meet_their_pictures() {
        let thirds: Vec<(usize, f64)> = (0..4).map(|i| (i, (i as f64 / 3.0 * 1e4).round() / 1e4)).collect();
        let timeline = Timeline::at_constant_speed(&thirds, 1.0 / 3.0, Sampling::Interpolated).unwrap();
        let samples: Vec<Sample> = timeline.moments().iter().map(|moment| moment.sample).collect();
        assert_eq!(samples, [0, 1, 2, 3].map(Sample::Frame));
    }

    #[test]
    fn times_that_do_not_rise_and_endless_films_are_refused() {
        let film = |frames: &[(usize, f64)], step| {
            Timeline::at_constant_speed(frames, step, Sampling::Nearest).map(|film| film.moments().len())
        };
        assert!(matches!(film(&[(0, 1.0), (1, 1.0)], 1.0), Err(TimelineError::NotRising { frame: 1, .. })));
        assert!(matches!(film(&[(0, 0.0), (1, f64::NAN)], 1.0), Err(TimelineError::NotRising { .. })));
        assert!(matches!(film(&[(0, 0.0), (1, 1.0)], 1e-300), Err(TimelineError::TooLong { .. })));
        assert_eq!(film(&[], 1.0), Ok(0));
        assert_eq!(film(&[(5, 2.0)], 1.0), Ok(1));
    }

    #[test]
    fn shards_share_out_all_pictures() {
        let timeline = Timeline::at_constant_speed(&UNEVEN, 3.0, Sampling::Nearest).unwrap();
        let shards: Vec<Timeline> = (0..3).map(|index| timeline.shard(index, 3)).collect();
        assert_eq!(shards[1].moments()[1], timeline.moments()[4]);
        let mut all: Vec<Moment> = shards.iter().flat_map(|shard| shard.moments().iter().copied()).collect();
        all.sort_by_key(|moment| moment.number);
        assert_eq!(all, timeline.moments());
    }

    #[test]
    fn a_shutter_is_open_evenly_around_the_picture() {
        let frames = [(4, 0.0), (5, 1.0), (6, 2.0)];
        let shutter = Shutter { open: 0.5, samples: 4 };
        let moments = shutter.moments(9, 1.0, &frames);
        let times: Vec<f64> = moments.iter().filter_map(|moment| moment.time).collect();
        assert_eq!(times, [0.8125, 0.9375, 1.0625, 1.1875]);
        assert_eq!(moments[0].sample, Sample::Between { before: 4, after: 5, share: 0.8125 });
        assert_eq!(moments[3].sample, Sample::Between { before: 5, after: 6, share: 0.1875 });
        assert!(moments.iter().all(|moment| moment.number == 9 && moment.off_by == 0.0));
        // An odd number looks at the picture's own moment.
        assert_eq!(Shutter { samples: 3, ..shutter }.moments(9, 1.0, &frames)[1].sample, Sample::Frame(5));
        // Nothing is known outside of the series.
        assert_eq!(shutter.moments(9, 0.0, &frames)[0].sample, Sample::Frame(4));
        assert_eq!(shutter.moments(9, 2.0, &frames)[3].sample, Sample::Frame(6));
    }

    #[test]
    fn the_usual_step_is_the_median() {
        assert_eq!(usual_step(&[0.0, 4.0, 8.0, 12.0, 28.0, 44.0]), Some(4.0));
        assert_eq!(usual_step(&[1.0]), None);
    }
}
