//! Particles told apart by an attribute for kinds: few whole numbers, also where they are stored as floats.

use meniscus_core::Cancel;

use super::names;
use crate::Error;
use crate::frame_data::{AttributeInfo, FrameData};
use crate::info::ValueCounts;
use crate::scalar::ToF64;

/// The group of particles that belong to none; there are at most as many groups as [`ValueCounts`] lists.
const NO_GROUP: u8 = u8::MAX;

/// Groups of particles with the same value of an attribute, in the order of the values.
pub(crate) struct Groups {
    /// The attribute.
    name: String,
    values: Vec<i64>,
    /// Particles of each.
    pub sizes: Vec<u64>,
    of: Vec<u8>,
}

/// The attributes that may tell kinds of particles apart; names that mean it most likely come first.
pub(crate) fn attributes(frame: &FrameData) -> impl Iterator<Item = &AttributeInfo> {
    names::KIND.iter().flat_map(|name| {
        let fits = |a: &&AttributeInfo| a.components == 1 && names::is_kind(&a.name, name);
        frame.attributes().iter().filter(fits)
    })
}

impl Groups {
    /// The groups that `attribute` makes of the `selected` particles; `None` unless there are at least two, and few.
    pub fn by(
        attribute: &AttributeInfo,
        frame: &FrameData,
        selected: &impl Fn(usize) -> bool,
        cancel: &Cancel,
    ) -> Result<Option<Self>, Error> {
        let array = frame.attribute_array(attribute)?;
        let mut counts = ValueCounts::default();
        for block in frame.blocks() {
            for (i, value) in array.values(&block, &ToF64, cancel)?.into_iter().enumerate() {
                if !selected(block.first + i) {
                    continue;
                }
                // Shares of phases, sizes and the like: measured, not counted.
                if value.fract() != 0.0 {
                    return Ok(None);
                }
                counts.add(value);
            }
            if counts.are_too_many() {
                return Ok(None);
            }
        }
        let Some(counts) = counts.into_list().filter(|counts| counts.len() > 1) else { return Ok(None) };
        let values: Vec<i64> = counts.iter().map(|count| count.value).collect();
        let mut of = Vec::with_capacity(frame.points);
        for block in frame.blocks() {
            let numbers = array.values(&block, &ToF64, cancel)?;
            of.extend(numbers.into_iter().enumerate().map(|(i, value)| {
                let group = values.iter().position(|&v| v == value as i64);
                group.filter(|_| selected(block.first + i)).map_or(NO_GROUP, |group| group as u8)
            }));
        }
        let sizes = counts.iter().map(|count| count.count).collect();
        Ok(Some(Self { name: attribute.name.clone(), values, sizes, of }))
    }

    /// How many groups there are.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// The group of particle `i`, if it is in one.
    pub fn of(&self, i: usize) -> Option<usize> {
        Some(usize::from(self.of[i])).filter(|&group| group < self.len())
    }

    /// Which particles are in the groups that `takes` marks.
    pub fn members(&self, takes: &[bool]) -> Vec<bool> {
        (0..self.of.len()).map(|i| self.of(i).is_some_and(|group| takes[group])).collect()
    }

    /// The selection of the groups that `takes` marks, of which there is at least one.
    pub fn selection(&self, takes: &[bool]) -> String {
        let taken = self.values.iter().zip(takes).filter(|(_, takes)| **takes);
        let values: Vec<String> = taken.map(|(value, _)| value.to_string()).collect();
        let name = quoted(&self.name);
        match values.as_slice() {
            [one] => format!("{name} == {one}"),
            several => format!("{name} in ({})", several.join(", ")),
        }
    }
}

/// A name as the expression grammar wants it.
pub(super) fn quoted(name: &str) -> String {
    let bare = name.chars().all(|c| c.is_alphanumeric() || c == '_')
        && !name.starts_with(|c: char| c.is_ascii_digit());
    if bare { name.to_owned() } else { format!("\"{name}\"") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn selections_name_what_they_take() {
        let groups =
            Groups { name: "my type".into(), values: vec![0, 1, 3], sizes: vec![1; 3], of: vec![1, 255, 2] };
        assert_eq!(groups.selection(&[false, true, true]), "\"my type\" in (1, 3)");
        assert_eq!(groups.selection(&[false, false, true]), "\"my type\" == 3");
        assert_eq!(groups.members(&[true, true, false]), [true, false, false]);
    }

    #[test]
    fn flags_quote_odd_names() {
        assert_eq!([quoted("type"), quoted("my type"), quoted("2nd")], ["type", "\"my type\"", "\"2nd\""]);
    }
}
