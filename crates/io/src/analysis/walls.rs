//! Walls in the same file as the water: particles of a kind that never moves, or that encloses the others.

use meniscus_core::Cancel;

use super::names;
use crate::Error;
use crate::frame_data::{AttributeInfo, FrameData};
use crate::info::ValueCounts;
use crate::scalar::{ToF32, ToF64};

/// Kinds of particles of which some look like walls.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Walls {
    /// The flag that hides them, ready to paste.
    pub flag: String,
    /// The selection of them.
    pub pattern: String,
    /// Why they can be nothing else, if so. What has no speed at one moment may be a lake that something is about to fall into.
    pub certain_as: Option<&'static str>,
    /// Which particles they are.
    pub members: Vec<bool>,
}

/// The group of particles that belong to none; there are at most as many groups as [`ValueCounts`] lists.
const NO_GROUP: u8 = u8::MAX;

/// A share of the fastest group's motion below which a group stands still.
const STILL: f64 = 1e-3;

/// Share of a group's particles near the faces of its box that makes it a shell.
const SHELL_SHARE: f64 = 0.9;

/// Whether some attribute may tell kinds of particles apart.
pub(crate) fn has_kinds(frame: &FrameData) -> bool {
    kinds(frame).next().is_some()
}

/// Integer attributes with a name for kinds of particles.
fn kinds(frame: &FrameData) -> impl Iterator<Item = &AttributeInfo> {
    names::KIND.iter().filter_map(|name| {
        let fits =
            |a: &&AttributeInfo| a.components == 1 && a.ty.is_integer() && a.name.eq_ignore_ascii_case(name);
        frame.attributes().iter().find(fits)
    })
}

/// Looks for walls among the `selected` particles of `frame`. `later`: position of the same particle at another time.
pub(crate) fn find(
    frame: &FrameData,
    positions: &[[f32; 3]],
    selected: impl Fn(usize) -> bool,
    later: Option<&dyn Fn(usize) -> [f32; 3]>,
    cancel: &Cancel,
) -> Result<Option<Walls>, Error> {
    for kind in kinds(frame) {
        let values = frame.attribute_array(kind)?;
        let mut counts = ValueCounts::default();
        for block in frame.blocks() {
            for (i, value) in values.values(&block, &ToF64, cancel)?.into_iter().enumerate() {
                if selected(block.first + i) {
                    counts.add(value);
                }
            }
        }
        let Some(counts) = counts.into_list().filter(|counts| counts.len() > 1) else { continue };
        let groups: Vec<i64> = counts.iter().map(|count| count.value).collect();
        let mut members = Vec::with_capacity(positions.len());
        for block in frame.blocks() {
            let values = values.values(&block, &ToF64, cancel)?;
            members.extend(values.into_iter().enumerate().map(|(i, value)| {
                let group = groups.iter().position(|&g| g == value as i64);
                group.filter(|_| selected(block.first + i)).map_or(NO_GROUP, |group| group as u8)
            }));
        }
        let group_of = |point: usize| Some(usize::from(members[point])).filter(|&g| g < groups.len());
        let shells = || shells(positions, groups.len(), &group_of);
        let (walls, certain_as) = match motion(frame, positions, later, groups.len(), &group_of, cancel)? {
            Some(Motion { root_means, is_seen }) => {
                let still = standing_still(&root_means);
                let encloses = || shells().iter().zip(&still).any(|(shell, still)| *shell && *still);
                let certain_as = match is_seen {
                    true => Some("they stay where they are while others move"),
                    false => encloses().then_some("they stand still around the others"),
                };
                (still, certain_as)
            }
            None => {
                let sizes: Vec<u64> = counts.iter().map(|count| count.count).collect();
                (with_obstacles(shells(), &sizes), Some("they enclose the others"))
            }
        };
        if !walls.contains(&true) || walls.iter().all(|wall| *wall) {
            continue;
        }
        let selection = |of_walls: bool| {
            let taken = groups.iter().zip(&walls).filter(|(_, wall)| **wall == of_walls);
            let values: Vec<String> = taken.map(|(group, _)| group.to_string()).collect();
            let name = quoted(&kind.name);
            match values.as_slice() {
                [one] => format!("{name} == {one}"),
                several => format!("{name} in ({})", several.join(", ")),
            }
        };
        let (flag, pattern) = (format!("--where '{}'", selection(false)), selection(true));
        let members = (0..members.len()).map(|i| group_of(i).is_some_and(|group| walls[group])).collect();
        return Ok(Some(Walls { flag, pattern, certain_as, members }));
    }
    Ok(None)
}

/// A name as the expression grammar wants it.
fn quoted(name: &str) -> String {
    let bare = name.chars().all(|c| c.is_alphanumeric() || c == '_')
        && !name.starts_with(|c: char| c.is_ascii_digit());
    if bare { name.to_owned() } else { format!("\"{name}\"") }
}

struct Motion {
    /// Root mean square of each group's displacement, else of its velocity.
    root_means: Vec<f64>,
    /// Whether it is of displacements.
    is_seen: bool,
}

/// How the groups move; `None` when nothing moves or nothing tells.
fn motion(
    frame: &FrameData,
    positions: &[[f32; 3]],
    later: Option<&dyn Fn(usize) -> [f32; 3]>,
    groups: usize,
    group_of: &impl Fn(usize) -> Option<usize>,
    cancel: &Cancel,
) -> Result<Option<Motion>, Error> {
    if let Some(later) = later {
        let mut sums = Squares::of(groups);
        for (i, position) in positions.iter().enumerate() {
            let later = later(i);
            sums.add(group_of(i), std::array::from_fn(|axis| later[axis] - position[axis]));
        }
        let root_means = sums.root_means();
        if root_means.iter().any(|&m| m > 0.0) {
            return Ok(Some(Motion { root_means, is_seen: true }));
        }
    }
    let Some(velocity) = names::find(frame, names::VELOCITY, 3) else { return Ok(None) };
    let velocities = frame.attribute_array(velocity)?;
    let mut sums = Squares::of(groups);
    for block in frame.blocks() {
        let values = velocities.values(&block, &ToF32, cancel)?;
        for (i, velocity) in values.as_chunks::<3>().0.iter().enumerate() {
            sums.add(group_of(block.first + i), *velocity);
        }
    }
    let root_means = sums.root_means();
    let moves = root_means.iter().any(|&m| m > 0.0);
    Ok(moves.then_some(Motion { root_means, is_seen: false }))
}

/// Sums of the squared lengths of each group's vectors, and how many there are.
struct Squares(Vec<(f64, f64)>);

impl Squares {
    fn of(groups: usize) -> Self {
        Self(vec![(0.0, 0.0); groups])
    }

    fn add(&mut self, group: Option<usize>, vector: [f32; 3]) {
        let square: f64 = vector.iter().map(|&c| f64::from(c).powi(2)).sum();
        if let Some(group) = group.filter(|_| square.is_finite()) {
            self.0[group].0 += square;
            self.0[group].1 += 1.0;
        }
    }

    fn root_means(self) -> Vec<f64> {
        let root_mean = |(sum, count)| if count > 0.0 { f64::sqrt(sum / count) } else { 0.0 };
        self.0.into_iter().map(root_mean).collect()
    }
}

fn standing_still(motion: &[f64]) -> Vec<bool> {
    let fastest = motion.iter().copied().fold(0.0, f64::max);
    motion.iter().map(|&m| m < STILL * fastest).collect()
}

/// Adds groups that are far smaller than the largest one inside the walls: before anything moves, an obstacle cannot be told
/// from water otherwise.
fn with_obstacles(mut walls: Vec<bool>, sizes: &[u64]) -> Vec<bool> {
    let largest =
        sizes.iter().zip(&walls).filter(|(_, wall)| !**wall).map(|(size, _)| *size).max().unwrap_or(0);
    if walls.contains(&true) {
        walls.iter_mut().zip(sizes).for_each(|(wall, size)| *wall |= *size < largest / 20);
    }
    walls
}

/// Groups whose box holds all others' boxes and whose particles lie near its faces.
fn shells(positions: &[[f32; 3]], groups: usize, group_of: &impl Fn(usize) -> Option<usize>) -> Vec<bool> {
    let mut boxes = vec![([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]); groups];
    for (i, point) in positions.iter().enumerate() {
        let Some(group) = group_of(i) else { continue };
        let (low, high) = &mut boxes[group];
        for (axis, &c) in point.iter().enumerate() {
            low[axis] = low[axis].min(c);
            high[axis] = high[axis].max(c);
        }
    }
    let encloses = |group: usize| {
        let (low, high) = boxes[group];
        boxes.iter().all(|(l, h)| (0..3).all(|axis| low[axis] <= l[axis] && h[axis] <= high[axis]))
    };
    let near_faces = |group: usize| {
        let (low, high) = boxes[group];
        let mut counts = (0.0, 0.0);
        for (i, point) in positions.iter().enumerate() {
            if group_of(i) != Some(group) {
                continue;
            }
            counts.1 += 1.0;
            // A tenth of the box: walls are a few layers thick.
            let near = (0..3).any(|axis| {
                let margin = 0.1 * (high[axis] - low[axis]);
                point[axis] < low[axis] + margin || point[axis] > high[axis] - margin
            });
            counts.0 += f64::from(u8::from(near));
        }
        counts.0 / f64::max(counts.1, 1.0)
    };
    (0..groups).map(|group| encloses(group) && near_faces(group) > SHELL_SHARE).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hollow box of kind 1 around a block of kind 0.
    fn tank() -> (Vec<[f32; 3]>, Vec<usize>) {
        let (mut points, mut kinds) = (Vec::new(), Vec::new());
        for i in 0..20 * 20 * 20 {
            let at = [i % 20, i / 20 % 20, i / 400];
            let wall = at.iter().any(|c| [0, 1, 18, 19].contains(c));
            let water = at.iter().all(|c| (2..10).contains(c));
            if wall || water {
                points.push(at.map(|c| c as f32));
                kinds.push(usize::from(wall));
            }
        }
        (points, kinds)
    }

    #[test]
    fn an_enclosing_shell_is_a_wall() {
        let (points, kinds) = tank();
        assert_eq!(shells(&points, 2, &|i| Some(kinds[i])), [false, true]);
        // Two layers of water over the same floor area are no shell around anything.
        assert_eq!(shells(&points, 2, &|i| Some(usize::from(points[i][0] > 9.0))), [false, false]);
    }

    #[test]
    fn what_stands_still_while_others_move_is_a_wall() {
        let (_, kinds) = tank();
        let mut sums = Squares::of(2);
        for kind in &kinds {
            sums.add(Some(*kind), if *kind == 0 { [0.0, 0.3, -0.4] } else { [0.0; 3] });
        }
        let motion = sums.root_means();
        assert!((motion[0] - 0.5).abs() < 1e-6 && motion[1] == 0.0, "{motion:?}");
        assert_eq!(standing_still(&motion), [false, true]);
    }

    #[test]
    fn small_groups_count_as_obstacles_only_beside_walls() {
        assert_eq!(with_obstacles(vec![false, true, false], &[7000, 10_000, 100]), [false, true, true]);
        assert_eq!(with_obstacles(vec![false, true, false], &[7000, 10_000, 1000]), [false, true, false]);
        assert_eq!(with_obstacles(vec![false, false, false], &[7000, 10_000, 100]), [false, false, false]);
    }

    #[test]
    fn flags_quote_odd_names() {
        assert_eq!([quoted("type"), quoted("my type"), quoted("2nd")], ["type", "\"my type\"", "\"2nd\""]);
    }
}
