//! The simplest test bodies, with exactly known volumes. Positions are world space, in any unit.

use crate::golden::{Dice, golden_point};

/// Particles and the volume they stand for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Body {
    /// World space.
    pub positions: Vec<[f32; 3]>,
    /// Volume, cubed length unit: `positions.len() * spacing^3`.
    pub volume: f64,
}

impl Body {
    fn new(spacing: f32, positions: Vec<[f32; 3]>) -> Self {
        Self { volume: positions.len() as f64 * f64::from(spacing).powi(3), positions }
    }
}

/// A box of `cells` particles along x, y and z, the first at `spacing / 2` inside the corner `min`; each is moved by up to
/// `jitter` spacings along each axis (0 for a regular lattice). The box has edges `cells * spacing` and is filled exactly.
pub fn cuboid(min: [f32; 3], cells: [u32; 3], spacing: f32, jitter: f32, seed: u64) -> Body {
    let mut positions = Vec::with_capacity(cells.iter().map(|&n| n as usize).product());
    for z in 0..cells[2] {
        for y in 0..cells[1] {
            for x in 0..cells[0] {
                let mut dice = Dice::new(seed, positions.len() as u64);
                let cell = [x, y, z];
                positions.push(std::array::from_fn(|axis| {
                    let moved = dice.between(-1.0, 1.0) as f32 * jitter;
                    min[axis] + (cell[axis] as f32 + 0.5 + moved) * spacing
                }));
            }
        }
    }
    Body::new(spacing, positions)
}

/// A ball: the particles of a regular lattice, one of them at `center`, no further than `radius` from it. Its volume is
/// that of the particles, which nears the ball's as `spacing / radius` falls.
pub fn ball(center: [f32; 3], radius: f32, spacing: f32) -> Body {
    let reach = (radius / spacing) as i32;
    let mut positions = Vec::new();
    for z in -reach..=reach {
        for y in -reach..=reach {
            for x in -reach..=reach {
                let offset = [x, y, z].map(|cell| cell as f32 * spacing);
                if offset.iter().map(|c| c * c).sum::<f32>() <= radius * radius {
                    positions.push(std::array::from_fn(|axis| center[axis] + offset[axis]));
                }
            }
        }
    }
    Body::new(spacing, positions)
}

/// A plane sheet, one particle thick, of `cells` particles along x and y, at height `z`; the first is `spacing / 2` inside
/// the corner `min`.
pub fn sheet(min: [f32; 2], z: f32, cells: [u32; 2], spacing: f32) -> Body {
    cuboid([min[0], min[1], z - spacing * 0.5], [cells[0], cells[1], 1], spacing, 0.0, 0)
}

/// `count` particles at random places in the box from `min` to `max`: uniform, independent, without regard to each other.
pub fn spray(min: [f32; 3], max: [f32; 3], count: usize, spacing: f32, seed: u64) -> Body {
    let positions = (0..count as u64)
        .map(|id| {
            let mut dice = Dice::new(seed, id);
            std::array::from_fn(|axis| min[axis] + (max[axis] - min[axis]) * dice.roll() as f32)
        })
        .collect();
    Body::new(spacing, positions)
}

/// `count` particles spread evenly over a sphere's surface (Vogel's spiral): a shell, one particle thick, with `spacing`
/// the root of the area per particle.
pub fn shell(center: [f32; 3], radius: f32, count: usize) -> Body {
    let positions = (0..count as u64)
        .map(|rank| {
            let [along, turn] = golden_point(rank, count as u64, [0.5, 0.0]);
            let z = 1.0 - 2.0 * along;
            let ring = (1.0 - z * z).sqrt();
            let (sin, cos) = (turn * std::f64::consts::TAU).sin_cos();
            let normal = [ring * cos, ring * sin, z];
            std::array::from_fn(|axis| center[axis] + radius * normal[axis] as f32)
        })
        .collect();
    let area = 4.0 * std::f64::consts::PI * f64::from(radius).powi(2);
    Body::new((area / count.max(1) as f64).sqrt() as f32, positions)
}

/// `count` particles at the same point.
pub fn coincident(at: [f32; 3], count: usize, spacing: f32) -> Body {
    Body::new(spacing, vec![at; count])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jittered_box_stays_inside_and_fills_its_volume() {
        let body = cuboid([1.0, 2.0, 3.0], [4, 5, 6], 0.5, 0.4, 9);
        assert_eq!(body.positions.len(), 120);
        assert_eq!(body.volume, 2.0 * 2.5 * 3.0);
        for p in &body.positions {
            assert!(p[0] > 1.0 && p[0] < 3.0 && p[1] > 2.0 && p[1] < 4.5 && p[2] > 3.0 && p[2] < 6.0);
        }
        assert_eq!(body, cuboid([1.0, 2.0, 3.0], [4, 5, 6], 0.5, 0.4, 9));
    }

    #[test]
    fn a_ball_nears_its_volume() {
        let body = ball([5.0, 0.0, 0.0], 1.0, 0.05);
        // Gauss's circle problem in three dimensions: well below one percent at 20 spacings.
        assert!((body.volume / (4.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 0.01);
        assert!(body.positions.contains(&[5.0, 0.0, 0.0]));
    }

    #[test]
    fn sheets_shells_sprays_and_points() {
        assert!(sheet([0.0, 0.0], 2.0, [3, 4], 0.1).positions.iter().all(|p| (p[2] - 2.0).abs() < 1e-6));
        let shell = shell([0.0; 3], 2.0, 500);
        assert!(shell.positions.iter().all(|p| (p.iter().map(|c| c * c).sum::<f32>() - 4.0).abs() < 1e-4));
        let cloud = spray([-1.0; 3], [1.0; 3], 1000, 0.1, 3);
        assert!(cloud.positions.iter().flatten().all(|c| c.abs() <= 1.0));
        assert!((cloud.volume - 1.0).abs() < 1e-6);
        assert_eq!(coincident([1.0; 3], 7, 0.1).positions, vec![[1.0; 3]; 7]);
    }
}
