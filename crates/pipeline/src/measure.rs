//! Robust sizes of particle sets, for the automatic camera and the automatic absorption.

use std::collections::HashMap;

use glam::{Vec2, Vec3};
use meniscus_core::{Aabb, Bulk, ParticleFrame, UpAxis};
use rayon::prelude::*;

/// Particles looked at: quantiles of this many are good to half a percent.
const SAMPLES: usize = 200_000;

/// Share of the particles under the body that have leaked out of it, rather than that the floor is below them. One of a hundred
/// counts as such a share, too.
const LEAKED: f64 = 1e-3;
const FEWEST: usize = 100;

/// Particles looked at by one task.
const PIECE: usize = 1 << 14;

/// The room that particles take, strays left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Box around those that are no strays; its lowest side is where the floor is. World.
    pub bounds: Aabb,
    /// How many particles are strays.
    pub strays: usize,
}

/// The room that `positions`, world, take: a few that left the simulated domain must not shrink the water to a dot in the picture,
/// and a few that fell through the floor must not leave it floating over the ground. Without strays it is the exact box.
pub fn extent(positions: &[[f32; 3]], up: UpAxis) -> Extent {
    let (bulk, up) = (Bulk::of(positions), up.index());
    let (body, around) = (bulk.body(), bulk.around());
    let of_piece = |piece: &[[f32; 3]]| {
        let counted = || piece.iter().filter(|p| around.contains(Vec3::from(**p)));
        let below: Vec<f32> = counted().map(|p| p[up]).filter(|height| *height < body.min[up]).collect();
        let above = Aabb::of_points(counted().filter(|p| p[up] >= body.min[up]));
        Piece { above, below, strays: piece.len() - counted().count() }
    };
    let all = positions.par_chunks(PIECE).map(of_piece).reduce(Piece::default, Piece::union);
    let mut below = all.below;
    below.sort_unstable_by(f32::total_cmp);
    let leaked = (positions.len() as f64 * LEAKED) as usize;
    let leaked = leaked.max(usize::from(positions.len() >= FEWEST)).min(below.len());
    let mut bounds = all.above;
    if let Some(floor) = below.get(leaked) {
        let is_counted = |p: &&[f32; 3]| around.contains(Vec3::from(**p)) && p[up] >= *floor;
        bounds = Aabb::of_points(positions.iter().filter(is_counted));
    }
    Extent { bounds, strays: all.strays + leaked }
}

/// What is known of some of the particles.
struct Piece {
    /// Box around those that are no strays and not under the body.
    above: Aabb,
    /// Heights of those that are no strays and under it.
    below: Vec<f32>,
    strays: usize,
}

impl Default for Piece {
    fn default() -> Self {
        Self { above: Aabb::EMPTY, below: Vec::new(), strays: 0 }
    }
}

impl Piece {
    fn union(mut self, mut other: Self) -> Self {
        self.below.append(&mut other.below);
        Self { above: self.above.union(other.above), below: self.below, strays: self.strays + other.strays }
    }
}

/// How far the `particles` inside `bounds` (world) reach, those of size 1 drawn with `radius_world`, in each of many
/// directions: points that frame a picture, tighter than the corners of a box.
pub fn outline(particles: &ParticleFrame, bounds: Aabb, radius_world: f32) -> Vec<Vec3> {
    const DIRECTIONS: usize = 96;
    // Points of a sunflower on the sphere: evenly spread.
    let directions: Vec<Vec3> = (0..DIRECTIONS)
        .map(|i| {
            let z = 1.0 - (2.0 * i as f32 + 1.0) / DIRECTIONS as f32;
            let angle = i as f32 * 2.399_963; // pi (3 - sqrt 5)
            ((1.0 - z * z).sqrt() * Vec2::from_angle(angle)).extend(z)
        })
        .collect();
    let furthest = |direction: &Vec3| {
        let inside = |(p, _): &(Vec3, f32)| bounds.contains(*p);
        // Added to what is the same for all, so that without sizes it is nothing.
        let reach = |&(p, size): &(Vec3, f32)| p.dot(*direction) + (size - 1.0) * radius_world;
        let stride = particles.len().div_ceil(10 * SAMPLES).max(1);
        (0..particles.len())
            .step_by(stride)
            .map(|i| (Vec3::from(particles.positions[i]), particles.size(i)))
            .filter(inside)
            .max_by(|a, b| reach(a).total_cmp(&reach(b)))
            .map(|(p, size)| p + *direction * (size * radius_world))
    };
    directions.par_iter().filter_map(furthest).collect()
}

/// Median depth of the water over the ground it covers, world: the volume of particles over the area of a column, columns
/// being four spacings wide. Those of size 1 are `spacing_world` apart; those outside of `bounds` (world), each of which would be a
/// column of its own, do not count.
pub fn column_depth(particles: &ParticleFrame, bounds: Aabb, up: UpAxis, spacing_world: f32) -> f32 {
    const WIDTH_IN_SPACINGS: f32 = 4.0;
    let width = spacing_world * WIDTH_IN_SPACINGS;
    let (a, b) = ((up.index() + 1) % 3, (up.index() + 2) % 3);
    // A sample of millions keeps the median of the columns within a few percent.
    let stride = particles.len().div_ceil(10 * SAMPLES);
    let mut columns: HashMap<(i32, i32), f64> = HashMap::new();
    let is_inside = |(_, p): &(usize, &[f32; 3])| bounds.contains(Vec3::from(**p));
    for (i, p) in particles.positions.iter().enumerate().step_by(stride.max(1)).filter(is_inside) {
        let column = ((p[a] / width).floor() as i32, (p[b] / width).floor() as i32);
        *columns.entry(column).or_default() += f64::from(particles.size(i)).powi(3);
    }
    let mut volumes: Vec<f64> = columns.into_values().collect();
    if volumes.is_empty() {
        return 0.0;
    }
    let middle = volumes.len() / 2;
    let (_, &mut median, _) = volumes.select_nth_unstable_by(middle, f64::total_cmp);
    (median * stride as f64) as f32 * spacing_world / (WIDTH_IN_SPACINGS * WIDTH_IN_SPACINGS)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice(n: [i32; 3], spacing: f32) -> Vec<[f32; 3]> {
        let mut points = Vec::new();
        for z in 0..n[2] {
            for y in 0..n[1] {
                for x in 0..n[0] {
                    points.push([x, y, z].map(|i| (i as f32 + 0.5) * spacing));
                }
            }
        }
        points
    }

    fn of_one_size(positions: Vec<[f32; 3]>) -> ParticleFrame {
        ParticleFrame { positions, ..Default::default() }
    }

    #[test]
    fn a_large_particle_reaches_far_out_of_the_outline() {
        let (positions, sizes) = (vec![[0.0; 3], [0.5, 0.0, 0.0]], vec![4.0, 1.0]);
        let particles = ParticleFrame { positions, sizes, ..Default::default() };
        let found = outline(&particles, particles.bounds(), 0.25);
        // All directions are nearer to those of the large sphere of radius 1, which holds the other.
        assert!(found.iter().all(|p| (p.length() - 1.0).abs() < 1e-5));
    }

    const UP: UpAxis = UpAxis::Z;

    #[test]
    fn without_strays_the_box_is_exact() {
        let points = lattice([20, 20, 20], 0.1);
        assert_eq!(extent(&points, UP), Extent { bounds: Aabb::of_points(&points), strays: 0 });
        assert_eq!(extent(&[[1.0, 2.0, 3.0]], UP).bounds, Aabb::of_points(&[[1.0, 2.0, 3.0]]));
        assert!(extent(&[], UP).bounds.is_empty());
    }

    #[test]
    fn strays_do_not_stretch_the_box() {
        let water = lattice([20, 20, 20], 0.1);
        for far in [vec![[1.0, 1.0, -500.0], [900.0, 1.0, 1.0]], vec![[-1000.0; 3]; 150], vec![[f32::MAX; 3]]]
        {
            let points = [water.clone(), far.clone()].concat();
            assert_eq!(extent(&points, UP), Extent { bounds: Aabb::of_points(&water), strays: far.len() });
        }
    }

    #[test]
    fn one_stray_among_a_few_hundred_is_one() {
        let mut points = lattice([8, 8, 8], 1.0);
        let bounds = Aabb::of_points(&points);
        points.push([1e12, 0.5, 0.5]);
        assert_eq!(extent(&points, UP), Extent { bounds, strays: 1 });
    }

    #[test]
    fn a_splash_above_the_bulk_stays_in() {
        let mut points = lattice([20, 20, 4], 0.1);
        points.push([1.0, 1.0, 1.7]);
        assert_eq!(extent(&points, UP).bounds.max.z, 1.7);
    }

    #[test]
    fn the_floor_does_not_follow_a_few_that_leaked_through_it() {
        let mut points = lattice([40, 20, 10], 0.1);
        let bounds = Aabb::of_points(&points);
        points.extend([[1.0, 1.0, -1.2], [3.0, 1.0, -0.9]]);
        assert_eq!(extent(&points, UP), Extent { bounds, strays: 2 });
        // Sideways it is spray.
        assert_eq!(extent(&points, UpAxis::Y).bounds.min.z, -1.2);
    }

    #[test]
    fn the_floor_is_under_what_falls() {
        let mut points = lattice([40, 20, 10], 0.1);
        // Drops of a hundredth of the water.
        points.extend((0..80).map(|i| [1.0 + 0.3 * (i % 8) as f32, 0.5, -1.0 - 0.2 * (i / 8) as f32]));
        let bounds = extent(&points, UP).bounds;
        // A thousandth of the particles counts as leaked: just the lowest row.
        assert!((bounds.min.z - -2.6).abs() < 1e-5, "{bounds:?}");
    }

    #[test]
    fn the_outline_of_a_ball_is_rounder_than_its_box() {
        let ball: Vec<[f32; 3]> = lattice([40, 40, 40], 0.05)
            .into_iter()
            .map(|p| (Vec3::from(p) - 1.0).to_array())
            .filter(|p| Vec3::from(*p).length() < 1.0)
            .collect();
        let bounds = Aabb::of_points(&ball);
        let outline = outline(&of_one_size(ball), bounds, 0.25);
        assert!(outline.iter().all(|p| (1.15..1.25).contains(&p.length())));
        // What is cut off a ball by planes at its 96 furthest points is less than a tenth of its radius.
        for direction in [Vec3::X, Vec3::NEG_Z, Vec3::ONE.normalize(), Vec3::new(0.3, -0.7, 0.2).normalize()]
        {
            let reach = outline.iter().map(|p| p.dot(direction)).fold(0.0, f32::max);
            assert!(reach > 1.15, "{direction} {reach}");
        }
    }

    #[test]
    fn the_depth_of_a_box_is_its_depth() {
        let column_depth = |particles: &ParticleFrame, up, spacing| {
            column_depth(particles, extent(&particles.positions, up).bounds, up, spacing)
        };
        // Multiples of the column width, so that no column is cut.
        let points = lattice([16, 16, 12], 0.1);
        let depth = column_depth(&of_one_size(points.clone()), UpAxis::Z, 0.1);
        assert!((depth - 1.2).abs() < 1e-5, "{depth}");
        let depth = column_depth(&of_one_size(points.clone()), UpAxis::X, 0.1);
        assert!((depth - 1.6).abs() < 1e-5, "{depth}");
        assert_eq!(column_depth(&ParticleFrame::default(), UpAxis::X, 0.1), 0.0);
        // A tower on a quarter of the ground is not how deep the water is.
        let mut tower = points.clone();
        tower.extend(lattice([8, 8, 40], 0.1).into_iter().map(|[x, y, z]| [x, y, z + 1.2]));
        let depth = column_depth(&of_one_size(tower), UpAxis::Z, 0.1);
        assert!((depth - 1.2).abs() < 1e-5, "{depth}");
        // Nor are strays, each in a column of its own, however few.
        let mut strays = points.clone();
        strays.extend((0..50).map(|i| [100.0 * i as f32 - 2525.0, 0.0, 0.0]));
        let depth = column_depth(&of_one_size(strays), UpAxis::Z, 0.1);
        assert!((depth - 1.2).abs() < 1e-5, "{depth}");
        // Half as far apart is an eighth of the volume.
        let sizes = vec![0.5; points.len()];
        let fine = ParticleFrame { positions: points, sizes, ..Default::default() };
        let depth = column_depth(&fine, UpAxis::Z, 0.1);
        assert!((depth - 0.15).abs() < 1e-5, "{depth}");
    }
}
