//! Selections that match nothing.

use meniscus_core::{Cancel, Choice};

use super::sets::{Plans, SetSource};
use super::survey::choice;
use super::view::View;
use crate::expression::Expression;
use crate::{Error, SeriesOptions};

/// Refuses a selection of the water, and points out one of another set, that matches no particle of `view`.
pub(super) fn describe(
    view: &View,
    plans: &Plans,
    options: &SeriesOptions,
    choices: &mut Vec<Choice>,
    cancel: &Cancel,
) -> Result<(), Error> {
    if view.is_empty() {
        return Ok(());
    }
    for (index, plan) in plans.iter().enumerate() {
        let (SetSource::Rest(Some(expression)) | SetSource::Selection(expression)) = &plan.source else {
            continue;
        };
        // A set may also be without particles because another one takes them all.
        if view.has_members(index) || view.frame.has_match(expression, cancel)? {
            continue;
        }
        let message = no_match(view, expression, cancel)?;
        if plan.name == "water" {
            return Err(Error::usage(message));
        }
        let spec = options.sets.iter().find(|spec| spec.name == plan.name);
        let flag = spec.map_or_else(String::new, |spec| format!("--set \"{}={}\"", spec.name, spec.pattern));
        choices.push(choice(&format!("set {}", plan.name), "no particle".into(), message, &flag));
    }
    Ok(())
}

/// Says what the filter leaves out of `view`; refuses one that leaves nothing.
pub(super) fn describe_filter(
    view: &View,
    plans: &Plans,
    options: &SeriesOptions,
    choices: &mut Vec<Choice>,
    cancel: &Cancel,
) -> Result<(), Error> {
    let count = |mask: &[bool]| mask.iter().filter(|taken| **taken).count();
    let points = view.frame.points;
    if let Some(mask) = plans.filter.without_ghosts(&view.frame, cancel)? {
        let value = format!("{} of {points} points left out", points - count(&mask));
        let reason = "the file marks them as copies of another process' points, or hidden".into();
        choices.push(choice("ghosts", value, reason, "--keep-ghosts"));
    }
    let limited = options.region.is_some() || options.every.is_some_and(|every| every > 1);
    if !limited || view.is_empty() {
        return Ok(());
    }
    let Some(filter) = plans.filter.of(&view.frame, cancel)? else { return Ok(()) };
    let mut taken = 0;
    for block in view.frame.blocks() {
        taken += count(&filter.block(&block, cancel)?);
    }
    if taken == 0 {
        let low = view.origin + view.bounds.min.as_dvec3();
        let high = view.origin + view.bounds.max.as_dvec3();
        return Err(Error::usage(format_args!(
            "--box and --every leave none of {points} particles; they lie in x {} to {}, y {} to {}, z {} to {}",
            low.x, high.x, low.y, high.y, low.z, high.z
        )));
    }
    if let Some(every) = options.every.filter(|every| *every > 1) {
        let by = view.frame.id_attribute().map_or("their index in the file", |ids| ids.name.as_str());
        let reason = format!("every {every}th by {by}, each stands for {every} of them");
        choices.push(choice("particles", format!("{taken} of {points}"), reason, "--every"));
    }
    Ok(())
}

fn no_match(view: &View, expression: &Expression, cancel: &Cancel) -> Result<String, Error> {
    let values = view.frame.describe_values(expression, cancel)?;
    Ok(format!(
        "the selection {:?} matches none of {} particles{values}",
        expression.text(),
        view.frame.points
    ))
}
