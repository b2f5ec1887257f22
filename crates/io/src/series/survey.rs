//! What holds for a whole series, from its first usable frame and, where that says too little, its last.

use std::cell::LazyCell;
use std::ops::Deref;
use std::path::PathBuf;

use meniscus_core::{Cancel, Choice, Flaw, Flaws, Look, SeriesSpace};

use super::lengths::Liquid;
use super::sets::Plans;
use super::sizes::{self, Sizes};
use super::view::View;
use super::{companions, lengths, parts, selections};
use crate::analysis::others::{self, Other, Others, Untold};
use crate::analysis::{names, up};
use crate::array::check;
use crate::discover::TimeStep;
use crate::{Error, IoMode, SeriesOptions, SetSpec, input_file};

pub(super) struct Survey {
    pub space: SeriesSpace,
    /// Largest coordinate that is drawn, world.
    pub reach: f32,
    pub choices: Vec<Choice>,
    pub flaws: Flaws,
    pub bytes_per_file_byte: f64,
    pub has_ids: bool,
    pub velocity: Option<String>,
    pub sizes: Option<Sizes>,
    /// Hidden sets of what is in the default set but no water for sure, unless the user says what that set is.
    pub own_sets: Vec<(SetSpec, Choice)>,
}

pub(super) fn file_bytes(files: &[PathBuf]) -> u64 {
    files.iter().filter_map(|file| std::fs::metadata(file).ok()).map(|meta| meta.len()).sum()
}

pub(super) fn survey(
    steps: &[TimeStep],
    plans: &Plans,
    options: &SeriesOptions,
    cancel: &Cancel,
) -> Result<Survey, Error> {
    let mut flaws = Flaws::default();
    let (view, index) = first_view(steps, plans, cancel)?;
    // The last frame is only read where the first says too little. Its own errors are met again when it is drawn.
    let last = LazyCell::new(|| {
        let mut later = steps.iter().skip(index + 1).rev();
        later.find_map(|step| View::open(step, plans, cancel).ok().filter(|view| !view.is_empty()))
    });
    let mut choices = Vec::new();
    parts::describe(&view, steps, plans, &mut choices, cancel);
    companions::describe(steps, plans, &mut choices);
    selections::describe_filter(&view, plans, options, &mut choices, cancel)?;
    selections::describe(&view, plans, options, &mut choices, cancel)?;
    let flat_axis = view.flat_axis();
    if let Some(axis) = flat_axis {
        flaws.add(Flaw::Planar { axis: ['x', 'y', 'z'][axis] });
    }
    let others = find_others(&view, &last, cancel)?;
    let own_sets = others.found.iter().filter_map(|other| own_set(other, &view, options)).collect();
    for Other { name, flag, .. } in &others.found {
        flaws.add(Flaw::OthersDrawnAsWater { what: name, flag: flag.clone() });
    }
    if let Some(Untold { list, flag }) = others.untold.filter(|_| options.where_expr.is_none()) {
        let value = format!("{list}, all drawn as water");
        choices.push(choice("kinds", value, "nothing tells which of them are water".into(), &flag));
    }
    let members = Others::members(&others.found, view.positions.len());
    let members = members.as_deref();
    let sample = view.sample(members);
    let sizes = sizes::choose(&view, &sample, options, &mut choices, cancel)?;
    let liquid = Liquid { view: &view, walls: members, sizes: sizes.as_ref() };
    let lengths = lengths::choose(liquid, &last, options, &mut choices, &mut flaws, cancel)?;
    let up = match options.up {
        Some(axis) => axis,
        None => {
            let guess = guess_up(&view, &last, &sample, lengths.spacing as f32, flat_axis, cancel)?;
            choices.push(choice("up axis", guess.axis.letter().to_string(), guess.reason, "--up"));
            guess.axis
        }
    };
    let metres_per_unit = options.metres_per_unit.unwrap_or_else(|| {
        choices.push(choice("unit", "m".into(), "the file does not state one".into(), "--unit"));
        1.0
    });
    describe_io(&steps[index], plans, &mut choices);
    check(cancel)?;
    let has_ids = view.frame.id_attribute().is_some();
    let per_particle = 12 + if has_ids { 8 } else { 0 } + if sizes.is_some() { 4 } else { 0 };
    let bytes = view.positions.len() * per_particle;
    Ok(Survey {
        has_ids,
        velocity: names::find(&view.frame, names::VELOCITY, 3).map(|attribute| attribute.name.clone()),
        bytes_per_file_byte: bytes as f64 / file_bytes(&steps[index].files).max(1) as f64,
        reach: view.reach(lengths.spacing),
        space: SeriesSpace {
            origin: view.origin,
            spacing: lengths.spacing,
            spacing_source: lengths.spacing_source,
            radius: lengths.radius,
            radius_choice: lengths.radius_choice,
            up,
            metres_per_unit,
        },
        choices,
        flaws,
        sizes,
        own_sets,
    })
}

/// What is no water in the default set. Where there are kinds of particles, the last frame tells which of them move.
fn find_others(
    view: &View,
    last: &impl Deref<Target = Option<View>>,
    cancel: &Cancel,
) -> Result<Others, Error> {
    let kinds_of = Some(last).filter(|_| others::has_kinds(&view.frame));
    let same_particles = kinds_of.and_then(|last| last.as_ref());
    let same_particles = same_particles.filter(|last| last.positions.len() == view.positions.len());
    let later = same_particles.map(|last| |i: usize| last.position_from(view.origin, i));
    let later = later.as_ref().map(|later| later as &dyn Fn(usize) -> [f32; 3]);
    others::find(&view.frame, &view.positions, |i| view.is_water(i), later, cancel)
}

/// The hidden set of `other`, and what is said of it, if it is no water for sure and the user leaves open what the default set is.
fn own_set(other: &Other, view: &View, options: &SeriesOptions) -> Option<(SetSpec, Choice)> {
    let is_taken = |name: &str| options.sets.iter().any(|spec| spec.name == name);
    let is_said = options.where_expr.is_some() || is_taken("water") || is_taken(other.name);
    if options.keep_others || is_said || !view.has_members(0) {
        return None;
    }
    let reason = other.certain_as.clone()?;
    let spec = SetSpec { name: other.name.into(), pattern: other.pattern.clone(), look: Look::Hidden };
    let count = other.members.iter().filter(|member| **member).count();
    let value = format!("{count} of {} particles, not drawn", other.members.len());
    let flag = format!("--set \"{}={}:{}\"", spec.name, spec.pattern, other.look);
    Some((spec, choice(other.name, value, reason, &flag)))
}

/// Says how the first frame's files come into memory, unless the user has said.
fn describe_io(step: &TimeStep, plans: &Plans, choices: &mut Vec<Choice>) {
    if plans.io_mode != IoMode::Auto {
        return;
    }
    let reason = step
        .files
        .iter()
        .find_map(|file| input_file::reason_to_read(file, &std::fs::metadata(file).ok()?, plans.io_mode));
    let (value, reason) = match reason {
        Some(reason) => ("read in blocks", reason),
        None => ("mapped", "local files at rest"),
    };
    choices.push(choice("files", value.into(), reason.into(), "--io"));
}

pub(super) fn choice(what: &str, value: String, reason: String, flag: &str) -> Choice {
    Choice { what: what.into(), value, reason, flag: flag.into() }
}

/// The first frame with particles, else the first that can be read at all. What is wrong with the others is said
/// when they are drawn.
fn first_view(steps: &[TimeStep], plans: &Plans, cancel: &Cancel) -> Result<(View, usize), Error> {
    let mut empty = None;
    let mut first_error = None;
    for (index, step) in steps.iter().enumerate() {
        match View::open(step, plans, cancel) {
            Ok(view) if !view.is_empty() => return Ok((view, index)),
            Ok(view) => empty = empty.or(Some((view, index))),
            Err(e @ (Error::Usage { .. } | Error::Expression(_) | Error::Cancelled)) => return Err(e),
            Err(e) => first_error = first_error.or(Some(e)),
        }
    }
    match (empty, first_error) {
        (Some(found), _) => Ok(found),
        (None, Some(error)) => Err(error),
        (None, None) => Err(Error::usage("the series has no frame")),
    }
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
