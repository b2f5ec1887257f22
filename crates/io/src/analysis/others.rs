//! Particles in the same file that are not the water: walls, moving bodies, air.
//!
//! Each attribute for kinds divides what the ones before left; at last a density of two clusters does.

use meniscus_core::Cancel;

use super::gas;
use super::groups::{self, Groups};
use super::motion::{Later, Motion};
use super::walls;
use crate::Error;
use crate::frame_data::FrameData;

/// Particles that look like something other than water.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Other {
    /// What they are: the name of a set.
    pub name: &'static str,
    /// The look that shows them.
    pub look: &'static str,
    /// The flag that hides them, ready to paste.
    pub flag: String,
    /// The selection of them.
    pub pattern: String,
    /// Why they can be nothing else, if so.
    pub certain_as: Option<String>,
    /// Which particles they are.
    pub members: Vec<bool>,
}

/// What is found.
#[derive(Debug, Default)]
pub(crate) struct Others {
    pub found: Vec<Other>,
    /// Kinds that nothing tells apart, of which some may not be water.
    pub untold: Option<Untold>,
}

/// Several kinds of particles that may all be water, or not.
#[derive(Debug, PartialEq)]
pub(crate) struct Untold {
    /// All of them, with what is known.
    pub list: String,
    /// The flag that draws all but the most likely water as a solid.
    pub flag: String,
}

/// Kinds that are pointed out; more are rather numbers of processes or of bodies.
const MOST_UNTOLD: usize = 8;

impl Others {
    /// Which of `points` particles are among those `found`; `None` when nothing is found.
    pub fn members(found: &[Other], points: usize) -> Option<Vec<bool>> {
        let is_found = |i: usize| found.iter().any(|other| other.members[i]);
        (!found.is_empty()).then(|| (0..points).map(is_found).collect())
    }
}

/// Whether some attribute may tell kinds of particles apart.
pub(crate) fn has_kinds(frame: &FrameData) -> bool {
    groups::attributes(frame).next().is_some()
}

/// Looks for other things among the `selected` particles of `frame`. `later`: see [`Later`].
pub(crate) fn find(
    frame: &FrameData,
    positions: &[[f32; 3]],
    selected: impl Fn(usize) -> bool,
    later: Option<Later>,
    cancel: &Cancel,
) -> Result<Others, Error> {
    let mut others = Others::default();
    if !has_kinds(frame) && gas::density(frame).is_none() {
        return Ok(others);
    }
    let mut left: Vec<bool> = (0..positions.len()).map(selected).collect();
    for attribute in groups::attributes(frame) {
        let Some(groups) = Groups::by(attribute, frame, &|i| left[i], cancel)? else { continue };
        let densities = gas::densities(frame, &groups, cancel)?;
        let motion = Motion::find(frame, positions, later, &groups, cancel)?;
        let kinds = Kinds::tell(positions, &groups, motion.as_ref(), &densities);
        for other in kinds.others(&groups) {
            left.iter_mut().zip(&other.members).for_each(|(left, member)| *left &= !member);
            others.found.push(other);
        }
        let water = kinds.water();
        let count = water.iter().filter(|water| **water).count();
        if others.untold.is_none() && (2..=MOST_UNTOLD).contains(&count) {
            others.untold = Some(untold(&groups, &water, &densities));
        }
    }
    if others.found.iter().all(|other| other.name != gas::NAME) {
        others.found.extend(gas::by_density(frame, &left, cancel)?);
    }
    Ok(others)
}

/// What each group is.
struct Kinds {
    walls: Vec<bool>,
    walls_certain_as: Option<&'static str>,
    bodies: Vec<bool>,
    bodies_are_certain: bool,
    gas: Vec<bool>,
}

impl Kinds {
    fn tell(
        positions: &[[f32; 3]],
        groups: &Groups,
        motion: Option<&Motion>,
        densities: &[Option<f64>],
    ) -> Self {
        let (mut walls, walls_certain_as) = walls::find(positions, groups, motion);
        // The water is one of the groups.
        if !walls.contains(&false) {
            walls.fill(false);
        }
        let bodies = motion.map_or_else(|| vec![false; groups.len()], |motion| motion.rigid(&groups.sizes));
        let is_told = |group: usize| walls[group] || bodies[group];
        let densities: Vec<_> =
            (0..groups.len()).map(|group| densities[group].filter(|_| !is_told(group))).collect();
        let gas = gas::among(&densities);
        let bodies_are_certain = motion.is_some_and(|motion| motion.is_seen);
        Self { walls, walls_certain_as, bodies, bodies_are_certain, gas }
    }

    fn water(&self) -> Vec<bool> {
        (0..self.walls.len())
            .map(|group| !(self.walls[group] || self.bodies[group] || self.gas[group]))
            .collect()
    }

    fn others(&self, groups: &Groups) -> Vec<Other> {
        let flag = format!("--where '{}'", groups.selection(&self.water()));
        let other = |name, look, marks: &[bool], certain_as: Option<&str>| {
            marks.contains(&true).then(|| Other {
                name,
                look,
                flag: flag.clone(),
                pattern: groups.selection(marks),
                certain_as: certain_as.map(str::to_owned),
                members: groups.members(marks),
            })
        };
        let rigid = "they move as one rigid body while others deform";
        let bodies_certain_as = self.bodies_are_certain.then_some(rigid);
        let all = [
            other("walls", "solid", &self.walls, self.walls_certain_as),
            other("body", "solid", &self.bodies, bodies_certain_as),
            other(gas::NAME, "water", &self.gas, Some("they are far lighter than the others")),
        ];
        all.into_iter().flatten().collect()
    }
}

/// The `water` groups, of which none is known to be something else.
fn untold(groups: &Groups, water: &[bool], densities: &[Option<f64>]) -> Untold {
    let candidates: Vec<usize> = (0..groups.len()).filter(|&group| water[group]).collect();
    let only = |group: usize| (0..groups.len()).map(|other| other == group).collect::<Vec<bool>>();
    let described = candidates.iter().map(|&group| {
        let density = densities[group].map_or_else(String::new, |d| format!(" of density {d}"));
        format!("{} ({} particles{density})", groups.selection(&only(group)), groups.sizes[group])
    });
    let list = described.collect::<Vec<_>>().join(", ");
    // The largest is most likely the water, unless one weighs what water weighs.
    let likely =
        |group: &&usize| (densities[**group].is_some_and(gas::weighs_as_water), groups.sizes[**group]);
    let kept = candidates.iter().max_by_key(likely).copied().unwrap_or_default();
    let rest: Vec<bool> = (0..groups.len()).map(|group| water[group] && group != kept).collect();
    Untold { list, flag: format!("--set \"other={}:solid\"", groups.selection(&rest)) }
}
