//! A series of particle frames: the reader that the rest of the program sees.

pub(crate) mod companions;
mod convert;
mod follow;
mod growth;
mod lengths;
mod parts;
mod read;
mod selections;
pub(crate) mod sets;
mod sizes;
mod survey;
mod times;
mod view;

use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard};

use glam::DVec3;
use meniscus_core::{Cancel, Choice, Flaws, FrameError, FrameRequest, FrameSource, SeriesSpace, SetFrame};
use rayon::prelude::*;

use crate::array::check;
use crate::discover::TimeStep;
use crate::frame_data::FrameData;
use crate::info::FrameInfo;
use crate::series::sets::Plans;
use crate::{Error, SeriesOptions, Sink};

pub use self::follow::Follow;
use self::growth::Place;
use self::sizes::Sizes;

/// A series of frames on disk, or a single file as a series of one.
///
/// Opening it reads the first usable frame to fix what holds for the whole series ([`SeriesSpace`]); frames are read on
/// demand, from any number of threads.
pub struct Series {
    place: Place,
    /// Grows at its end ([`Series::look_again`]); what is in it stays.
    steps: RwLock<Vec<Arc<TimeStep>>>,
    sets: Plans,
    space: SeriesSpace,
    /// Largest coordinate of particles that are drawn, world.
    reach: f32,
    choices: Vec<Choice>,
    flaws: Flaws,
    /// Delivered bytes per byte of file, from the first frame.
    bytes_per_file_byte: f64,
    has_ids: bool,
    velocity: Option<String>,
    sizes: Option<Sizes>,
}

impl Series {
    /// Opens `input`: a particle file, a `.pvd` or `.series` file, a folder, a glob, or a pattern such as `frame_%04d.vtu`.
    ///
    /// # Errors
    /// [`Error`] when nothing is there, when no frame of it can be read, or when `options` do not fit the data.
    pub fn open(input: &Path, options: &SeriesOptions) -> Result<Self, Error> {
        Self::open_unless(input, options, &Cancel::default())
    }

    /// [`Self::open`], which `cancel` stops.
    ///
    /// # Errors
    /// As [`Self::open`]; [`Error::Cancelled`] when stopped.
    pub fn open_unless(input: &Path, options: &SeriesOptions, cancel: &Cancel) -> Result<Self, Error> {
        options.validate()?;
        let place = Place { input: input.to_owned(), time_step: options.time_step };
        let found = place.look()?;
        let mut sets = sets::plan(options)?;
        let mut survey = survey::survey(&found.steps, &sets, options, cancel)?;
        let mut choices = found.choices;
        if !survey.own_sets.is_empty() {
            let (own, said): (Vec<_>, Vec<_>) = survey.own_sets.into_iter().unzip();
            let options = SeriesOptions { sets: [options.sets.clone(), own].concat(), ..options.clone() };
            sets = sets::plan(&options)?;
            survey = survey::survey(&found.steps, &sets, &options, cancel)?;
            choices.extend(said);
        }
        choices.extend(survey.choices);
        Ok(Self {
            place,
            steps: RwLock::new(found.steps.into_iter().map(Arc::new).collect()),
            sets,
            space: survey.space,
            reach: survey.reach,
            choices,
            flaws: survey.flaws,
            bytes_per_file_byte: survey.bytes_per_file_byte,
            has_ids: survey.has_ids,
            velocity: survey.velocity,
            sizes: survey.sizes,
        })
    }

    /// Origin, spacing, radius, up axis and unit, fixed for the whole series.
    pub fn space(&self) -> &SeriesSpace {
        &self.space
    }

    /// The automatic choices, each with the flag that overrides it.
    pub fn choices(&self) -> &[Choice] {
        &self.choices
    }

    /// What is wrong with the whole series.
    pub fn flaws(&self) -> &Flaws {
        &self.flaws
    }

    /// The time of every frame, where the series states it without a look into the frames.
    pub fn times(&self) -> Vec<Option<f64>> {
        self.steps().iter().map(|step| step.time).collect()
    }

    /// The time of every frame, also of those that only their files state: a look into the head of each of these.
    ///
    /// # Errors
    /// [`Error::Cancelled`] when `cancel` stops it. A file that cannot be opened has no time.
    pub fn times_in_files(&self, cancel: &Cancel) -> Result<Vec<Option<f64>>, Error> {
        let look = |step: &TimeStep| match step.time {
            Some(time) => Some(time),
            None => FrameData::open(step, self.sets.io_mode, cancel).ok()?.time,
        };
        let steps = self.steps().clone();
        let times = steps.par_iter().map(|step| look(step)).collect();
        check(cancel)?;
        Ok(times)
    }

    /// Whether the files name their particles, so that they can be followed from frame to frame.
    pub fn has_ids(&self) -> bool {
        self.has_ids
    }

    /// Name of the attribute that holds the velocities, three numbers a particle, where there is one.
    pub fn velocity(&self) -> Option<&str> {
        self.velocity.as_deref()
    }

    /// Name of the attribute that states the sizes of particles, where they differ: frames then have
    /// [`sizes`](meniscus_core::ParticleFrame::sizes).
    pub fn radius_by(&self) -> Option<&str> {
        self.sizes.as_ref().map(Sizes::name)
    }

    /// The files of frame `index`; none when there is no such frame.
    pub fn files(&self, index: usize) -> Vec<PathBuf> {
        self.step(index).map_or(Vec::new(), |step| step.files.clone())
    }

    /// Looks for frames that were added since the series was opened, behind those known; the new number of frames. Those known
    /// stay, with their numbers, even where their files are gone.
    ///
    /// # Errors
    /// [`Error`] where the input can no longer be looked through.
    pub fn look_again(&self) -> Result<usize, Error> {
        let found = self.place.look()?.steps;
        let mut steps = self.steps.write().unwrap_or_else(PoisonError::into_inner);
        let added = growth::added(&steps, found);
        steps.extend(added.into_iter().map(Arc::new));
        Ok(steps.len())
    }

    /// Looks again whenever something changes in the folder of the series, until the value returned is dropped.
    pub fn follow(self: &Arc<Self>) -> Follow {
        Follow::new(Arc::clone(self))
    }

    /// Describes frame `index` of the file as it is, before any selection; with `stats` also the range of every attribute.
    ///
    /// # Errors
    /// [`Error`] when there is no such frame or it cannot be read.
    pub fn frame_info(&self, index: usize, stats: bool) -> Result<FrameInfo, Error> {
        crate::info::describe(self, index, stats)
    }

    /// Number of points of frame `index`, before any selection.
    ///
    /// # Errors
    /// [`Error`] when there is no such frame or it cannot be opened.
    pub fn point_count(&self, index: usize) -> Result<usize, Error> {
        Ok(self.frame_data(index, &Cancel::default())?.points)
    }

    /// Reads the positions of frame `index` in one pass straight into `out`: world space ([`SeriesSpace::origin`] subtracted in
    /// `f64`), x, y, z, x, ..., all points in the order of the file, broken ones included. `out` has three places for each of
    /// [`Self::point_count`].
    ///
    /// # Errors
    /// [`Error`] when the frame cannot be read, or when `out` is of another size.
    pub fn positions_into<S: Sink<Item = f32>>(
        &self,
        index: usize,
        out: S,
        cancel: &Cancel,
    ) -> Result<(), Error> {
        let frame = self.frame_data(index, cancel)?;
        if Some(out.len()) != frame.points.checked_mul(3) {
            return Err(Error::usage(format_args!(
                "room for {} numbers, expected 3 for each of the {} points of frame {index}",
                out.len(),
                frame.points
            )));
        }
        frame.positions_into(origin_of(self.space.origin), out, cancel)?;
        frame.check_unchanged()
    }

    fn steps(&self) -> RwLockReadGuard<'_, Vec<Arc<TimeStep>>> {
        // Nothing panics while it writes to the list, and a list is whole after every step.
        self.steps.read().unwrap_or_else(PoisonError::into_inner)
    }

    fn step(&self, index: usize) -> Result<Arc<TimeStep>, Error> {
        let steps = self.steps();
        steps.get(index).cloned().ok_or_else(|| {
            let count = steps.len();
            Error::usage(format_args!("there is no frame {index}; the series has {count}, the first is 0"))
        })
    }

    pub(crate) fn frame_data(&self, index: usize, cancel: &Cancel) -> Result<FrameData, Error> {
        let step = self.step(index)?;
        FrameData::open(&step, self.sets.io_mode, cancel)
    }

    pub(crate) fn sets(&self) -> &Plans {
        &self.sets
    }
}

impl FrameSource for Series {
    fn frame_count(&self) -> usize {
        self.steps().len()
    }

    fn time(&self, index: usize) -> Option<f64> {
        self.steps().get(index)?.time
    }

    fn estimated_bytes(&self, index: usize) -> u64 {
        (survey::file_bytes(&self.files(index)) as f64 * self.bytes_per_file_byte) as u64
    }

    fn read(&self, index: usize, request: &FrameRequest, cancel: &Cancel) -> Result<SetFrame, FrameError> {
        Ok(read::read(self, index, request, cancel)?)
    }

    fn version(&self, index: usize) -> Option<u64> {
        Some(growth::version(&self.files(index)))
    }

    fn read_coarse(
        &self,
        index: usize,
        share: u32,
        request: &FrameRequest,
        cancel: &Cancel,
    ) -> Result<Option<SetFrame>, FrameError> {
        Ok(read::read_coarse(self, index, share, request, cancel)?)
    }
}

/// `origin` as the array that the conversion takes.
fn origin_of(origin: DVec3) -> [f64; 3] {
    origin.to_array()
}
