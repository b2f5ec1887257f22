//! What holds for a whole series, from its first usable frame and, where that says too little, its last.

use std::path::PathBuf;

use glam::DVec3;
use meniscus_core::{
    Aabb, Cancel, Choice, DEFAULT_RADIUS_PER_SPACING, Flaw, Flaws, RadiusChoice, SeriesSpace, SpacingSource,
};

use super::sets::{self, SetPlan};
use crate::analysis::{names, spacing, up, walls};
use crate::discover::TimeStep;
use crate::frame_data::FrameData;
use crate::scalar::ToF32;
use crate::{Error, SeriesOptions};

pub(super) struct Survey {
    pub space: SeriesSpace,
    pub choices: Vec<Choice>,
    pub flaws: Flaws,
    pub bytes_per_file_byte: f64,
}

/// A frame with what the survey looks at.
struct View {
    frame: FrameData,
    origin: DVec3,
    positions: Vec<[f32; 3]>,
    /// Points of the default set with finite coordinates.
    water: Vec<bool>,
}

impl View {
    fn open(step: &TimeStep, plans: &[SetPlan], cancel: &Cancel) -> Result<Self, Error> {
        let frame = FrameData::open(step, cancel)?;
        let mut positions = frame.positions([0.0; 3], cancel)?;
        let bounds = Aabb::of_points(positions.iter().filter(|p| is_finite(p)));
        let origin = rounded_centre(bounds);
        // Where the rounding to f32 would eat into the estimates, the origin is subtracted before it, as for drawing.
        if origin.abs().max_element() > f64::from(bounds.extent().max_element()) {
            positions = frame.positions(origin.to_array(), cancel)?;
        } else {
            let shift = origin.as_vec3().to_array();
            positions.iter_mut().for_each(|p| (0..3).for_each(|axis| p[axis] -= shift[axis]));
        }
        let assigned = sets::assign(plans, &frame, cancel)?;
        let is_water = |i: usize| assigned.as_ref().is_none_or(|sets| sets[i] == 0);
        let water = positions.iter().enumerate().map(|(i, p)| is_finite(p) && is_water(i)).collect();
        Ok(Self { frame, origin, positions, water })
    }

    fn is_empty(&self) -> bool {
        !self.positions.iter().any(is_finite)
    }
}

fn is_finite(point: &[f32; 3]) -> bool {
    point.iter().all(|c| c.is_finite())
}

/// The centre of `bounds` (file space), rounded to a tenth of the extent's power of ten, so that it is a short number.
fn rounded_centre(bounds: Aabb) -> DVec3 {
    if bounds.is_empty() {
        return DVec3::ZERO;
    }
    let extent = f64::from(bounds.extent().max_element());
    let exponent = if extent > 0.0 { extent.log10().floor() as i32 - 1 } else { 0 };
    // Multiplying by a whole power of ten and dividing by it again gives the double nearest to the short decimal.
    let scale = 10_f64.powi(exponent.abs());
    let round = |c: f32| {
        let c = f64::from(c);
        if exponent >= 0 { (c / scale).round() * scale } else { (c * scale).round() / scale }
    };
    let centre = (bounds.min.as_dvec3() + bounds.max.as_dvec3()) * 0.5;
    let rounded = DVec3::from_array(centre.to_array().map(|c| round(c as f32)));
    // Near zero a negative sign would only be noise.
    rounded + 0.0
}

pub(super) fn file_bytes(files: &[PathBuf]) -> u64 {
    files.iter().filter_map(|file| std::fs::metadata(file).ok()).map(|meta| meta.len()).sum()
}

pub(super) fn survey(
    steps: &[TimeStep],
    plans: &[SetPlan],
    options: &SeriesOptions,
) -> Result<Survey, Error> {
    let cancel = Cancel::default();
    let mut flaws = Flaws::default();
    let (view, index) = first_view(steps, plans, &mut flaws, &cancel)?;
    let last = later_view(steps, index, plans, &cancel);
    let mut choices = Vec::new();
    describe_parts(&view, &mut choices, &cancel);

    let flat_axis = flat_axis(&view);
    if let Some(axis) = flat_axis {
        flaws.add(Flaw::Planar { axis: ['x', 'y', 'z'][axis] });
    }
    let same_particles = last.as_ref().filter(|last| last.positions.len() == view.positions.len());
    let moved = same_particles.map(|last| shifted(&last.positions, last.origin - view.origin));
    let walls = walls::find(&view.frame, &view.positions, &view.water, moved.as_deref(), &cancel)?;
    let is_liquid = |i: usize| view.water[i] && walls.as_ref().is_none_or(|walls| !walls.members[i]);
    let liquid: Vec<bool> = (0..view.positions.len()).map(is_liquid).collect();
    if let Some(walls) = &walls {
        flaws.add(Flaw::WallsDrawnAsWater { flag: walls.flag.clone() });
    }
    let points: Vec<[f32; 3]> = members(&view.positions, &liquid);

    let (spacing, spacing_source) =
        choose_spacing(&view, &liquid, &points, flat_axis, options, &mut choices, &mut flaws, &cancel)?;
    let (radius, radius_choice) = choose_radius(spacing, options, &mut choices);
    let up = match options.up {
        Some(axis) => axis,
        None => {
            let guess = guess_up(&view, last.as_ref(), &liquid, &points, spacing as f32, flat_axis, &cancel)?;
            choices.push(choice("up axis", guess.axis.letter().to_string(), guess.reason, "--up"));
            guess.axis
        }
    };
    let metres_per_unit = options.metres_per_unit.unwrap_or_else(|| {
        choices.push(choice("unit", "m".into(), "VTK files do not state one".into(), "--unit"));
        1.0
    });
    let bytes = view.positions.len() * if view.frame.id_attribute().is_some() { 20 } else { 12 };
    Ok(Survey {
        bytes_per_file_byte: bytes as f64 / file_bytes(&steps[index].files).max(1) as f64,
        space: SeriesSpace {
            origin: view.origin,
            spacing,
            spacing_source,
            radius,
            radius_choice,
            up,
            metres_per_unit,
        },
        choices,
        flaws,
    })
}

fn choice(what: &str, value: String, reason: String, flag: &str) -> Choice {
    Choice { what: what.into(), value, reason, flag: flag.into() }
}

/// The first frame with particles, else the first that can be read at all. Frames that cannot be read become flaws.
fn first_view(
    steps: &[TimeStep],
    plans: &[SetPlan],
    flaws: &mut Flaws,
    cancel: &Cancel,
) -> Result<(View, usize), Error> {
    let mut empty = None;
    let mut first_error = None;
    for (index, step) in steps.iter().enumerate() {
        match View::open(step, plans, cancel) {
            Ok(view) if !view.is_empty() => return Ok((view, index)),
            Ok(view) => empty = empty.or(Some((view, index))),
            Err(e @ (Error::Usage { .. } | Error::Expression(_))) => return Err(e),
            Err(e) => {
                flaws.add(Flaw::FrameMissing { frame: index, reason: e.to_string() });
                first_error = first_error.or(Some(e));
            }
        }
    }
    match (empty, first_error) {
        (Some(found), _) => Ok(found),
        (None, Some(error)) => Err(error),
        (None, None) => Err(Error::usage("the series has no frame")),
    }
}

/// The last readable frame behind `index`; its own error is met again when it is drawn.
fn later_view(steps: &[TimeStep], index: usize, plans: &[SetPlan], cancel: &Cancel) -> Option<View> {
    let mut later = steps.iter().skip(index + 1).rev();
    later.find_map(|step| View::open(step, plans, cancel).ok().filter(|view| !view.is_empty()))
}

fn describe_parts(view: &View, choices: &mut Vec<Choice>, cancel: &Cancel) {
    // Cells that cannot be read do not matter to particles.
    if view.frame.is_mesh(cancel).unwrap_or(false) {
        let reason = "there are no vertex cells, only faces; is this a surface mesh?".into();
        choices.push(choice("particles", "the corners of a mesh".into(), reason, "INPUT"));
    }
    if !view.frame.meshes.is_empty() {
        let names: Vec<String> = view
            .frame
            .meshes
            .iter()
            .filter_map(|path| Some(path.file_name()?.to_string_lossy().into_owned()))
            .collect();
        let reason = "a surface mesh is not water".into();
        choices.push(choice("parts left out", names.join(", "), reason, "--set NAME=FILE"));
    }
}

/// The axis along which all finite points of the whole frame lie in one plane.
fn flat_axis(view: &View) -> Option<usize> {
    let bounds = Aabb::of_points(view.positions.iter().filter(|p| is_finite(p)));
    let extent = bounds.extent();
    let flat = (0..3).find(|&axis| extent[axis] <= 1e-6 * extent.max_element());
    // A point or a line has no plane.
    flat.filter(|&axis| (0..3).filter(|&other| other != axis).all(|other| extent[other] > 0.0))
}

fn shifted(positions: &[[f32; 3]], shift: DVec3) -> Vec<[f32; 3]> {
    let shift = shift.as_vec3().to_array();
    positions.iter().map(|p| std::array::from_fn(|axis| p[axis] + shift[axis])).collect()
}

fn members<T: Copy>(values: &[T], chosen: &[bool]) -> Vec<T> {
    values.iter().zip(chosen).filter(|(_, chosen)| **chosen).map(|(value, _)| *value).collect()
}

#[expect(clippy::too_many_arguments, reason = "reads the survey's state and writes two lists")]
fn choose_spacing(
    view: &View,
    liquid: &[bool],
    points: &[[f32; 3]],
    flat_axis: Option<usize>,
    options: &SeriesOptions,
    choices: &mut Vec<Choice>,
    flaws: &mut Flaws,
    cancel: &Cancel,
) -> Result<(f64, SpacingSource), Error> {
    if let Some(spacing) = options.spacing {
        return Ok((spacing, SpacingSource::User));
    }
    let estimate = spacing::estimate(points, flat_axis);
    let dimensions = if flat_axis.is_some() { 2.0 } else { 3.0 };
    if let Some(spacing) = from_mass(view, liquid, dimensions, cancel)? {
        // Mass in another unit than density and coordinates would be off by a power of ten.
        let plausible = (spacing / estimate.spacing - 1.0).abs() < 0.2;
        if plausible || estimate.doubt.is_some() {
            let reason = "(median mass / rest density)^(1/d)".into();
            choices.push(choice("spacing", format!("{spacing:.6}"), reason, "--spacing"));
            return Ok((spacing, SpacingSource::MassAndDensity));
        }
    }
    if let Some(reason) = estimate.doubt {
        flaws.add(Flaw::SpacingUncertain { reason });
    }
    let reason = "estimated from the local density of sampled particles".into();
    choices.push(choice("spacing", format!("{:.6}", estimate.spacing), reason, "--spacing"));
    Ok((estimate.spacing, SpacingSource::Estimate))
}

/// Spacing from mass and density where the file has both. The rest density is the upper quartile over all particles: a
/// particle's own density falls to a third at a free surface.
fn from_mass(view: &View, liquid: &[bool], dimensions: f64, cancel: &Cancel) -> Result<Option<f64>, Error> {
    let mass = names::find(&view.frame, names::MASS, 1);
    let density = names::find(&view.frame, names::DENSITY, 1);
    let (Some(mass), Some(density)) = (mass, density) else { return Ok(None) };
    let quantile = |attribute, q: f64| -> Result<Option<f64>, Error> {
        let mut values = members(&view.frame.values(attribute, &ToF32, cancel)?, liquid);
        values.retain(|v| v.is_finite() && *v > 0.0);
        values.sort_by(f32::total_cmp);
        let index = ((values.len().max(1) - 1) as f64 * q) as usize;
        Ok(values.get(index).map(|v| f64::from(*v)))
    };
    let (Some(mass), Some(density)) = (quantile(mass, 0.5)?, quantile(density, 0.75)?) else {
        return Ok(None);
    };
    Ok(Some((mass / density).powf(1.0 / dimensions)))
}

fn choose_radius(spacing: f64, options: &SeriesOptions, choices: &mut Vec<Choice>) -> (f64, RadiusChoice) {
    if let Some(radius) = options.radius {
        return (radius, RadiusChoice::User);
    }
    let radius = DEFAULT_RADIUS_PER_SPACING * spacing;
    let reason = format!("{DEFAULT_RADIUS_PER_SPACING} of the spacing");
    choices.push(choice("radius", format!("{radius:.6}"), reason, "--radius"));
    (radius, RadiusChoice::FromSpacing)
}

fn guess_up(
    first: &View,
    last: Option<&View>,
    liquid: &[bool],
    points: &[[f32; 3]],
    spacing: f32,
    flat_axis: Option<usize>,
    cancel: &Cancel,
) -> Result<up::Guess, Error> {
    if flat_axis.is_none() {
        if let Some(guess) = up::from_attributes(&first.frame, &first.positions, liquid, cancel)? {
            return Ok(guess);
        }
        if let Some(last) = last
            && let Some(guess) = up::from_attributes(&last.frame, &last.positions, &last.water, cancel)?
        {
            return Ok(guess);
        }
    }
    // Splashes are in the last frame rather than in the first.
    let shape = match last {
        Some(last) => up::from_shape(&members(&last.positions, &last.water), spacing, flat_axis),
        None => up::from_shape(points, spacing, flat_axis),
    };
    Ok(shape)
}
