//! One frame as the sets that are drawn.

use meniscus_core::{
    Attribute, Cancel, Flaw, Flaws, FrameRead, FrameRequest, ParticleFrame, ParticleSet, SetFrame,
};
use rayon::prelude::*;

use super::sets::{self, NO_SET, SetSource};
use super::{Series, companions, origin_of};
use crate::Error;
use crate::array::check;
use crate::frame_data::FrameData;
use crate::scalar::{ToF32, ToU64};

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
    let frame = FrameData::open(step, series.sets.io_mode, cancel)?;
    let origin = origin_of(series.space.origin);
    let assigned = sets::assign(&series.sets, &frame, cancel)?;
    let mut dropped = 0;
    let mut particles = split(&frame, assigned, series.sets.len(), origin, request, cancel, &mut dropped)?;
    frame.check_unchanged()?;
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
        let real = series.sets.filter.without_ghosts(&frame, cancel)?;
        let assigned = real.map(|real| sets::only(&real));
        let mut own = split(&frame, assigned, 1, origin, &request, cancel, &mut dropped)?;
        frame.check_unchanged()?;
        taken.bytes += frame.bytes_read();
        taken.particles += frame.points as u64;
        *set = own.pop().unwrap_or_default();
    }
    let mut flaws = Flaws::default();
    if dropped > 0 {
        flaws.add(Flaw::NonFiniteDropped { count: dropped });
    }
    let sets = std::iter::zip(particles, series.sets.iter())
        .map(|(particles, plan)| ParticleSet { name: plan.name.clone(), look: plan.look, particles })
        .collect();
    Ok(SetFrame {
        index,
        time: frame.time,
        files,
        origin: series.space.origin,
        sets,
        flaws,
        read: Some(taken),
    })
}

/// The particles of each of `count` sets; without `assigned` all go to the first. Adds the number of points without finite
/// coordinates to `dropped`.
fn split(
    frame: &FrameData,
    assigned: Option<Vec<u8>>,
    count: usize,
    origin: [f64; 3],
    request: &FrameRequest,
    cancel: &Cancel,
    dropped: &mut u64,
) -> Result<Vec<ParticleFrame>, Error> {
    let positions = frame.positions(origin, cancel)?;
    let ids = frame.id_attribute().map(|ids| frame.values(ids, &ToU64, cancel)).transpose()?;
    let mut attributes = Vec::with_capacity(request.attributes.len());
    for name in &request.attributes {
        let attribute = frame.require(name)?;
        let values = frame.values(attribute, &ToF32, cancel)?;
        attributes.push(Attribute { name: name.clone(), components: attribute.components, values });
    }
    let finite = |p: &[f32; 3]| p.iter().all(|c| c.is_finite());
    let broken = positions.par_iter().filter(|p| !finite(p)).count();
    *dropped += broken as u64;
    let all = ParticleFrame { positions, ids: ids.unwrap_or_default(), attributes };
    let mut sets = vec![ParticleFrame::default(); count];
    let assigned = match assigned {
        None if broken == 0 => {
            sets[0] = all;
            return Ok(sets);
        }
        assigned => assigned.unwrap_or_else(|| vec![0; all.len()]),
    };
    let assigned: Vec<u8> = assigned
        .into_iter()
        .zip(&all.positions)
        .map(|(set, position)| if finite(position) { set } else { NO_SET })
        .collect();
    for (index, set) in sets.iter_mut().enumerate() {
        check(cancel)?;
        *set = gather(&all, &assigned, index as u8);
    }
    Ok(sets)
}

/// The particles of `all` that are assigned to `set`, with their identity kept.
fn gather(all: &ParticleFrame, assigned: &[u8], set: u8) -> ParticleFrame {
    let members = || assigned.iter().enumerate().filter(move |&(_, &of)| of == set).map(|(i, _)| i);
    let attributes = all.attributes.iter().map(|attribute| Attribute {
        name: attribute.name.clone(),
        components: attribute.components,
        values: members()
            .flat_map(|i| &attribute.values[i * attribute.components..(i + 1) * attribute.components])
            .copied()
            .collect(),
    });
    ParticleFrame {
        positions: members().map(|i| all.positions[i]).collect(),
        ids: members().map(|i| all.id(i)).collect(),
        attributes: attributes.collect(),
    }
}
