use std::f64::consts::PI;

use glam::DVec2;

use crate::flight::Flight;
use crate::flow::{Flow, Placed, ramp};
use crate::golden::{Dice, golden_point, share_out};

/// Floor of the tank, m.
const TANK: DVec2 = DVec2::new(0.3, 0.5);
/// Water depth, m; the tank is 0.6 m high.
const DEPTH: f64 = 0.4;
/// Radius of the sphere, m.
const SPHERE_RADIUS: f64 = 0.0127;
/// Speed of the sphere at the surface, m/s.
const IMPACT_SPEED: f64 = 2.17;
/// When it touches the surface, s.
const IMPACT: f64 = 0.02;
/// Radius of the open cavity, m.
const CAVITY_RADIUS: f64 = 0.026;
/// How far the cavity pushes water aside and up, m.
const REACH: f64 = 0.055;

/// Upright columns on a sunflower around the axis of entry, which the cavity shifts outwards: `r'^2 = r^2 + a^2 exp(-r^2 /
/// reach^2)` at the cavity radius `a`, and upwards by as much as keeps the volume.
pub(crate) struct SphereEntry {
    /// Place of each column at rest, from the axis.
    columns: Vec<DVec2>,
    starts: Vec<u64>,
    spacing: f64,
}

/// A column at one time.
pub(crate) struct Column {
    at: DVec2,
    cavity: Cavity,
    /// Height of the rippled surface over that at rest, as a ratio.
    ripple: f64,
}

impl SphereEntry {
    /// m^3
    pub(crate) fn volume() -> f64 {
        TANK.x * TANK.y * DEPTH
    }

    pub(crate) fn new(particles: u64, spacing: f64) -> Self {
        let corner = TANK * 0.5;
        // One floret per spacing^2, out to the corners of the tank.
        let florets = (PI * corner.length_squared() / (spacing * spacing)).ceil().max(1.0) as u64;
        let mut columns: Vec<DVec2> = (0..florets)
            .map(|rank| {
                let [area, turn] = golden_point(rank, florets, [0.5, 0.0]);
                DVec2::from_angle(turn * 2.0 * PI) * (area.sqrt() * corner.length())
            })
            .filter(|at| at.abs().cmplt(corner).all())
            .collect();
        if columns.is_empty() {
            columns.push(DVec2::ZERO);
        }
        let starts = share_out(particles, &vec![1.0; columns.len()]);
        Self { columns, starts, spacing }
    }
}

impl Flow for SphereEntry {
    type Strand = Column;

    fn starts(&self) -> &[u64] {
        &self.starts
    }

    fn strand_at(&self, strand: usize, time: f64) -> Column {
        let at = self.columns[strand];
        Column { at, cavity: Cavity::at(time), ripple: ripple(at.length(), time) }
    }

    fn place(&self, column: &Column, rank: u64, count: u64) -> Placed {
        let z = (rank as f64 + 0.5) / count as f64 * DEPTH;
        let (area, swell) = (column.at.length_squared(), column.cavity.swell(column.at.length_squared()));
        let moved_area = area + column.cavity.area_at(z) * (-area / (REACH * REACH)).exp();
        let out = if area > 0.0 { (moved_area / area).sqrt() } else { 1.0 };
        let height = |z: f64| (z + swell * column.cavity.open_below(z)) * column.ripple;
        let position = (TANK * 0.5 + column.at * out).extend(height(z));
        Placed { position, depth: height(DEPTH) - position.z }
    }

    fn flight(&self, strand: usize, rank: u64, count: u64, dice: &mut Dice) -> Option<Flight> {
        let at = self.columns[strand];
        let layers_below_surface = (count - 1 - rank) as f64 * DEPTH / (count as f64 * self.spacing);
        let outwards = at.normalize_or_zero();
        let crown = at.length() < 0.05 && layers_below_surface < 6.0 && dice.roll() < 0.3;
        if crown {
            // What lies nearer to the axis leaves first and fastest.
            let nearness = 1.0 - at.length() / 0.05;
            return Some(Flight {
                launch: IMPACT + 0.005 + 0.03 * (1.0 - nearness) + dice.between(0.0, 0.02),
                rise: dice.between(0.5, 1.0) + 0.6 * nearness,
                drift: outwards * dice.between(0.25, 0.55),
            });
        }
        let jet = at.length() < 0.016 && layers_below_surface < 14.0 && dice.roll() < 0.4;
        jet.then(|| Flight {
            launch: CLOSING + 0.04 + dice.between(0.0, 0.07),
            rise: dice.between(0.4, 1.7),
            drift: outwards * dice.between(0.0, 0.05),
        })
    }
}

/// When the cavity begins to close, s.
const CLOSING: f64 = IMPACT + 0.14;

/// The air-filled hole behind the sphere.
#[derive(Clone, Copy)]
struct Cavity {
    /// Height of the sphere's centre, m.
    bottom: f64,
    /// Square of the radius above the sphere, m^2.
    area: f64,
}

impl Cavity {
    fn at(time: f64) -> Self {
        let since = (time - IMPACT).max(0.0);
        let sunk = IMPACT_SPEED * since / (1.0 + 4.0 * since);
        let open = ramp(since / 0.03) * (1.0 - ramp((time - CLOSING) / 0.09));
        Self { bottom: DEPTH + SPHERE_RADIUS - sunk, area: CAVITY_RADIUS * CAVITY_RADIUS * open }
    }

    /// How far `z` is through the rounded bottom: 0 below, 1 above.
    fn rounded(&self, z: f64) -> f64 {
        (z - self.bottom + SPHERE_RADIUS) / (2.0 * SPHERE_RADIUS)
    }

    /// Square of the radius at height `z`, m^2.
    fn area_at(&self, z: f64) -> f64 {
        self.area * ramp(self.rounded(z))
    }

    /// Integral of [`ramp`] up to height `z`: the length of cavity below, m.
    fn open_below(&self, z: f64) -> f64 {
        let x = self.rounded(z).max(0.0);
        let inner = x.min(1.0);
        2.0 * SPHERE_RADIUS * (inner.powi(3) - 0.5 * inner.powi(4) + (x - inner))
    }

    /// Rise per length of cavity at square distance `area` from the axis, from `d(r'^2) / d(r^2) dz' / dz = 1`.
    fn swell(&self, area: f64) -> f64 {
        let squeezed = self.area / (REACH * REACH) * (-area / (REACH * REACH)).exp();
        squeezed / (1.0 - squeezed)
    }
}

/// Rings that run outwards from the impact: height of the surface over that at rest, as a ratio.
fn ripple(radius: f64, time: f64) -> f64 {
    let since = (time - IMPACT).max(0.0);
    let front = 0.9 * since;
    let envelope = ramp((front - radius) / 0.05) * ramp(since / 0.1) * (-radius / 0.2).exp();
    1.0 + 0.005 / DEPTH * envelope * (2.0 * PI * (radius - front) / 0.05).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cavity_opens_to_the_published_depth_and_closes() {
        let open = Cavity::at(CLOSING);
        assert!(open.area.sqrt() > 0.99 * CAVITY_RADIUS && open.bottom < 0.25);
        assert_eq!(Cavity::at(0.0).area, 0.0);
        assert_eq!(Cavity::at(0.4).area, 0.0);
    }

    #[test]
    fn no_column_stands_inside_the_cavity() {
        let flow = SphereEntry::new(100_000, (SphereEntry::volume() / 1e5).cbrt());
        for strand in 0..flow.columns.len() {
            let column = flow.strand_at(strand, CLOSING);
            let top = flow.place(&column, 999, 1000).position;
            assert!(top.truncate().distance(TANK * 0.5) > 0.99 * CAVITY_RADIUS);
        }
    }

    #[test]
    fn rest_is_flat() {
        let flow = SphereEntry::new(1000, (SphereEntry::volume() / 1e3).cbrt());
        let column = flow.strand_at(3, 0.0);
        let placed = flow.place(&column, 0, 2);
        assert_eq!(placed.position.z, 0.25 * DEPTH);
        let at_rest = (TANK * 0.5 + flow.columns[3]).extend(0.25 * DEPTH);
        assert!(placed.position.distance(at_rest) < 1e-12);
    }

    #[test]
    fn the_motion_keeps_volume_beside_the_cavity() {
        let flow = SphereEntry::new(10, 0.1);
        let count = 1 << 20;
        for (distance, z) in [(0.01, 0.37), (0.03, 0.35), (0.06, 0.33)] {
            let place = |at: DVec2, ranks: i64| {
                let rank = (z / DEPTH * count as f64) as i64 + ranks;
                let column = Column { at, cavity: Cavity::at(CLOSING), ripple: 1.0 };
                flow.place(&column, rank as u64, count).position
            };
            let (at, step, ranks) = (DVec2::new(distance, 0.0), 1e-5, 64);
            let difference = |by: DVec2, ranks: i64| place(at + by, ranks) - place(at - by, -ranks);
            let volume = difference(DVec2::X * step, 0)
                .cross(difference(DVec2::Y * step, 0))
                .dot(difference(DVec2::ZERO, ranks));
            let rest = 8.0 * step * step * ranks as f64 * DEPTH / count as f64;
            // Differences of second order, over steps a thousandth of the distance.
            assert!((volume / rest - 1.0).abs() < 1e-4, "{distance}: {}", volume / rest);
        }
    }
}
