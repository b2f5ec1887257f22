//! A frame as the survey looks at it.

use glam::{DVec3, Vec3};
use meniscus_core::{Aabb, Bulk, Cancel, Look};
use rayon::prelude::*;

use super::sets::{self, Plans, SetPlan};
use crate::Error;
use crate::analysis::subset::Subset;
use crate::discover::TimeStep;
use crate::frame_data::FrameData;

/// Particles at which trends over the whole liquid are looked at.
const SAMPLES: usize = 1 << 16;

/// A frame and its positions near zero.
pub(super) struct View {
    pub frame: FrameData,
    /// A short number near the middle of the bulk; what `positions` are relative to.
    pub origin: DVec3,
    pub positions: Vec<[f32; 3]>,
    /// Box around the positions, without strays.
    pub bounds: Aabb,
    /// Box around those of the body.
    body: Aabb,
    /// What lies in it is no stray among the water.
    counted: Aabb,
    all_counted: bool,
    /// The set of every point; `None` when all are in the default set.
    sets: Option<Vec<u8>>,
    /// Which sets count as the water.
    water: Vec<bool>,
}

impl View {
    pub fn open(step: &TimeStep, plans: &Plans, cancel: &Cancel) -> Result<Self, Error> {
        let frame = FrameData::open(step, plans.io_mode, cancel)?;
        let (mut positions, near, bulk) = positions_near_zero(&frame, cancel)?;
        let [bounds, body] = bounds_within(&positions, [bulk.around(), bulk.body()]);
        let origin = rounded_centre(bounds, near);
        // The way from the place that was subtracted to the origin is no longer than the data, and may be subtracted after it.
        let shift = (near - origin).as_vec3();
        positions.par_iter_mut().with_min_len(PIECE).for_each(|p| *p = (Vec3::from(*p) + shift).to_array());
        let [bounds, body] = [bounds, body].map(|of| Aabb { min: of.min + shift, max: of.max + shift });
        let bulk = bulk.moved(shift);
        let sets = sets::assign(plans, &frame, cancel)?;
        frame.check_unchanged()?;
        let water = water_sets(plans, sets.as_deref().unwrap_or_default());
        let everything = Aabb { min: Vec3::MIN, max: Vec3::MAX };
        let mut view = Self {
            frame,
            origin,
            positions,
            bounds,
            body,
            counted: everything,
            all_counted: false,
            sets,
            water,
        };
        // A little water in much of something else is few, but no strays.
        view.counted =
            if view.sets.is_none() { bulk.around() } else { Bulk::of_sample(view.water()).around() };
        let is_counted = |p: &[f32; 3]| view.counted.contains((*p).into());
        view.all_counted = view.positions.par_iter().with_min_len(PIECE).all(is_counted);
        Ok(view)
    }

    /// Positions of water, evenly spread over the file.
    fn water(&self) -> Vec<[f32; 3]> {
        self.sample(None).into_iter().map(|i| self.positions[i]).collect()
    }

    /// How far from the origin, along any axis, coordinates of particles `spacing` apart still tell neighbours from one another;
    /// farther than all of the bulk, whatever spacing is asked for.
    pub fn reach(&self, spacing: f64) -> f32 {
        let bulk = self.bounds.min.abs().max(self.bounds.max.abs()).max_element();
        let bulk = if self.is_empty() { 1.0 } else { bulk };
        // One step less than the bits of f32: neighbours are two steps apart there.
        let resolved = spacing * f64::from(1 << (f32::MANTISSA_DIGITS - 1));
        (resolved as f32).max(1024.0 * bulk).min(f32::MAX / 1024.0)
    }

    pub fn is_empty(&self) -> bool {
        self.bounds.is_empty()
    }

    /// Whether set `index` of the input has points.
    pub fn has_members(&self, index: usize) -> bool {
        self.sets.as_ref().map_or(index == 0, |sets| sets.iter().any(|&set| usize::from(set) == index))
    }

    /// Whether point `i` is no stray and in the default set; where that one is empty, in one drawn as water, else in any.
    pub fn is_water(&self, i: usize) -> bool {
        let is_in = |sets: &Vec<u8>| self.water.get(usize::from(sets[i])).is_some_and(|water| *water);
        self.counted.contains(self.positions[i].into()) && self.sets.as_ref().is_none_or(is_in)
    }

    /// The positions of the default set without those that `left_out` marks.
    pub fn liquid(&self, left_out: Option<&[bool]>) -> Subset<'_> {
        if self.all_counted && self.sets.is_none() && left_out.is_none() {
            return Subset::all(&self.positions);
        }
        let is_in = |i| self.is_water(i) && left_out.is_none_or(|left_out| !left_out[i]);
        Subset::those(&self.positions, is_in)
    }

    /// Indices of particles of the default set, evenly spread over the file, without those that `left_out` marks.
    pub fn sample(&self, left_out: Option<&[bool]>) -> Vec<usize> {
        // An odd step does not stay on one plane of a lattice, whose rows mostly have even lengths.
        let step = (self.positions.len() / SAMPLES) | 1;
        let is_in = |i: &usize| self.is_water(*i) && left_out.is_none_or(|left_out| !left_out[*i]);
        (0..self.positions.len()).step_by(step).filter(is_in).collect()
    }

    /// The axis along which all points of the body lie in one plane.
    pub fn flat_axis(&self) -> Option<usize> {
        let extent = self.body.extent();
        let flat = (0..3).find(|&axis| extent[axis] <= 1e-6 * extent.max_element());
        // A point or a line has no plane.
        flat.filter(|&axis| (0..3).filter(|&other| other != axis).all(|other| extent[other] > 0.0))
    }

    /// The position of point `i` relative to `origin` instead.
    pub fn position_from(&self, origin: DVec3, i: usize) -> [f32; 3] {
        (Vec3::from(self.positions[i]) + (self.origin - origin).as_vec3()).to_array()
    }
}

/// Which of `plans` count as the water when the points are in `sets`: the first of default set, sets drawn as water and all
/// sets that has points.
fn water_sets(plans: &[SetPlan], sets: &[u8]) -> Vec<bool> {
    let default: Vec<bool> = (0..plans.len()).map(|index| index == 0).collect();
    let drawn_as_water: Vec<bool> = plans.iter().map(|plan| plan.look == Look::Water).collect();
    let has_points =
        |marks: &Vec<bool>| sets.iter().any(|&set| marks.get(usize::from(set)).is_some_and(|mark| *mark));
    [default, drawn_as_water].into_iter().find(has_points).unwrap_or_else(|| vec![true; plans.len()])
}

/// Lengths of the body that it may be away from the place that was subtracted: steps of f32 are then a millionth of its length.
const FAR: f32 = 16.0;

/// Points looked at by one task.
const PIECE: usize = 1 << 14;

/// The positions of `frame` relative to some place in its bulk, that place, and the bulk of the positions: rounding to f32 far from
/// zero would eat into the estimates, so the place is subtracted before.
fn positions_near_zero(frame: &FrameData, cancel: &Cancel) -> Result<(Vec<[f32; 3]>, DVec3, Bulk), Error> {
    let near = DVec3::from(frame.some_place(cancel)?);
    let positions = frame.positions(near.to_array(), cancel)?;
    let bulk = Bulk::of(&positions);
    let body = bulk.body();
    // Seen from far away, such as from where particles that left are parked, all the others are in the same place.
    let is_near = body.center().abs().max_element() <= FAR * body.extent().max_element();
    if body.is_empty() || is_near {
        return Ok((positions, near, bulk));
    }
    let near = near + body.center().as_dvec3();
    let positions = frame.positions(near.to_array(), cancel)?;
    let bulk = Bulk::of(&positions);
    Ok((positions, near, bulk))
}

/// The boxes around those of `points` that are in each of `regions`.
fn bounds_within(points: &[[f32; 3]], regions: [Aabb; 2]) -> [Aabb; 2] {
    let of_piece = |piece: &[[f32; 3]]| {
        regions.map(|region| Aabb::of_points(piece.iter().filter(|p| region.contains((**p).into()))))
    };
    let union = |[a, b]: [Aabb; 2], [c, d]: [Aabb; 2]| [a.union(c), b.union(d)];
    points.par_chunks(PIECE).map(of_piece).reduce(|| [Aabb::EMPTY; 2], union)
}

/// The centre of `bounds` (relative to `near`, file space), rounded to a tenth of the extent's power of ten, so that it is a
/// short number.
fn rounded_centre(bounds: Aabb, near: DVec3) -> DVec3 {
    if bounds.is_empty() {
        return DVec3::ZERO;
    }
    let extent = f64::from(bounds.extent().max_element());
    // Beyond what f32 tells apart, one place is as good as another.
    if !extent.is_finite() {
        return near;
    }
    let exponent = if extent > 0.0 { extent.log10().floor() as i32 - 1 } else { 0 };
    // Multiplying by a whole power of ten and dividing by it again gives the double nearest to the short decimal.
    let scale = 10_f64.powi(exponent.abs());
    let round = |c: f64| {
        if exponent >= 0 { (c / scale).round() * scale } else { (c * scale).round() / scale }
    };
    let centre = near + (bounds.min.as_dvec3() + bounds.max.as_dvec3()) * 0.5;
    // Adding zero turns -0 into 0.
    DVec3::from_array(centre.to_array().map(round)) + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn origins_are_short_numbers() {
        let origin = |min: [f32; 3], max: [f32; 3]| {
            let near = DVec3::new(0.125, -0.25, 0.0);
            let shifted = |v: [f32; 3]| Vec3::from(v) - near.as_vec3();
            rounded_centre(Aabb { min: shifted(min), max: shifted(max) }, near).to_array()
        };
        assert_eq!(origin([5e5, 3.4e6, -3.0], [5.01e5, 3.402e6, 9.0]), [500_500.0, 3_401_000.0, 0.0]);
        assert_eq!(origin([-0.1, 0.0, 0.013], [0.1, 0.24, 0.013]), [0.0, 0.12, 0.01]);
        assert_eq!(origin([1.0; 3], [1.0; 3]), [1.0; 3]);
    }
}
