//! Expressions over the points of a frame.

use meniscus_core::Cancel;
use rayon::prelude::*;

use super::{AttributeInfo, Block, FrameArray, FrameData};
use crate::Error;
use crate::expression::{Column, Expression, Part};
use crate::info::ValueCounts;
use crate::scalar::ToF64;

/// An expression tied to a frame.
pub(crate) struct Selector<'a> {
    expression: &'a Expression,
    /// What the columns read, each once.
    sources: Vec<Source<'a>>,
    /// Source and part of every column.
    columns: Vec<(usize, Part)>,
}

enum Source<'a> {
    Coordinates(FrameArray<'a>),
    Attribute(&'a AttributeInfo, FrameArray<'a>),
    /// The index in the frame.
    Index,
}

/// A source's values in a block.
struct Values {
    values: Vec<f64>,
    components: usize,
}

impl Values {
    fn of(&self, point: usize, part: Part) -> f64 {
        let tuple = &self.values[point * self.components..(point + 1) * self.components];
        match (part, tuple) {
            (Part::Component(index), _) => tuple[index],
            (Part::Whole, [value]) => *value,
            (Part::Whole, _) => tuple.iter().map(|v| v * v).sum::<f64>().sqrt(),
        }
    }
}

impl<'a> Selector<'a> {
    pub(super) fn new(frame: &'a FrameData, expression: &'a Expression) -> Result<Self, Error> {
        let mut selector = Self { expression, sources: Vec::new(), columns: Vec::new() };
        for column in expression.columns() {
            let source = selector.source(frame, column)?;
            selector.columns.push(source);
        }
        Ok(selector)
    }

    fn source(&mut self, frame: &'a FrameData, column: &Column) -> Result<(usize, Part), Error> {
        if let Some(attribute) = frame.attribute(&column.name) {
            let components = attribute.components;
            if let Part::Component(index) = column.part
                && index >= components
            {
                let message = format!("{:?} has {components} components, the first is 0", attribute.name);
                return Err(self.expression.error_at(column, message).into());
            }
            return Ok((self.attribute(frame, attribute)?, column.part));
        }
        let axis = ["x", "y", "z"].iter().position(|axis| column.name.eq_ignore_ascii_case(axis));
        match (axis, column.part) {
            (Some(axis), Part::Whole) => {
                let index = self.find_or_add(
                    |source| matches!(source, Source::Coordinates(_)),
                    || Ok(Source::Coordinates(frame.positions_array()?)),
                )?;
                Ok((index, Part::Component(axis)))
            }
            (None, Part::Whole) if column.name.eq_ignore_ascii_case("id") => {
                let index = match frame.id_attribute() {
                    Some(ids) => self.attribute(frame, ids)?,
                    None => {
                        self.find_or_add(|source| matches!(source, Source::Index), || Ok(Source::Index))?
                    }
                };
                Ok((index, Part::Whole))
            }
            _ => {
                // Where the file has no id of that name, the index in the file answers to it.
                let id = if frame.id_attribute().is_some_and(|a| a.name == "id") { "" } else { "id, " };
                let names = frame.attribute_names();
                let message = format!("no attribute {:?}; there are: x, y, z, {id}{names}", column.name);
                Err(self.expression.error_at(column, message).into())
            }
        }
    }

    fn attribute(&mut self, frame: &'a FrameData, attribute: &'a AttributeInfo) -> Result<usize, Error> {
        self.find_or_add(
            |source| matches!(source, Source::Attribute(known, _) if known.name == attribute.name),
            || Ok(Source::Attribute(attribute, frame.attribute_array(attribute)?)),
        )
    }

    fn find_or_add(
        &mut self,
        is_it: impl Fn(&Source<'a>) -> bool,
        make: impl FnOnce() -> Result<Source<'a>, Error>,
    ) -> Result<usize, Error> {
        if let Some(index) = self.sources.iter().position(is_it) {
            return Ok(index);
        }
        self.sources.push(make()?);
        Ok(self.sources.len() - 1)
    }

    /// Which points of `block` are selected.
    pub fn block(&self, block: &Block, cancel: &Cancel) -> Result<Vec<bool>, Error> {
        let values = self.values(block, cancel)?;
        let value = |point: usize, column: usize| {
            let (source, part) = self.columns[column];
            values[source].of(point, part)
        };
        let selected = |point: usize| self.expression.matches(&|column| value(point, column));
        Ok((0..block.len()).into_par_iter().with_min_len(1 << 10).map(selected).collect())
    }

    fn values(&self, block: &Block, cancel: &Cancel) -> Result<Vec<Values>, Error> {
        let of = |source: &Source<'_>| {
            Ok(match source {
                Source::Coordinates(array) | Source::Attribute(_, array) => {
                    Values { values: array.values(block, &ToF64, cancel)?, components: array.components }
                }
                Source::Index => {
                    let indices = block.first..block.first + block.len();
                    Values { values: indices.map(|index| index as f64).collect(), components: 1 }
                }
            })
        };
        self.sources.iter().map(of).collect()
    }

    /// What the quantities are in `frame`: `; type has the values 0, 1, 2`, `; z is from 0 to 2.5`.
    pub(super) fn describe(&self, frame: &FrameData, cancel: &Cancel) -> Result<String, Error> {
        let columns = self.expression.columns();
        let is_first = |i: usize| {
            let same = |other: &Column| (&other.name, other.part) == (&columns[i].name, columns[i].part);
            !columns[..i].iter().any(same)
        };
        let wanted: Vec<usize> = (0..columns.len()).filter(|i| is_first(*i)).collect();
        let mut ranges = vec![Range::default(); wanted.len()];
        for block in frame.blocks() {
            let values = self.values(&block, cancel)?;
            for (range, &column) in std::iter::zip(&mut ranges, &wanted) {
                let (source, part) = self.columns[column];
                (0..block.len()).for_each(|point| range.add(values[source].of(point, part)));
            }
        }
        let describe =
            |(range, column): (Range, usize)| format!("; {} {}", columns[column], range.describe());
        Ok(std::iter::zip(ranges, wanted).map(describe).collect())
    }
}

/// What values there are: the values themselves where they are few whole numbers, else their range.
#[derive(Clone, Default)]
struct Range {
    /// Finite values, low and high.
    limits: Option<(f64, f64)>,
    has_fractions: bool,
    counts: ValueCounts,
}

impl Range {
    fn add(&mut self, value: f64) {
        if !value.is_finite() {
            return;
        }
        self.limits =
            Some(self.limits.map_or((value, value), |(low, high)| (low.min(value), high.max(value))));
        self.has_fractions |= value.fract() != 0.0;
        self.counts.add(value);
    }

    fn describe(self) -> String {
        let few = if self.has_fractions { None } else { self.counts.into_list() };
        match (few.filter(|counts| !counts.is_empty()), self.limits) {
            (Some(counts), _) => {
                let list: Vec<String> = counts.iter().map(|count| count.value.to_string()).collect();
                format!("has the value{} {}", if list.len() == 1 { "" } else { "s" }, list.join(", "))
            }
            (None, Some((low, high))) => format!("is from {} to {}", low as f32, high as f32),
            (None, None) => "has no finite value".into(),
        }
    }
}
