//! A series as if it had a frame for every picture of a film.

use std::sync::{Arc, Mutex, PoisonError};

use meniscus_core::{Cancel, FrameError, FrameErrorKind, FrameRequest, FrameSource, SetFrame};

use crate::{Moment, Motion, Sample, between};

/// Frames kept for the next pictures: what two readers need for two pictures in a row.
const KEPT: usize = 3;

/// Frame `k` of it is what the `k`-th of the moments shows.
pub struct Resampled {
    series: Arc<dyn FrameSource>,
    moments: Vec<Moment>,
    velocity: Option<String>,
    spacing_world: f32,
    /// Whether some moments lie between frames, so that those at a frame are what others are made of, too.
    interpolates: bool,
    kept: Mutex<Vec<Slot>>,
}

/// A frame of the data that some reader reads or has read. Who else needs it waits.
struct Slot {
    frame: usize,
    read: Arc<Mutex<Option<Arc<SetFrame>>>>,
}

impl Resampled {
    /// The particles of `series` at `moments`, moved by the attribute `velocity` where it has one.
    pub fn new(
        series: Arc<dyn FrameSource>,
        moments: Vec<Moment>,
        velocity: Option<String>,
        spacing_world: f32,
    ) -> Self {
        let interpolates = moments.iter().any(|moment| matches!(moment.sample, Sample::Between { .. }));
        Self { series, moments, velocity, spacing_world, interpolates, kept: Mutex::default() }
    }

    /// Frame `frame` of the data, from memory where it was just read. What reading it took is told once.
    /// A frame without velocities comes without.
    fn data(&self, frame: usize, request: &FrameRequest, cancel: &Cancel) -> Result<Shared, FrameError> {
        let slot = self.slot(frame);
        let mut read = slot.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(there) = &*read {
            return Ok(Shared { frame: Arc::clone(there), is_new: false });
        }
        // After an error the slot stays empty and the next one tries again.
        let mut with_velocity = request.clone();
        with_velocity.attributes.extend(self.velocity.clone());
        let fresh = match self.series.read(frame, &with_velocity, cancel) {
            Err(error) if error.kind == FrameErrorKind::Usage && self.velocity.is_some() => {
                self.series.read(frame, request, cancel)
            }
            result => result,
        };
        let fresh = Arc::new(fresh?);
        *read = Some(Arc::clone(&fresh));
        Ok(Shared { frame: fresh, is_new: true })
    }

    fn slot(&self, frame: usize) -> Arc<Mutex<Option<Arc<SetFrame>>>> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let slot = match kept.iter().position(|slot| slot.frame == frame) {
            Some(place) => kept.remove(place),
            None => Slot { frame, read: Arc::default() },
        };
        let read = Arc::clone(&slot.read);
        // The one used last is at the end, the first goes.
        kept.push(slot);
        if kept.len() > KEPT {
            kept.remove(0);
        }
        read
    }

    fn interpolated(
        &self,
        [before, after]: [usize; 2],
        share: f64,
        request: &FrameRequest,
        cancel: &Cancel,
    ) -> Result<SetFrame, FrameError> {
        let [before, after] = [self.data(before, request, cancel)?, self.data(after, request, cancel)?];
        let step = match (before.frame.time, after.frame.time) {
            (Some(from), Some(to)) => to - from,
            _ => 0.0,
        };
        let motion =
            Motion { share, step, velocity: self.velocity.as_deref(), spacing_world: self.spacing_world };
        let mut frame = between(&before.frame, &after.frame, &motion);
        frame.read =
            [before, after].iter().filter(|shared| shared.is_new).filter_map(|s| s.frame.read).reduce(
                |mut sum, read| {
                    sum.bytes += read.bytes;
                    sum.particles += read.particles;
                    sum
                },
            );
        Ok(frame)
    }
}

/// A frame that several pictures are made of.
struct Shared {
    frame: Arc<SetFrame>,
    /// Whether it was read for this picture.
    is_new: bool,
}

impl FrameSource for Resampled {
    fn frame_count(&self) -> usize {
        self.moments.len()
    }

    fn time(&self, index: usize) -> Option<f64> {
        self.moments.get(index)?.time
    }

    fn estimated_bytes(&self, index: usize) -> u64 {
        match self.moments.get(index).map(|moment| moment.sample) {
            Some(Sample::Frame(frame)) => self.series.estimated_bytes(frame),
            Some(Sample::Between { before, after, .. }) => {
                self.series.estimated_bytes(before).max(self.series.estimated_bytes(after))
            }
            None => 0,
        }
    }

    fn read(&self, index: usize, request: &FrameRequest, cancel: &Cancel) -> Result<SetFrame, FrameError> {
        let Some(moment) = self.moments.get(index) else {
            let message = format!("picture {index}: the film has {}, counted from 0", self.moments.len());
            return Err(FrameError { kind: FrameErrorKind::Usage, file: None, message });
        };
        let mut frame = match moment.sample {
            Sample::Frame(frame) if self.interpolates => {
                let Shared { frame, is_new } = self.data(frame, request, cancel)?;
                let mut frame = Arc::unwrap_or_clone(frame);
                frame.read.take_if(|_| !is_new);
                frame
            }
            Sample::Frame(frame) => self.series.read(frame, request, cancel)?,
            Sample::Between { before, after, share } => {
                self.interpolated([before, after], share, request, cancel)?
            }
        };
        (frame.index, frame.time) = (index, moment.time);
        Ok(frame)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use meniscus_core::{FrameRead, Look, ParticleFrame, ParticleSet};

    use super::*;
    use crate::{Sampling, Timeline};

    /// One particle that is at x = time; frame 2 cannot be read.
    #[derive(Default)]
    struct Line {
        reads: AtomicUsize,
    }

    const TIMES: [f64; 4] = [0.0, 1.0, 5.0, 6.0];

    impl FrameSource for Line {
        fn frame_count(&self) -> usize {
            TIMES.len()
        }

        fn time(&self, index: usize) -> Option<f64> {
            TIMES.get(index).copied()
        }

        fn estimated_bytes(&self, index: usize) -> u64 {
            100 + index as u64
        }

        fn read(&self, index: usize, request: &FrameRequest, _: &Cancel) -> Result<SetFrame, FrameError> {
            if !request.attributes.is_empty() {
                let message = "there are no attributes".into();
                return Err(FrameError { kind: FrameErrorKind::Usage, file: None, message });
            }
            self.reads.fetch_add(1, Ordering::Relaxed);
            if index == 2 {
                let kind = FrameErrorKind::Malformed;
                return Err(FrameError { kind, file: None, message: "frame 2".into() });
            }
            let particles = ParticleFrame {
                positions: vec![[TIMES[index] as f32, 0.0, 0.0]],
                ids: vec![7],
                ..Default::default()
            };
            let set = ParticleSet { name: "water".into(), look: Look::Water, particles };
            let read = Some(FrameRead { bytes: 10, particles: 1 });
            Ok(SetFrame { index, time: self.time(index), sets: vec![set], read, ..Default::default() })
        }
    }

    fn film(step: f64, velocity: Option<&str>) -> (Arc<Line>, Resampled) {
        let line = Arc::new(Line::default());
        let frames: Vec<(usize, f64)> = TIMES.iter().copied().enumerate().collect();
        let timeline = Timeline::at_constant_speed(&frames, step, Sampling::Interpolated).unwrap();
        let source = Arc::clone(&line) as Arc<dyn FrameSource>;
        (line, Resampled::new(source, timeline.moments().to_vec(), velocity.map(Into::into), 1.0))
    }

    fn read(film: &Resampled, index: usize) -> Result<SetFrame, FrameError> {
        film.read(index, &FrameRequest::default(), &Cancel::default())
    }

    #[test]
    fn pictures_have_their_own_numbers_times_and_places() {
        let (line, film) = film(0.25, None);
        assert_eq!(film.frame_count(), 25);
        for index in [0, 1, 2, 3, 4, 21, 23, 24] {
            // 21 and 23 are between 5 and 6, whose frame 2 is broken.
            let Ok(frame) = read(&film, index) else {
                assert!((21..24).contains(&index));
                continue;
            };
            assert_eq!((frame.index, frame.time), (index, Some(0.25 * index as f64)));
            assert_eq!(frame.sets[0].particles.positions[0][0], 0.25 * index as f32);
        }
        assert!(line.reads.load(Ordering::Relaxed) > 0);
        assert_eq!((film.estimated_bytes(1), film.estimated_bytes(24)), (101, 103));
    }

    #[test]
    fn a_frame_is_read_once_for_pictures_in_a_row_and_counted_once() {
        let (line, film) = film(0.25, None);
        let bytes: u64 = (1..4).map(|i| read(&film, i).unwrap().read.map_or(0, |read| read.bytes)).sum();
        assert_eq!((line.reads.load(Ordering::Relaxed), bytes), (2, 20));
    }

    /// The first five pictures are all of frames 0 and 1: at 0, between, and at 1.
    #[test]
    fn pictures_at_a_frame_read_what_those_beside_it_have_read() {
        let (line, film) = film(0.25, None);
        let bytes: u64 = (0..5).map(|i| read(&film, i).unwrap().read.map_or(0, |read| read.bytes)).sum();
        assert_eq!((line.reads.load(Ordering::Relaxed), bytes), (2, 20));
    }

    #[test]
    fn frames_without_velocities_come_without() {
        let (_, film) = film(0.25, Some("velocity"));
        assert_eq!(read(&film, 3).unwrap().sets[0].particles.positions[0][0], 0.75);
    }

    #[test]
    fn a_broken_frame_is_tried_again() {
        let (line, film) = film(0.25, None);
        assert!(read(&film, 21).is_err() && read(&film, 21).is_err());
        assert_eq!(line.reads.load(Ordering::Relaxed), 2);
        assert!(film.read(99, &FrameRequest::default(), &Cancel::default()).is_err());
    }
}
