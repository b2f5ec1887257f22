use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use crate::flight::Flight;
use crate::flow::{Flow, Placed};
use crate::golden::{Dice, golden_point, share_out};

/// Length of the tank, m.
const TANK_LENGTH: f64 = 3.22;
/// Width of tank and column, m.
const WIDTH: f64 = 1.0;
/// Length of the column at rest, m.
const COLUMN_LENGTH: f64 = 1.228;
/// Height of the column at rest, m.
const COLUMN_HEIGHT: f64 = 0.55;
/// Area of a section along the tank, m^2.
const SECTION: f64 = COLUMN_LENGTH * COLUMN_HEIGHT;

/// Upright sheets along the tank. A particle keeps the fraction of water behind it and its fraction of the local height;
/// where those lie follows from the profile of the surface, so that area is preserved by any motion.
pub(crate) struct DamBreak {
    profiles: Vec<Profile>,
    sheets: usize,
    starts: Vec<u64>,
    duration: f64,
}

/// A sheet at one time.
pub(crate) struct Sheet {
    y: f64,
    /// Moves the lattice from sheet to sheet.
    shift: [f64; 2],
    /// First of the three profiles mixed, and their weights.
    mix: (usize, [f64; 3]),
}

impl DamBreak {
    /// m^3
    pub(crate) fn volume() -> f64 {
        SECTION * WIDTH
    }

    pub(crate) fn new(particles: u64, spacing: f64, duration: f64) -> Self {
        let sheets = (WIDTH / spacing).round().max(1.0) as usize;
        let profiles = vec![
            Profile::new(COLUMN_LENGTH, |_| 1.0),
            Profile::new(2.2, |x| 0.12 + 0.38 * (1.0 - x / 2.2).powf(1.2)),
            Profile::new(TANK_LENGTH, |x| 0.07 + 0.33 * (1.0 - x / TANK_LENGTH).powf(1.5)),
            Profile::new(TANK_LENGTH, |x| 0.13 + 0.55 * (-((TANK_LENGTH - x) / 0.33).powi(2)).exp()),
            Profile::new(TANK_LENGTH, |x| 0.16 + 0.2 * (-((2.2 - x) / 0.35).powi(2)).exp()),
            Profile::new(TANK_LENGTH, |x| 0.18 + 0.1 * (-((0.7 - x) / 0.45).powi(2)).exp()),
        ];
        Self { profiles, sheets, starts: share_out(particles, &vec![1.0; sheets]), duration }
    }

    fn y(&self, sheet: usize) -> f64 {
        (sheet as f64 + 0.5) / self.sheets as f64 * WIDTH
    }

    fn shift(sheet: usize) -> [f64; 2] {
        // Steps of the two-dimensional golden ratio, so that no sheet repeats a near one.
        [0.754_877_666_2, 0.569_840_291].map(|step| (step * sheet as f64).fract())
    }
}

impl Flow for DamBreak {
    type Strand = Sheet;

    fn starts(&self) -> &[u64] {
        &self.starts
    }

    fn strand_at(&self, strand: usize, time: f64) -> Sheet {
        let y = self.y(strand);
        // The front is not straight: parts of it are up to 3 % ahead.
        let ahead = 1.0 + 0.02 * (3.0 * PI * y / WIDTH).sin() + 0.01 * (7.0 * PI * y / WIDTH).cos();
        Sheet { y, shift: Self::shift(strand), mix: blend(time / self.duration * ahead) }
    }

    fn place(&self, sheet: &Sheet, rank: u64, count: u64) -> Placed {
        let [behind, fraction] = golden_point(rank, count, sheet.shift);
        let (first, weights) = sheet.mix;
        let (mut x, mut inverse_height) = (0.0, 0.0);
        for (weight, profile) in weights.into_iter().zip(self.profiles_from(first)) {
            let x_of_profile = profile.place(behind);
            x += weight * x_of_profile;
            inverse_height += weight / profile.height(x_of_profile);
        }
        let height = 1.0 / inverse_height;
        Placed { position: DVec3::new(x, sheet.y, fraction * height), depth: (1.0 - fraction) * height }
    }

    fn flight(&self, strand: usize, rank: u64, count: u64, dice: &mut Dice) -> Option<Flight> {
        let [behind, fraction] = golden_point(rank, count, Self::shift(strand));
        let (kind, sideways) = (dice.roll(), dice.between(-0.25, 0.25));
        if behind > 0.82 && fraction > 0.75 && kind < 0.2 {
            // Thrown up and back by the far wall; sideways only as far as the side walls are away.
            let y = self.y(strand);
            let room = (y.min(WIDTH - y) / 0.2).min(1.0);
            return Some(Flight {
                launch: self.duration * dice.between(0.46, 0.68),
                rise: dice.between(0.8, 2.6) * (0.4 + 0.6 * dice.roll()),
                drift: DVec2::new(-dice.between(0.2, 1.2), sideways * room),
            });
        }
        let front_droplet = behind > 0.93 && fraction > 0.85 && kind > 0.6;
        front_droplet.then(|| Flight {
            launch: self.duration * dice.between(0.12, 0.4),
            rise: dice.between(0.3, 0.9),
            drift: DVec2::new(dice.between(-0.1, 0.1), 0.0),
        })
    }
}

impl DamBreak {
    /// The profiles in order from control point `first` of the blend.
    fn profiles_from(&self, first: usize) -> impl Iterator<Item = &Profile> {
        CONTROLS[first..].iter().map(|&profile| &self.profiles[profile])
    }
}

/// The profiles that the motion passes, in order. Twice in a row, it comes to rest there: at the begin, and when the water
/// stands highest at the far wall.
const CONTROLS: [usize; 8] = [0, 0, 1, 2, 3, 3, 4, 5];

/// First control point and weights of the uniform quadratic B-spline over the profiles at `progress` (0 to 1, clamped).
fn blend(progress: f64) -> (usize, [f64; 3]) {
    const SEGMENTS: usize = CONTROLS.len() - 2;
    let along = progress.clamp(0.0, 1.0) * SEGMENTS as f64;
    let segment = (along as usize).min(SEGMENTS - 1);
    let f = along - segment as f64;
    (segment, [0.5 * (1.0 - f) * (1.0 - f), 0.5 + f - f * f, 0.5 * f * f])
}

/// Height of the surface along the tank, with its area scaled to [`SECTION`].
struct Profile {
    length: f64,
    scale: f64,
    shape: fn(f64) -> f64,
    /// Position that has the fraction `i / CELLS` of the area behind it.
    quantiles: Vec<f64>,
}

impl Profile {
    const CELLS: usize = 4096;

    /// `shape`: height at each x in [0, `length`], positive, any scale.
    fn new(length: f64, shape: fn(f64) -> f64) -> Self {
        let step = length / Self::CELLS as f64;
        let mut area_behind = vec![0.0];
        for cell in 0..Self::CELLS {
            area_behind.push(area_behind[cell] + shape((cell as f64 + 0.5) * step) * step);
        }
        let area = area_behind[Self::CELLS];
        let mut cell = 0;
        let quantiles = (0..=Self::CELLS)
            .map(|i| {
                let wanted = area * i as f64 / Self::CELLS as f64;
                while cell + 1 < Self::CELLS && area_behind[cell + 1] < wanted {
                    cell += 1;
                }
                let within = (wanted - area_behind[cell]) / (area_behind[cell + 1] - area_behind[cell]);
                (cell as f64 + within) * step
            })
            .collect();
        Self { length, scale: SECTION / area, shape, quantiles }
    }

    /// Position with the fraction `behind` (0 to 1) of the area behind it.
    fn place(&self, behind: f64) -> f64 {
        let along = behind.clamp(0.0, 1.0) * Self::CELLS as f64;
        let cell = (along as usize).min(Self::CELLS - 1);
        let within = along - cell as f64;
        self.quantiles[cell] + within * (self.quantiles[cell + 1] - self.quantiles[cell])
    }

    fn height(&self, x: f64) -> f64 {
        self.scale * (self.shape)(x.min(self.length))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_invert_the_area() {
        let dam = DamBreak::new(1000, 0.1, 2.0);
        for profile in &dam.profiles {
            let steps = 100_000;
            let x_step = profile.place(0.7) / steps as f64;
            let area: f64 = (0..steps).map(|i| profile.height((i as f64 + 0.5) * x_step) * x_step).sum();
            // The table is linear within a cell of 1/4096 of the area.
            assert!((area / SECTION - 0.7).abs() < 1e-4, "{}", area / SECTION);
        }
    }

    #[test]
    fn the_front_starts_at_rest_and_reaches_the_far_wall() {
        let dam = DamBreak::new(1000, 0.1, 2.0);
        let front = |time: f64| {
            let (first, weights) = blend(time / 2.0);
            weights
                .into_iter()
                .zip(dam.profiles_from(first))
                .map(|(w, profile)| w * profile.place(1.0))
                .sum::<f64>()
        };
        assert!((front(0.0) - COLUMN_LENGTH).abs() < 1e-9);
        assert!((front(0.01) - front(0.0)) / 0.01 < 0.1, "starts from rest");
        assert!(front(0.6) > 2.0 && front(0.6) < 3.1);
        assert!((front(1.0) - TANK_LENGTH).abs() < 1e-9);
    }
}
