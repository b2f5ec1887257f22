use std::collections::{HashMap, HashSet};

use glam::Vec3;

use crate::Aabb;

/// Particles looked at: enough that what is no thinner than a thirtieth of the whole is met many times.
const SAMPLES: usize = 200_000;

/// Share of the particles, per axis and side, without which the core is found. More than [`FEW`], so that strays which all lie on
/// one side are not in it.
const TAIL: f64 = 0.025;

/// Share of the particles that may be strays. What is apart from the rest and more than this belongs to it: another pool.
const FEW: f64 = 0.02;

/// Sampled particles in a cell of the core, on average at least: then hardly a cell inside of a body is empty, however the particles
/// lie in it.
const PER_CELL: usize = 8;

/// Where most of the particles are, whatever few of them that are apart from the rest do: those that left the simulated domain,
/// that the solver lost, or that it parked far away.
///
/// The *body* is what is connected, in cells of some spacings, with the middle 95 % of the particles, and any other piece of more
/// than 2 % of them. What is apart from it counts, too, up to a body's length away: spray. But spray gets thinner the
/// farther away it is, so that where most of what is apart from the body is farther away than that, none of it is spray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bulk {
    body: Aabb,
    reach: f32,
}

impl Bulk {
    /// The bulk of `positions`, found by up to 200 000 of them that are spread over the list. Those that are not finite do not
    /// count.
    pub fn of(positions: &[[f32; 3]]) -> Self {
        Self::of_sample(spread(positions.len(), SAMPLES).map(|i| positions[i]).collect())
    }

    /// The bulk of the particles of which `points` are some. Those that are not finite do not count.
    pub fn of_sample(mut points: Vec<[f32; 3]>) -> Self {
        points.retain(|p| p.iter().all(|c| c.is_finite()));
        if points.is_empty() {
            return Self { body: Aabb::EMPTY, reach: 0.0 };
        }
        let core = core(&points);
        let longest = longest_side(&core);
        let in_f32 = |sides: &Sides| {
            let corner = |side: usize| Vec3::from(sides.map(|sides| sides[side] as f32));
            Aabb { min: corner(0), max: corner(1) }
        };
        if longest <= 0.0 {
            // Hardly anything is anywhere else, so that there is no length to judge by.
            return Self { body: in_f32(&core), reach: f32::INFINITY };
        }
        let edge = edge(&points, &core);
        let body = body(&points, &core, edge);
        let length = longest_side(&body);
        let distance = |p: &[f32; 3]| {
            let along = |axis: usize| {
                let at = f64::from(p[axis]);
                (body[axis][0] - at).max(at - body[axis][1])
            };
            (0..3).map(along).fold(0.0, f64::max)
        };
        let mut apart: Vec<f64> = points.iter().map(distance).filter(|distance| *distance > edge).collect();
        apart.sort_unstable_by(|a, b| b.total_cmp(a));
        let few = (points.len() as f64 * FEW) as usize;
        let beyond = apart.partition_point(|distance| *distance > length);
        let reach = match apart.get(few) {
            Some(&farther_than_few) => farther_than_few.max(length),
            None if 2 * beyond > apart.len() => edge,
            None => length,
        };
        // Of particles that were not looked at, some lie a little farther out.
        Self { body: within_f32(in_f32(&body).inflated(edge as f32)), reach: reach as f32 }
    }

    /// Box around the body, a cell larger than it on all sides; a point where nearly all particles are in one place. Empty without
    /// particles.
    pub fn body(&self) -> Aabb {
        self.body
    }

    /// The same bulk after all positions have been moved by `shift`.
    #[must_use]
    pub fn moved(&self, shift: Vec3) -> Self {
        Self { body: Aabb { min: self.body.min + shift, max: self.body.max + shift }, ..*self }
    }

    /// Box around the body and its spray: what lies outside is a stray. Endless where nearly all particles are in one place; empty
    /// without particles.
    pub fn around(&self) -> Aabb {
        within_f32(self.body.inflated(self.reach))
    }
}

/// Without the infinite, where no particle is.
fn within_f32(region: Aabb) -> Aabb {
    Aabb { min: region.min.max(Vec3::MIN), max: region.max.min(Vec3::MAX) }
}

/// Low and high of each axis.
type Sides = [[f64; 2]; 3];

fn longest_side(sides: &Sides) -> f64 {
    sides.iter().map(|[low, high]| high - low).fold(0.0, f64::max)
}

/// Indices of `count` of `len` things, all if there are fewer. The golden ratio's multiples fill the list evenly, and stay on no
/// plane of a lattice.
fn spread(len: usize, count: usize) -> impl Iterator<Item = usize> {
    let index = move |i: usize| {
        if count >= len { i } else { ((i as f64 * 0.618_033_988_749_895).fract() * len as f64) as usize }
    };
    (0..len.min(count)).map(index)
}

/// The box of the middle of `points`, of which there are some, along each axis.
fn core(points: &[[f32; 3]]) -> Sides {
    std::array::from_fn(|axis| {
        let mut values: Vec<f32> = points.iter().map(|p| p[axis]).collect();
        let last = values.len() - 1;
        let tail = (last as f64 * TAIL).round() as usize;
        let (_, &mut low, _) = values.select_nth_unstable_by(tail, f32::total_cmp);
        let (_, &mut high, _) = values.select_nth_unstable_by(last - tail, f32::total_cmp);
        [low, high].map(f64::from)
    })
}

type Cell = [i64; 3];

/// Cells of the given edge, from the low corner of the core on.
struct Cells<'a> {
    core: &'a Sides,
    edge: f64,
}

impl Cells<'_> {
    fn of(&self, point: &[f32; 3]) -> Cell {
        self.at(point.map(f64::from))
    }

    fn at(&self, point: [f64; 3]) -> Cell {
        // The limits leave room for the neighbours of the farthest.
        let index = |axis: usize| ((point[axis] - self.core[axis][0]) / self.edge).floor().clamp(-1e15, 1e15);
        std::array::from_fn(|axis| index(axis) as i64)
    }

    fn is_core(&self, cell: &Cell) -> bool {
        let last = self.at(self.core.map(|[_, high]| high));
        (0..3).all(|axis| (0..=last[axis]).contains(&cell[axis]))
    }
}

/// Edge of the smallest cells of which those in the core hold [`PER_CELL`], halved from its longest side on.
fn edge(points: &[[f32; 3]], core: &Sides) -> f64 {
    let mut edge = longest_side(core);
    // Where particles are on top of each other there is no end.
    for _ in 0..24 {
        let cells = Cells { core, edge: 0.5 * edge };
        let (mut occupied, mut inside) = (HashSet::new(), 0);
        for cell in points.iter().map(|p| cells.of(p)).filter(|cell| cells.is_core(cell)) {
            occupied.insert(cell);
            inside += 1;
        }
        if inside < PER_CELL * occupied.len() {
            break;
        }
        edge *= 0.5;
    }
    edge
}

/// The box of the points that are in the core or connected with it, or in any other piece of more than [`FEW`] of them, in cells of
/// the given edge.
fn body(points: &[[f32; 3]], core: &Sides, edge: f64) -> Sides {
    let cells = Cells { core, edge };
    let mut left: HashMap<Cell, usize> = HashMap::new();
    points.iter().for_each(|p| *left.entry(cells.of(p)).or_default() += 1);
    let all: Vec<Cell> = left.keys().copied().collect();
    let in_core = all.iter().copied().filter(|cell| cells.is_core(cell));
    let (mut taken, _) = connected(in_core, &mut left);
    for cell in all {
        let (piece, count) = connected([cell].into_iter(), &mut left);
        if count as f64 > points.len() as f64 * FEW {
            taken.extend(piece);
        }
    }
    let mut sides = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    for p in points.iter().filter(|p| taken.contains(&cells.of(p))) {
        for axis in 0..3 {
            let at = f64::from(p[axis]);
            sides[axis] = [sides[axis][0].min(at), sides[axis][1].max(at)];
        }
    }
    sides
}

/// Takes those of `seeds` that are there, and all cells that are connected with them, out of `left`: which they are, and how many
/// points they hold.
fn connected(seeds: impl Iterator<Item = Cell>, left: &mut HashMap<Cell, usize>) -> (HashSet<Cell>, usize) {
    let (mut piece, mut pending, mut points) = (HashSet::new(), Vec::new(), 0);
    let mut take = |cell: Cell, pending: &mut Vec<Cell>| {
        if let Some(count) = left.remove(&cell) {
            points += count;
            piece.insert(cell);
            pending.push(cell);
        }
    };
    seeds.for_each(|cell| take(cell, &mut pending));
    while let Some([x, y, z]) = pending.pop() {
        for i in 0..27 {
            take([x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1], &mut pending);
        }
    }
    (piece, points)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `size` particles along each axis, 0.1 apart, from `at` on.
    fn block(size: [i32; 3], at: [f32; 3]) -> Vec<[f32; 3]> {
        let [x, y, z] = size;
        let point = |i: i32| [i % x, i / x % y, i / x / y];
        (0..x * y * z).map(|i| std::array::from_fn(|axis| at[axis] + 0.1 * point(i)[axis] as f32)).collect()
    }

    /// Numbers in -1..1, deterministic.
    fn noise(seed: &mut u64) -> f32 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    fn cloud(count: usize, half_width: f32) -> Vec<[f32; 3]> {
        let mut seed = 5;
        (0..count).map(|_| std::array::from_fn(|_| half_width * noise(&mut seed))).collect()
    }

    /// How many of `points` lie outside of the bulk of all of them and its spray.
    fn strays(points: &[[f32; 3]]) -> usize {
        let around = Bulk::of(points).around();
        points.iter().filter(|p| !around.contains(Vec3::from(**p))).count()
    }

    #[test]
    fn without_strays_all_are_in_the_body() {
        for size in [[20, 20, 20], [60, 40, 1], [200, 1, 1], [3, 2, 2], [1, 1, 1]] {
            let points = block(size, [5.0, -3.0, 1e3]);
            let (bulk, exact) = (Bulk::of(&points), Aabb::of_points(&points));
            assert_eq!(bulk.body().union(exact), bulk.body(), "{size:?}");
            assert_eq!(strays(&points), 0, "{size:?}");
        }
        assert!(Bulk::of(&[]).body().is_empty() && Bulk::of(&[]).around().is_empty());
        assert!(Bulk::of(&[[f32::NAN; 3]]).around().is_empty());
    }

    #[test]
    fn strays_are_left_out_however_far_and_wherever_they_are() {
        let water = block([40, 20, 10], [0.0; 3]);
        for far in [
            vec![[f32::MAX, 0.0, 0.0]],
            vec![[-f32::MAX, f32::MAX, 0.0]; 3],
            // 1.9 %, parked in one place.
            vec![[-1000.0; 3]; 150],
            vec![[-9.0, -7.0, -8.0]; 150],
            cloud(150, 5000.0),
            cloud(20, 300.0),
        ] {
            let points = [water.clone(), far.clone()].concat();
            assert_eq!(strays(&points), far.len(), "{:?}", &far[0]);
            let body = Bulk::of(&points).body().extent();
            // The water, and a cell of less than an eighth of its length on each side.
            assert!(body.max_element() < 1.3 * 3.9, "{body}");
        }
    }

    #[test]
    fn cells_are_as_fine_as_shallow_water_is_deep() {
        // 40 times as wide as deep, a particle half a depth below it.
        let points = [block([160, 160, 5], [0.0; 3]), vec![[8.0, 8.0, -0.5]]].concat();
        let body = Bulk::of(&points).body();
        assert!(body.min.z > -0.5 && strays(&points) == 0, "{body:?}");
    }

    #[test]
    fn spray_counts_up_to_a_length_of_the_body() {
        let mut points = block([40, 20, 10], [0.0; 3]);
        points.extend([[2.0, 1.0, 4.5], [-2.0, 1.0, 1.0], [0.0, 1.0, 3.0]]);
        assert_eq!(strays(&points), 0);
        points.push([2.0, 1.0, 12.0]);
        assert_eq!(strays(&points), 1);
    }

    #[test]
    fn a_cloud_that_thickens_nowhere_is_no_spray_where_it_is_near() {
        // Around the water, too, but most of it farther away.
        let cloud = cloud(160, 12.0);
        let points = [block([40, 20, 10], [0.0; 3]), cloud.clone()].concat();
        let near = Bulk::of(&points).body();
        assert_eq!(strays(&points), cloud.iter().filter(|p| !near.contains(Vec3::from(**p))).count());
        assert!(near.extent().max_element() < 1.3 * 3.9);
    }

    #[test]
    fn a_far_arm_that_is_connected_belongs_to_the_body() {
        let mut points = block([40, 20, 10], [0.0; 3]);
        // A hundredth of the particles, four lengths of the water.
        points.extend((0..80).map(|i| [4.0 + 0.2 * i as f32, 1.0, 0.5]));
        assert_eq!(strays(&points), 0);
    }

    #[test]
    fn two_pools_far_apart_are_both_kept() {
        for share in [8000, 500, 200] {
            let other: Vec<[f32; 3]> = block([20, 20, 20], [600.0, 0.0, 0.0])[..share].to_vec();
            let points = [block([20, 20, 20], [0.0; 3]), other].concat();
            assert_eq!(strays(&points), 0, "{share}");
        }
    }

    #[test]
    fn many_that_are_scattered_are_no_few() {
        // A tenth, none of them near another.
        let points = [block([40, 20, 10], [0.0; 3]), cloud(800, 40.0)].concat();
        assert!(strays(&points) <= 160, "no more than are few");
        assert_eq!(strays(&cloud(300, 1.0)), 0);
    }

    #[test]
    fn two_places_have_no_length_to_judge_by() {
        let points = [vec![[0.25; 3]; 1000], vec![[4.25, 0.25, 0.25]]].concat();
        let bulk = Bulk::of(&points);
        assert_eq!((bulk.body().center(), bulk.body().extent()), (Vec3::splat(0.25), Vec3::ZERO));
        assert_eq!(strays(&points), 0);
        let infinite = [vec![[0.25; 3]; 1000], vec![[f32::INFINITY, 0.25, 0.25]]].concat();
        assert_eq!(strays(&infinite), 1, "not even there");
    }

    #[test]
    fn more_particles_than_are_looked_at() {
        // Rows of a thousand: every two-hundredth or so would lie on a few planes.
        let mut points = block([1000, 40, 20], [0.0; 3]);
        points[17] = [1e6, 0.0, 0.0];
        points[400_000] = [0.0, -1e7, 0.0];
        assert_eq!(strays(&points), 2);
    }
}
