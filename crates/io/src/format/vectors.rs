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
    // Longer lists of numbered properties are none, nor is what comes later in one: 10, 11, 12.
    let is_in_list = stem.ends_with(|last: char| last.is_ascii_digit())
        || properties.get(3).is_some_and(|next| next.name.strip_suffix('3') == Some(stem));
    let is_one_type = three.iter().all(|property| property.ty == three[0].ty);
    (is_one_type && !is_in_list).then(|| stem.trim_end_matches(['_', '.', '-', ':', ' ']).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_are_told_by_their_names() {
        let names_of = |names: &[&str]| -> Vec<String> {
            let property = |name: &&str| Property { name: (*name).into(), ty: ScalarType::F32 };
            let properties: Vec<Property> = names.iter().map(property).collect();
            groups(&properties)
                .into_iter()
                .map(|group| format!("{}/{}", group.name, group.members.len()))
                .collect()
        };
        assert_eq!(names_of(&["x", "y", "z", "nx", "ny", "nz", "a"]), ["/3", "n/3", "a/1"]);
        assert_eq!(names_of(&["Points:0", "Points:1", "Points:2"]), ["Points/3"]);
        assert_eq!(names_of(&["x", "y", "w", "V_X", "V_Y"]), ["x/1", "y/1", "w/1", "V_X/1", "V_Y/1"]);
        assert_eq!(names_of(&["c0", "c1", "c2", "c3"]), ["c0/1", "c1/1", "c2/1", "c3/1"]);
        assert_eq!(names_of(&["c10", "c11", "c12"]), ["c10/1", "c11/1", "c12/1"]);
    }
}
