//! Selections that match nothing.

use meniscus_core::{Cancel, Choice};

use super::sets::{SetPlan, SetSource};
use super::survey::choice;
use super::view::View;
use crate::expression::Expression;
use crate::{Error, SeriesOptions};

/// Refuses a selection of the water, and points out one of another set, that matches no particle of `view`.
pub(super) fn describe(
    view: &View,
    plans: &[SetPlan],
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
        if view.has_members(index) || view.frame.select(expression, cancel)?.contains(&true) {
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

fn no_match(view: &View, expression: &Expression, cancel: &Cancel) -> Result<String, Error> {
    let values = view.frame.describe_values(expression, cancel)?;
    Ok(format!(
        "the selection {:?} matches none of {} particles{values}",
        expression.text(),
        view.frame.points
    ))
}
