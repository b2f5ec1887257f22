//! Which particles form which set.

use std::ops::Deref;
use std::path::Path;

use meniscus_core::{Cancel, Look};

use crate::discover::{TimeStep, discover};
use crate::expression::Expression;
use crate::filter::{Filter, FrameFilter};
use crate::frame_data::{Block, FrameData, Selector};
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

/// Who goes to which set, tied to a frame. A point that several selections take goes to the first of them.
pub(crate) struct Assignment<'a> {
    filter: Option<FrameFilter<'a>>,
    /// What the sets take, those by selection first: index of the set, and which points may be in it.
    takers: Vec<(u8, Option<Selector<'a>>)>,
}

impl<'a> Assignment<'a> {
    /// How the points of the input's `frame` are shared out; `None` when the first set takes all.
    pub fn new(plans: &'a Plans, frame: &'a FrameData, cancel: &Cancel) -> Result<Option<Self>, Error> {
        let filter = plans.filter.of(frame, cancel)?;
        let (mut takers, mut rest) = (Vec::new(), None);
        for (index, plan) in plans.iter().enumerate() {
            let index = index as u8;
            match &plan.source {
                SetSource::Selection(expression) => takers.push((index, Some(frame.selector(expression)?))),
                SetSource::Rest(expression) => {
                    let selector = expression.as_ref().map(|expression| frame.selector(expression));
                    rest = Some((index, selector.transpose()?));
                }
                SetSource::Files(_) => {}
            }
        }
        takers.extend(rest);
        let all_to_first = filter.is_none() && matches!(takers.as_slice(), [(0, None)]);
        Ok(if all_to_first { None } else { Some(Self { filter, takers }) })
    }

    /// The points of `frame`, of a set's own files, that are no ghosts go to the first set; `None` when none is one.
    pub fn without_ghosts(
        filter: &Filter,
        frame: &'a FrameData,
        cancel: &Cancel,
    ) -> Result<Option<Self>, Error> {
        let filter = filter.ghosts_only().of(frame, cancel)?;
        Ok(filter.map(|filter| Self { filter: Some(filter), takers: vec![(0, None)] }))
    }

    /// The set of every point of `block`.
    pub fn block(&self, block: &Block, cancel: &Cancel) -> Result<Vec<u8>, Error> {
        let mut sets = vec![NO_SET; block.len()];
        let mask = self.filter.as_ref().map(|filter| filter.block(block, cancel)).transpose()?;
        for (index, selector) in &self.takers {
            let selected = selector.as_ref().map(|selector| selector.block(block, cancel)).transpose()?;
            let may = |marks: &Option<Vec<bool>>, i: usize| marks.as_ref().is_none_or(|marks| marks[i]);
            for (i, set) in sets.iter_mut().enumerate() {
                if *set == NO_SET && may(&mask, i) && may(&selected, i) {
                    *set = *index;
                }
            }
        }
        Ok(sets)
    }
}

/// The set of every point of the input's `frame`; `None` when the first set takes all.
pub(super) fn assign(plans: &Plans, frame: &FrameData, cancel: &Cancel) -> Result<Option<Vec<u8>>, Error> {
    let Some(assignment) = Assignment::new(plans, frame, cancel)? else { return Ok(None) };
    let mut sets = Vec::with_capacity(frame.points);
    for block in frame.blocks() {
        sets.extend(assignment.block(&block, cancel)?);
    }
    Ok(Some(sets))
}

/// How many points of the input's `frame` are in each set.
pub(crate) fn count(plans: &Plans, frame: &FrameData, cancel: &Cancel) -> Result<Vec<usize>, Error> {
    let mut counts = vec![0; plans.len()];
    let Some(assignment) = Assignment::new(plans, frame, cancel)? else {
        counts[0] = frame.points;
        return Ok(counts);
    };
    for block in frame.blocks() {
        for set in assignment.block(&block, cancel)? {
            if let Some(count) = counts.get_mut(usize::from(set)) {
                *count += 1;
            }
        }
    }
    Ok(counts)
}
