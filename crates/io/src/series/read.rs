//! One frame as the sets that are drawn.

use std::path::PathBuf;

use meniscus_core::{
    Attribute, Cancel, Flaw, Flaws, FrameRead, FrameRequest, ParticleFrame, ParticleSet, SetFrame,
};
use rayon::prelude::*;

use super::sets::{Assignment, NO_SET, SetSource};
use super::sizes::Sizes;
use super::{Series, companions, origin_of};
use crate::Error;
use crate::array::check;
use crate::frame_data::{Block, FrameArray, FrameData};
use crate::scalar::{Recentre, ToF32, ToU64};

/// Reads frame `index`; once more where somebody wrote to it meanwhile.
pub(super) fn read(
    series: &Series,
    index: usize,
    request: &FrameRequest,
    cancel: &Cancel,
) -> Result<SetFrame, Error> {
    match read_once(series, index, request, cancel) {
        Err(Error::Changed { .. }) => read_once(series, index, request, cancel),
        result => result,
    }
}

fn read_once(
    series: &Series,
    index: usize,
    request: &FrameRequest,
    cancel: &Cancel,
) -> Result<SetFrame, Error> {
    let step = series.step(index)?;
    let frame = FrameData::open(&step, series.sets.io_mode, cancel)?;
    let mut reader = Reader::of(series, cancel);
    let assignment = Assignment::new(&series.sets, &frame, cancel)?;
    let mut particles = reader.sets(&frame, assignment.as_ref(), series.sets.len(), request)?;
    frame.check_unchanged()?;
    // Those of files beside the water have no common measure with it.
    reader.sizes = None;
    let mut files = step.files.clone();
    let mut taken = FrameRead { bytes: frame.bytes_read(), particles: frame.points as u64 };
    for (set, plan) in particles.iter_mut().zip(series.sets.iter()) {
        let SetSource::Files(steps) = &plan.source else { continue };
        let Some(step) = companions::companion(steps, index, frame.time) else { continue };
        let frame = FrameData::open(step, series.sets.io_mode, cancel)?;
        files.extend(step.files.iter().cloned());
        // What colours the water need not exist in the files beside it.
        let has = |name: &&String| frame.attribute(name).is_some();
        let request = FrameRequest { attributes: request.attributes.iter().filter(has).cloned().collect() };
        let assignment = Assignment::without_ghosts(&series.sets.filter, &frame, cancel)?;
        let mut own = reader.sets(&frame, assignment.as_ref(), 1, &request)?;
        frame.check_unchanged()?;
        taken.bytes += frame.bytes_read();
        taken.particles += frame.points as u64;
        *set = own.pop().unwrap_or_default();
    }
    Ok(reader.frame(series, index, frame.time, files, particles, taken))
}

/// Points that follow one another in a first impression: enough for what is compressed in blocks of 32 KiB to be worth
/// unpacking, few enough to be spread over all of the frame.
const COARSE_RUN: usize = 4096;

/// Reads one in `share` runs of the points of frame `index`; `None` where that costs as much as the whole. Sets with files of their
/// own come with the whole.
pub(super) fn read_coarse(
    series: &Series,
    index: usize,
    share: u32,
    request: &FrameRequest,
    cancel: &Cancel,
) -> Result<Option<SetFrame>, Error> {
    let share = share.max(1) as usize;
    let step = series.step(index)?;
    let frame = FrameData::open(&step, series.sets.io_mode, cancel)?;
    if frame.is_text() || frame.points / COARSE_RUN < share {
        return Ok(None);
    }
    let mut reader = Reader::of(series, cancel);
    let assignment = Assignment::new(&series.sets, &frame, cancel)?;
    let runs = frame.blocks_of(COARSE_RUN).step_by(share);
    let particles = reader.shared_out(&frame, assignment.as_ref(), runs, series.sets.len(), request)?;
    frame.check_unchanged()?;
    let taken = FrameRead { bytes: frame.bytes_read(), particles: frame.points as u64 };
    let files = step.files.clone();
    Ok(Some(reader.frame(series, index, frame.time, files, particles, taken)))
}

/// Reads frames into sets.
struct Reader<'a> {
    /// What states the sizes of particles.
    sizes: Option<&'a Sizes>,
    origin: [f64; 3],
    /// Largest coordinate that is drawn, world.
    reach: f32,
    cancel: &'a Cancel,
    /// Points left out because their coordinates are not finite.
    dropped: u64,
    /// Points left out because they are beyond the reach.
    far: u64,
    /// Particles without a size that can be drawn, where sizes are stated.
    sizes_replaced: u64,
}

impl<'a> Reader<'a> {
    fn of(series: &'a Series, cancel: &'a Cancel) -> Self {
        Self {
            sizes: series.sizes.as_ref(),
            origin: origin_of(series.space.origin),
            reach: series.reach,
            cancel,
            dropped: 0,
            far: 0,
            sizes_replaced: 0,
        }
    }

    /// The `particles` of all sets as a frame.
    fn frame(
        &self,
        series: &Series,
        index: usize,
        time: Option<f64>,
        files: Vec<PathBuf>,
        particles: Vec<ParticleFrame>,
        taken: FrameRead,
    ) -> SetFrame {
        let mut flaws = Flaws::default();
        if self.dropped > 0 {
            flaws.add(Flaw::NonFiniteDropped { count: self.dropped });
        }
        if self.far > 0 {
            flaws.add(Flaw::FarDropped { count: self.far, distance: self.reach });
        }
        if let Some(sizes) = &series.sizes
            && self.sizes_replaced > 0
        {
            let (attribute, count) = (sizes.name().to_owned(), self.sizes_replaced);
            flaws.add(Flaw::SizesReplaced { attribute, count });
        }
        let sets = std::iter::zip(particles, series.sets.iter())
            .map(|(particles, plan)| ParticleSet { name: plan.name.clone(), look: plan.look, particles })
            .collect();
        SetFrame { index, time, files, origin: series.space.origin, sets, flaws, read: Some(taken) }
    }

    /// The particles of each of `count` sets; without `assignment` all go to the first.
    fn sets(
        &mut self,
        frame: &FrameData,
        assignment: Option<&Assignment<'_>>,
        count: usize,
        request: &FrameRequest,
    ) -> Result<Vec<ParticleFrame>, Error> {
        match assignment {
            None => {
                let mut sets = vec![ParticleFrame::default(); count];
                sets[0] = self.all(frame, request)?;
                Ok(sets)
            }
            Some(_) => self.shared_out(frame, assignment, frame.blocks(), count, request),
        }
    }

    /// All particles, in one pass over the file.
    fn all(&mut self, frame: &FrameData, request: &FrameRequest) -> Result<ParticleFrame, Error> {
        let positions = frame.positions(self.origin, self.cancel)?;
        let ids = frame.id_attribute().map(|ids| frame.values(ids, &ToU64, self.cancel)).transpose()?;
        let mut attributes = Vec::with_capacity(request.attributes.len());
        for name in &request.attributes {
            let attribute = frame.require(name)?;
            let values = frame.values(attribute, &ToF32, self.cancel)?;
            attributes.push(Attribute { name: name.clone(), components: attribute.components, values });
        }
        let stated = self.sizes.and_then(|sizes| sizes.find_in(frame));
        let stated = stated.map(|attribute| frame.values(attribute, &ToF32, self.cancel)).transpose()?;
        let sizes = self.relative(stated, positions.len());
        let mut all = ParticleFrame { positions, ids: ids.unwrap_or_default(), attributes, sizes };
        let reach = self.reach;
        let left_out = all.positions.par_iter().filter(|p| !is_within(reach, p)).count();
        if left_out > 0 {
            let taken: Vec<bool> = all.positions.par_iter().map(|p| is_within(reach, p)).collect();
            let positions = std::iter::zip(&all.positions, &taken);
            positions.filter(|(_, taken)| !**taken).for_each(|(position, _)| self.count_out(position));
            leave(&mut all, &taken);
        }
        Ok(all)
    }

    /// Counts a point that is left out for its `position`.
    fn count_out(&mut self, position: &[f32; 3]) {
        let is_finite = position.iter().all(|c| c.is_finite());
        *(if is_finite { &mut self.far } else { &mut self.dropped }) += 1;
    }

    /// The relative sizes of `count` particles for their `values` in the attribute that states them; none where nothing does.
    fn relative(&mut self, values: Option<Vec<f32>>, count: usize) -> Vec<f32> {
        let Some(sizes) = self.sizes else { return Vec::new() };
        let Some(values) = values else {
            self.sizes_replaced += count as u64;
            return Vec::new();
        };
        let (values, replaced) = sizes.relative(values);
        self.sizes_replaced += replaced;
        values
    }

    /// The particles of `blocks` in each of `count` sets, block by block: what no set takes is never in memory all at once.
    /// Without `assignment` all go to the first.
    fn shared_out(
        &mut self,
        frame: &FrameData,
        assignment: Option<&Assignment<'_>>,
        blocks: impl Iterator<Item = Block>,
        count: usize,
        request: &FrameRequest,
    ) -> Result<Vec<ParticleFrame>, Error> {
        let cancel = self.cancel;
        let positions = frame.positions_array()?;
        let ids = frame.id_attribute().map(|ids| frame.attribute_array(ids)).transpose()?;
        let stated = self.sizes.and_then(|sizes| sizes.find_in(frame));
        let stated = stated.map(|attribute| frame.attribute_array(attribute)).transpose()?;
        let mut arrays = Vec::with_capacity(request.attributes.len());
        for name in &request.attributes {
            arrays.push(frame.attribute_array(frame.require(name)?)?);
        }
        let empty = |(name, array): (&String, &FrameArray<'_>)| Attribute {
            name: name.clone(),
            components: array.components,
            values: Vec::new(),
        };
        let attributes = std::iter::zip(&request.attributes, &arrays).map(empty).collect();
        let empty = ParticleFrame { attributes, ..ParticleFrame::default() };
        let mut sets = vec![empty; count];
        for block in blocks {
            check(cancel)?;
            let mut assigned = match assignment {
                Some(assignment) => assignment.block(&block, cancel)?,
                None => vec![0; block.len()],
            };
            let positions = positions.values(&block, &Recentre { origin: self.origin }, cancel)?;
            let positions = positions.as_chunks::<3>().0;
            let reach = self.reach;
            for (set, p) in std::iter::zip(&mut assigned, positions).filter(|(_, p)| !is_within(reach, p)) {
                self.count_out(p);
                *set = NO_SET;
            }
            // Where nobody takes anything, nothing else is read.
            if assigned.iter().all(|set| *set == NO_SET) {
                continue;
            }
            let ids = match &ids {
                Some(ids) => ids.values(&block, &ToU64, cancel)?,
                None => (block.first..block.first + block.len()).map(|index| index as u64).collect(),
            };
            let stated = stated.as_ref().map(|array| array.values(&block, &ToF32, cancel)).transpose()?;
            let values = arrays.iter().map(|array| array.values(&block, &ToF32, cancel));
            let values: Vec<Vec<f32>> = values.collect::<Result<_, _>>()?;
            for (index, set) in sets.iter_mut().enumerate() {
                let members =
                    || assigned.iter().enumerate().filter(move |(_, of)| usize::from(**of) == index);
                let added = members().count();
                extend(&mut set.positions, added, members().map(|(i, _)| positions[i]));
                extend(&mut set.ids, added, members().map(|(i, _)| ids[i]));
                let stated = stated.as_ref().map(|stated| members().map(|(i, _)| stated[i]).collect());
                let sizes = self.relative(stated, added);
                extend(&mut set.sizes, sizes.len(), sizes.into_iter());
                for (attribute, values) in std::iter::zip(&mut set.attributes, &values) {
                    let n = attribute.components;
                    let tuples = members().flat_map(|(i, _)| values[i * n..(i + 1) * n].iter().copied());
                    extend(&mut attribute.values, added * n, tuples);
                }
            }
        }
        Ok(sets)
    }
}

/// Appends the `count` items of `added`. Room grows by a quarter: doubled, it could be as large again as what is kept.
fn extend<T>(list: &mut Vec<T>, count: usize, added: impl Iterator<Item = T>) {
    if list.capacity() - list.len() < count {
        list.reserve_exact(count.max(list.len() / 4));
    }
    list.extend(added);
}

/// Whether no coordinate is NaN, or farther from the origin than `reach`, which is finite.
fn is_within(reach: f32, position: &[f32; 3]) -> bool {
    position.iter().all(|c| c.abs() <= reach)
}

/// Leaves the particles of `all` that `taken` marks; they keep their identity.
fn leave(all: &mut ParticleFrame, taken: &[bool]) {
    if all.ids.is_empty() {
        all.ids = (0..taken.len() as u64).collect();
    }
    retain(&mut all.positions, 1, taken);
    retain(&mut all.ids, 1, taken);
    retain(&mut all.sizes, 1, taken);
    for attribute in &mut all.attributes {
        retain(&mut attribute.values, attribute.components, taken);
    }
}

/// Leaves the tuples of `components` values that `taken` marks.
pub(super) fn retain<T>(values: &mut Vec<T>, components: usize, taken: &[bool]) {
    let mut index = 0;
    values.retain(|_| {
        index += 1;
        taken[(index - 1) / components]
    });
}
