//! Which particles form which set.

use std::ops::Deref;
use std::path::Path;

use meniscus_core::{Cancel, Look};

use crate::discover::{TimeStep, discover};
use crate::expression::Expression;
use crate::filter::Filter;
use crate::frame_data::FrameData;
use crate::{Error, IoMode, SeriesOptions};

/// Where the particles of a set come from.
pub(crate) enum SetSource {
    /// What no other set takes, further restricted by the selection.
    Rest(Option<Expression>),
    /// The input's particles that the selection takes.
    Selection(Expression),
    /// A series of its own.
    Files(Vec<TimeStep>),
}

/// A set of the series.
pub(crate) struct SetPlan {
    pub name: String,
    pub look: Look,
    pub source: SetSource,
}

/// All sets of a series, and what is left out of its input before the sets are formed.
pub(crate) struct Plans {
    pub sets: Vec<SetPlan>,
    pub filter: Filter,
    pub io_mode: IoMode,
}

impl Deref for Plans {
    type Target = [SetPlan];

    fn deref(&self) -> &[SetPlan] {
        &self.sets
    }
}

/// The sets that `options` ask for, the default one first.
pub(super) fn plan(options: &SeriesOptions) -> Result<Plans, Error> {
    let mut plans = Vec::new();
    if options.sets.iter().all(|spec| spec.name != "water") {
        let selection = options.where_expr.as_deref().map(Expression::parse).transpose()?;
        plans.push(SetPlan { name: "water".into(), look: Look::Water, source: SetSource::Rest(selection) });
    } else if options.where_expr.is_some() {
        return Err(Error::usage(
            "--where selects the default set, which --set water=... replaces; give one of them",
        ));
    }
    for spec in &options.sets {
        let (name, look) = (spec.name.clone(), spec.look);
        plans.push(SetPlan { name, look, source: source(&spec.pattern)? });
    }
    Ok(Plans { sets: plans, filter: Filter::new(options), io_mode: options.io_mode })
}

/// A pattern with a comparison is a selection, unless it names something on disk.
fn source(pattern: &str) -> Result<SetSource, Error> {
    let on_disk = Path::new(pattern).exists();
    let compares = pattern.contains(['<', '>', '=']) || pattern.contains(" in ") || pattern.contains(" in(");
    if compares && !on_disk {
        return Ok(SetSource::Selection(Expression::parse(pattern)?));
    }
    Ok(SetSource::Files(discover(Path::new(pattern))?.steps))
}

/// Set index of every point that belongs to no set of the input.
pub(crate) const NO_SET: u8 = u8::MAX;

/// The set of every point of the input's `frame`; `None` when the first set takes all. A point that several selections take
/// goes to the first of them.
pub(crate) fn assign(plans: &Plans, frame: &FrameData, cancel: &Cancel) -> Result<Option<Vec<u8>>, Error> {
    let mask = plans.filter.mask(frame, cancel)?;
    let trivial = |plan: &SetPlan| matches!(plan.source, SetSource::Rest(None) | SetSource::Files(_));
    let first_takes_all =
        plans.iter().all(trivial) && matches!(plans.first().map(|p| &p.source), Some(SetSource::Rest(None)));
    if first_takes_all {
        return Ok(mask.map(|mask| only(&mask)));
    }
    let mut assigned = vec![NO_SET; frame.points];
    let is_free = |point: usize, set: u8| set == NO_SET && mask.as_ref().is_none_or(|mask| mask[point]);
    let mut rest = None;
    for (index, plan) in plans.iter().enumerate() {
        match &plan.source {
            SetSource::Selection(expression) => {
                let selected = frame.select(expression, cancel)?;
                for (point, (set, selected)) in assigned.iter_mut().zip(selected).enumerate() {
                    if selected && is_free(point, *set) {
                        *set = index as u8;
                    }
                }
            }
            SetSource::Rest(expression) => rest = Some((index, expression)),
            SetSource::Files(_) => {}
        }
    }
    if let Some((index, expression)) = rest {
        let selected = expression.as_ref().map(|e| frame.select(e, cancel)).transpose()?;
        for (point, set) in assigned.iter_mut().enumerate() {
            if is_free(point, *set) && selected.as_ref().is_none_or(|selected| selected[point]) {
                *set = index as u8;
            }
        }
    }
    Ok(Some(assigned))
}

/// The first set takes what `mask` takes.
pub(super) fn only(mask: &[bool]) -> Vec<u8> {
    mask.iter().map(|&taken| if taken { 0 } else { NO_SET }).collect()
}
