//! What holds for a whole series, from its first usable frame and, where that says too little, its last.

use std::cell::LazyCell;
use std::ops::Deref;
use std::path::PathBuf;

use meniscus_core::{
    Cancel, Choice, DEFAULT_RADIUS_PER_SPACING, Flaw, Flaws, RadiusChoice, SeriesSpace, SpacingSource,
};

use super::sets::SetPlan;
use super::view::View;
use crate::analysis::spacing::Estimate;
use crate::analysis::walls::Walls;
use crate::analysis::{names, spacing, up, walls};
use crate::discover::TimeStep;
use crate::scalar::ToF32;
use crate::{Error, SeriesOptions};

pub(super) struct Survey {
    pub space: SeriesSpace,
    pub choices: Vec<Choice>,
    pub flaws: Flaws,
    pub bytes_per_file_byte: f64,
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
    // The last frame is only read where the first says too little. Its own errors are met again when it is drawn.
    let last = LazyCell::new(|| {
        let mut later = steps.iter().skip(index + 1).rev();
        later.find_map(|step| View::open(step, plans, &cancel).ok().filter(|view| !view.is_empty()))
    });
    let mut choices = Vec::new();
    describe_parts(&view, &mut choices, &cancel);
    let flat_axis = view.flat_axis();
    if let Some(axis) = flat_axis {
        flaws.add(Flaw::Planar { axis: ['x', 'y', 'z'][axis] });
    }
    let walls = find_walls(&view, &last, &cancel)?;
    if let Some(walls) = &walls {
        flaws.add(Flaw::WallsDrawnAsWater { flag: walls.flag.clone() });
    }
    let members = walls.as_ref().map(|walls| walls.members.as_slice());
    let sample = view.sample(members);
    let (spacing, spacing_source) = match options.spacing {
        Some(spacing) => (spacing, SpacingSource::User),
        None => {
            let estimate = spacing::estimate(&view.liquid(members), flat_axis);
            choose_spacing(&view, &sample, estimate, flat_axis, &mut choices, &mut flaws, &cancel)?
        }
    };
    let (radius, radius_choice) = choose_radius(spacing, options, &mut choices);
    let up = match options.up {
        Some(axis) => axis,
        None => {
            let guess = guess_up(&view, &last, &sample, spacing as f32, flat_axis, &cancel)?;
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

/// Walls among the default set. Where there are kinds of particles, the last frame tells which of them move.
fn find_walls(
    view: &View,
    last: &impl Deref<Target = Option<View>>,
    cancel: &Cancel,
) -> Result<Option<Walls>, Error> {
    if !walls::has_kinds(&view.frame) {
        return Ok(None);
    }
    let selected: Vec<bool> = (0..view.positions.len()).map(|i| view.is_water(i)).collect();
    let same_particles = last.as_ref().filter(|last| last.positions.len() == view.positions.len());
    let later = same_particles.map(|last| last.positions_from(view.origin));
    walls::find(&view.frame, &view.positions, &selected, later.as_deref(), cancel)
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

fn choose_spacing(
    view: &View,
    sample: &[usize],
    estimate: Estimate,
    flat_axis: Option<usize>,
    choices: &mut Vec<Choice>,
    flaws: &mut Flaws,
    cancel: &Cancel,
) -> Result<(f64, SpacingSource), Error> {
    let dimensions = if flat_axis.is_some() { 2.0 } else { 3.0 };
    if let Some(spacing) = from_mass(view, sample, dimensions, cancel)? {
        // Mass in another unit than density and coordinates would be off by a power of ten.
        let plausible = (spacing / estimate.spacing - 1.0).abs() < 0.2;
        if plausible || estimate.doubt.is_some() {
            let reason = "from the median mass and a rest density, the upper quartile of the density".into();
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
fn from_mass(view: &View, sample: &[usize], dimensions: f64, cancel: &Cancel) -> Result<Option<f64>, Error> {
    let mass = names::find(&view.frame, names::MASS, 1);
    let density = names::find(&view.frame, names::DENSITY, 1);
    let (Some(mass), Some(density)) = (mass, density) else { return Ok(None) };
    let quantile = |attribute, q: f64| -> Result<Option<f64>, Error> {
        let values = view.frame.values(attribute, &ToF32, cancel)?;
        let positive = |v: &f32| v.is_finite() && *v > 0.0;
        let mut values: Vec<f32> = sample.iter().map(|&i| values[i]).filter(positive).collect();
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
    last: &impl Deref<Target = Option<View>>,
    sample: &[usize],
    spacing: f32,
    flat_axis: Option<usize>,
    cancel: &Cancel,
) -> Result<up::Guess, Error> {
    if flat_axis.is_none()
        && let Some(guess) = up::from_attributes(&first.frame, &first.positions, sample, cancel)?
    {
        return Ok(guess);
    }
    // At the start pressure and velocity are often zero, and there are no splashes.
    let Some(last) = last.as_ref() else {
        return Ok(up::from_shape(&first.positions, sample, spacing, flat_axis));
    };
    let sample = last.sample(None);
    if flat_axis.is_none()
        && let Some(guess) = up::from_attributes(&last.frame, &last.positions, &sample, cancel)?
    {
        return Ok(guess);
    }
    Ok(up::from_shape(&last.positions, &sample, spacing, flat_axis))
}
