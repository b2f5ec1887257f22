//! Columns and properties that are the components of vectors, told by their names.

use std::ops::Range;

use crate::scalar::ScalarType;

/// A number that every point has.
pub(crate) struct Property {
    pub name: String,
    pub ty: ScalarType,
}

/// Properties that make one array.
pub(crate) struct Group {
    pub name: String,
    pub members: Range<usize>,
}

/// Last letters of the names of a vector's components.
const COMPONENTS: [[char; 3]; 3] = [['x', 'y', 'z'], ['X', 'Y', 'Z'], ['0', '1', '2']];

/// The properties as arrays: three in a row of one type that differ in a last x, y, z or 0, 1, 2 are a vector, called by what they
/// have in common: just x, y, z by nothing.
pub(crate) fn groups(properties: &[Property]) -> Vec<Group> {
    let mut groups = Vec::new();
    let mut at = 0;
    while at < properties.len() {
        let vector = vector_at(&properties[at..]);
        let length = if vector.is_some() { 3 } else { 1 };
        let name = vector.unwrap_or_else(|| properties[at].name.clone());
        groups.push(Group { name, members: at..at + length });
        at += length;
    }
    groups
}

/// The name of the vector that `properties` begin with, if they do.
fn vector_at(properties: &[Property]) -> Option<String> {
    let three = properties.get(..3)?;
    let stem = COMPONENTS.into_iter().find_map(|letters| {
        let mut stems =
            std::iter::zip(three, letters).map(|(property, letter)| property.name.strip_suffix(letter));
        let first = stems.next()??;
        stems.all(|stem| stem == Some(first)).then_some(first)
    })?;
    let is_one_type = three.iter().all(|property| property.ty == three[0].ty);
    is_one_type.then(|| stem.trim_end_matches(['_', '.', '-', ':', ' ']).to_owned())
}
