//! Walls: groups of particles that never move, or that enclose the others.

use super::groups::Groups;
use super::motion::Motion;

/// Share of a group's particles near the faces of its box that makes it a shell.
const SHELL_SHARE: f64 = 0.9;

/// Which of `groups` look like walls, and why they can be nothing else, if so. What has no speed at one moment may be a lake that
/// something is about to fall into.
pub(super) fn find(
    positions: &[[f32; 3]],
    groups: &Groups,
    motion: Option<&Motion>,
) -> (Vec<bool>, Option<&'static str>) {
    let shells = || shells(positions, groups.len(), &|i| groups.of(i));
    let Some(motion) = motion else {
        return (with_obstacles(shells(), &groups.sizes), Some("they enclose the others"));
    };
    let still = motion.still();
    let encloses = || shells().iter().zip(&still).any(|(shell, still)| *shell && *still);
    let certain_as = match motion.is_seen {
        true => Some("they stay where they are while others move"),
        false => encloses().then_some("they stand still around the others"),
    };
    (still, certain_as)
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
    fn small_groups_count_as_obstacles_only_beside_walls() {
        assert_eq!(with_obstacles(vec![false, true, false], &[7000, 10_000, 100]), [false, true, true]);
        assert_eq!(with_obstacles(vec![false, true, false], &[7000, 10_000, 1000]), [false, true, false]);
        assert_eq!(with_obstacles(vec![false, false, false], &[7000, 10_000, 100]), [false, false, false]);
    }
}
