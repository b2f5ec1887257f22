use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::flight::Flight;
use crate::flow::{Flow, Placed, ramp};
use crate::golden::{Dice, share_out};

/// South-western corner of the map, and the height of the water at rest, m.
pub(crate) const ORIGIN: DVec3 = DVec3::new(495_500.0, 3_400_000.0, 175.0);
/// Length of the reach along x, m.
pub(crate) const LENGTH: f64 = 9000.0;
/// No shore is further from the centre line than this along y, m.
const HALF_BAND: f64 = 700.0;

/// Upright columns on a square grid over a winding valley. Each moves along the valley with the wave, and stands as high
/// as keeps its volume in the section it has come to.
pub(crate) struct Fjord {
    columns: Vec<Column>,
    starts: Vec<u64>,
    spacing: f64,
}

/// A column at rest in valley coordinates.
#[derive(Clone, Copy)]
struct Column {
    /// x of the nearest point of the centre line, from the map's corner, m.
    along: f64,
    /// Distance from the centre line over the half width: -1 at the right shore, 1 at the left.
    across: f64,
}

/// A column at one time.
pub(crate) struct Standing {
    /// Foot of the column, file space.
    foot: DVec3,
    height: f64,
}

impl Fjord {
    /// m^3
    pub(crate) fn volume() -> f64 {
        // Curvature adds as much on the outer as it takes on the inner side. Midpoint rule, exact to 1e-6 for these
        // smooth sections; the across integral of `bowl` is 1.68 half widths.
        let steps = 4000;
        let step = LENGTH / steps as f64;
        let section = |x: f64| Valley::at(x);
        (0..steps)
            .map(|i| section((i as f64 + 0.5) * step))
            .map(|valley| 1.68 * valley.half_width * valley.depth * valley.stretch() * step)
            .sum()
    }

    pub(crate) fn new(particles: u64, spacing: f64) -> Self {
        let rows = (LENGTH + 2.0 * HALF_BAND) / spacing;
        let mut columns: Vec<Column> = (0..rows as i64 + 1)
            .into_par_iter()
            .flat_map_iter(|row| {
                let x = (row as f64 + 0.5) * spacing - HALF_BAND;
                let middle = Valley::at(x).y;
                // Grid lines are the same for all rows, whatever the centre line does.
                let cells = |y: f64| (y / spacing).floor() as i64;
                (cells(middle - HALF_BAND)..=cells(middle + HALF_BAND))
                    .filter_map(move |cell| Column::over(DVec2::new(x, (cell as f64 + 0.5) * spacing)))
            })
            .collect();
        if columns.is_empty() {
            columns.push(Column { along: LENGTH * 0.5, across: 0.0 });
        }
        let depths: Vec<f64> = columns.iter().map(|column| column.depth()).collect();
        Self { starts: share_out(particles, &depths), columns, spacing }
    }
}

impl Flow for Fjord {
    type Strand = Standing;

    fn starts(&self) -> &[u64] {
        &self.starts
    }

    fn strand_at(&self, strand: usize, time: f64) -> Standing {
        self.columns[strand].standing(time)
    }

    fn place(&self, standing: &Standing, rank: u64, count: u64) -> Placed {
        let up = (rank as f64 + 0.5) / count as f64 * standing.height;
        Placed { position: standing.foot + DVec3::Z * up, depth: standing.height - up }
    }

    fn flight(&self, strand: usize, rank: u64, count: u64, dice: &mut Dice) -> Option<Flight> {
        let layer = count - 1 - rank;
        if layer > 5 {
            return None;
        }
        let column = self.columns[strand];
        let slide = DVec2::new(column.along - SLIDE.x, (column.across - SLIDE.y) * 300.0).length();
        if slide < 260.0 && dice.roll() < 0.3 {
            let nearness = 1.0 - slide / 260.0;
            return Some(Flight {
                launch: 4.0 + 8.0 * dice.roll() + 0.02 * slide,
                rise: (8.0 + 26.0 * nearness) * dice.between(0.5, 1.0),
                drift: DVec2::from_angle(dice.between(0.0, std::f64::consts::TAU)) * dice.between(0.0, 6.0)
                    - Valley::at(column.along).left() * 8.0,
            });
        }
        // The crest throws spray where it is highest, in bursts 40 m apart.
        let burst = (column.along / 40.0).floor() as i64 % 3 == 0;
        let passing = (column.along - WAVE_START) / WAVE_SPEED - 10.0;
        (layer < 2 && passing > 10.0 && burst && dice.roll() < 0.05).then(|| Flight {
            launch: passing + dice.between(-2.0, 4.0),
            rise: dice.between(4.0, 13.0),
            drift: DVec2::new(dice.between(0.0, 8.0), dice.between(-3.0, 3.0)) * self.spacing.min(1.0),
        })
    }
}

/// Where the sliding mass meets the water: x from the map's corner (m), and place across.
const SLIDE: DVec2 = DVec2::new(1500.0, 0.75);

impl Column {
    /// The column over a point given from the map's corner, if there is water.
    fn over(point: DVec2) -> Option<Self> {
        let (along, offset) = Valley::project(point);
        let across = offset / Valley::at(along).half_width;
        (across.abs() < 1.0 && (0.0..LENGTH).contains(&along)).then_some(Self { along, across })
    }

    /// Where it stands at `time` (s), and how high.
    fn standing(&self, time: f64) -> Standing {
        let (shift, strain) = wave(self.along, time);
        let (rest, now) = (Valley::at(self.along), Valley::at(self.along + shift));
        let offset = self.across * now.half_width;
        let squeeze =
            (1.0 + strain) * now.area_scale(offset) / rest.area_scale(self.across * rest.half_width);
        let height = rest.depth * bowl(self.across) / squeeze + seiche(*self, &now, time);
        let bed = ORIGIN.z - now.depth * bowl(self.across);
        let foot = DVec2::new(self.along + shift, now.y) + now.left() * offset;
        Standing { foot: (ORIGIN.truncate() + foot).extend(bed), height }
    }

    fn depth(&self) -> f64 {
        Valley::at(self.along).depth * bowl(self.across)
    }
}

/// Depth across the valley over the depth in its middle: steep shores that still stand in deep water.
pub(crate) fn bowl(across: f64) -> f64 {
    1.0 - 0.8 * across.powi(4)
}

/// The valley at one x of its centre line.
pub(crate) struct Valley {
    /// Centre line and its derivatives with respect to x.
    pub y: f64,
    slope: f64,
    bend: f64,
    /// m
    pub half_width: f64,
    /// In the middle, m.
    pub depth: f64,
}

impl Valley {
    /// At `x` from the map's corner; also defined beyond the ends.
    pub(crate) fn at(x: f64) -> Self {
        // Radius of curvature at least 700 m, twice the half width, so that every point has one nearest centre.
        let (mut y, mut slope, mut bend) = (0.0, 0.0, 0.0);
        for (amplitude, length, phase) in [(850.0, 7500.0, 0.0), (190.0, 3400.0, 1.0)] {
            let k = std::f64::consts::TAU / length;
            let (sin, cos) = (k * x + phase).sin_cos();
            y += amplitude * sin;
            slope += amplitude * k * cos;
            bend -= amplitude * k * k * sin;
        }
        let half_width = 285.0 + 55.0 * (std::f64::consts::TAU * x / 4100.0 + 2.0).sin();
        let depth = 130.0 + 15.0 * (std::f64::consts::TAU * x / 5300.0).sin();
        Self { y, slope, bend, half_width, depth }
    }

    /// Length of the centre line per x.
    pub(crate) fn stretch(&self) -> f64 {
        self.slope.hypot(1.0)
    }

    /// Unit vector across, to the left of increasing x.
    fn left(&self) -> DVec2 {
        DVec2::new(-self.slope, 1.0) / self.stretch()
    }

    /// Map area per x and place across, at `offset` (m) to the left of the centre line.
    fn area_scale(&self, offset: f64) -> f64 {
        let curvature = self.bend / self.stretch().powi(3);
        self.stretch() * (1.0 - curvature * offset) * self.half_width
    }

    /// Nearest centre x and distance to the left of a point near the valley: Newton's method on the distance.
    fn project(point: DVec2) -> (f64, f64) {
        let mut x = point.x;
        for _ in 0..8 {
            let valley = Self::at(x);
            let miss = valley.y - point.y;
            let gradient = (x - point.x) + miss * valley.slope;
            // Without the bend where it would turn the step round.
            let steepness = (1.0 + valley.slope * valley.slope + miss * valley.bend).max(0.5);
            x -= gradient / steepness;
        }
        let valley = Self::at(x);
        (x, (point - DVec2::new(x, valley.y)).dot(valley.left()))
    }
}

/// Centre of the main hump of displacement at time 0, m.
const WAVE_START: f64 = 1200.0;
/// Speed of the wave along x, m/s.
const WAVE_SPEED: f64 = 30.0;

/// Displacement along x (m) of the water that rests at `along`, and its derivative. Humps of displacement make a crest
/// before and a trough behind them.
fn wave(along: f64, time: f64) -> (f64, f64) {
    let growth = ramp(time / 40.0);
    let centre = WAVE_START + WAVE_SPEED * time;
    let humps = [(45.0, 0.0, 420.0), (-20.0, -1000.0, 330.0), (9.0, -1700.0, 260.0)];
    humps.into_iter().fold((0.0, 0.0), |(shift, strain), (amplitude, lag, width)| {
        let x = (along - centre - lag) / width;
        let hump = amplitude * growth * (-x * x).exp();
        (shift + hump, strain - 2.0 * x / width * hump)
    })
}

/// Rise (m) of the surface that swings from shore to shore behind the wave.
fn seiche(column: Column, valley: &Valley, time: f64) -> f64 {
    let behind = WAVE_START + WAVE_SPEED * time - column.along;
    let envelope = ramp(behind / 600.0) * (-(behind / 2500.0).powi(2)).exp() * ramp(time / 40.0);
    let turns = column.along / 700.0 - time / 35.0;
    // Odd across times the bowl, so that shallow columns rise by no more than their share.
    let rise = 4.0 * (column.across * std::f64::consts::FRAC_PI_2).sin() * bowl(column.across);
    rise * envelope * (std::f64::consts::TAU * turns).sin() * valley.depth / 130.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn projection_finds_the_place_in_the_valley() {
        for along in [100.0, 2300.0, 4700.0, 8800.0] {
            for across in [-0.95, 0.0, 0.8] {
                let valley = Valley::at(along);
                let offset = across * valley.half_width;
                let point = DVec2::new(along, valley.y) + valley.left() * offset;
                let (x, left) = Valley::project(point);
                assert!(
                    (x - along).abs() < 1e-3 && (left - offset).abs() < 1e-3,
                    "{along} {across}: {x} {left}"
                );
            }
        }
    }

    #[test]
    fn strain_is_the_derivative_of_the_shift() {
        for along in [1000.0, 2400.0, 4000.0] {
            let step = 1e-3;
            let difference = (wave(along + step, 70.0).0 - wave(along - step, 70.0).0) / (2.0 * step);
            assert!((difference - wave(along, 70.0).1).abs() < 1e-8);
        }
    }

    #[test]
    fn the_columns_fill_the_volume_and_keep_it() {
        let spacing = 20.0;
        let fjord = Fjord::new(100_000, spacing);
        let filled = fjord.columns.iter().map(Column::depth).sum::<f64>() * spacing * spacing;
        // The shore cuts through a cell in thirty.
        assert!((filled / Fjord::volume() - 1.0).abs() < 0.005, "{}", filled / Fjord::volume());

        for (along, across) in [(2900.0, 0.0), (3300.0, -0.7), (4100.0, 0.6)] {
            // Volume over a small patch of valley coordinates, without the seiche, which is even only over a section.
            let volume = |time: f64| {
                let stand =
                    |da: f64, dc: f64| Column { along: along + da, across: across + dc }.standing(time);
                let (a, b) = (
                    stand(0.5, 0.0).foot - stand(-0.5, 0.0).foot,
                    stand(0.0, 5e-4).foot - stand(0.0, -5e-4).foot,
                );
                let column = Column { along, across };
                let rise = seiche(column, &Valley::at(along + wave(along, time).0), time);
                a.truncate().perp_dot(b.truncate()) * (stand(0.0, 0.0).height - rise)
            };
            // Second-order differences over 1 m and a thousandth of the width.
            assert!((volume(60.0) / volume(0.0) - 1.0).abs() < 1e-4, "{}", volume(60.0) / volume(0.0));
        }
    }
}
