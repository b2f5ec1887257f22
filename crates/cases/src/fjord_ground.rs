//! The land around the fjord: its bed, steep banks, and mountains that grow away from them.

use glam::DVec2;
use rayon::prelude::*;

use crate::Ground;
use crate::fjord::{LENGTH, ORIGIN, Valley, bowl};

/// Distance of neighbouring heights, m.
const SPACING: f64 = 10.0;
/// From the map's corner, m: what is covered to the south-west and to the north-east.
const SOUTH_WEST: DVec2 = DVec2::new(-1500.0, -2800.0);
const NORTH_EAST: DVec2 = DVec2::new(LENGTH + 1500.0, 2800.0);
/// Between these distances from where the columns of water end, negative on their side, the bank rises from the bed to
/// [`BANK_TOP`] above the water at rest, m. So columns end inside of it.
const BANK: [f64; 2] = [-32.0, 6.0];
const BANK_TOP: f64 = 9.0;

/// Heights of the ground around the fjord.
pub(crate) fn ground() -> Ground {
    let [columns, rows] = ((NORTH_EAST - SOUTH_WEST) / SPACING).to_array().map(|steps| steps as usize + 1);
    let shore = Shore::new();
    let heights = (0..columns * rows)
        .into_par_iter()
        .map(|i| {
            let place = SOUTH_WEST + SPACING * DVec2::new((i % columns) as f64, (i / columns) as f64);
            (ORIGIN.z + shore.height(place)) as f32
        })
        .collect();
    let south_west = (ORIGIN.truncate() + SOUTH_WEST).to_array();
    Ground { south_west, spacing: SPACING, columns, heights }
}

/// Points of the centre line, with what the valley is like there.
struct Shore(Vec<(f64, DVec2, Valley)>);

impl Shore {
    fn new() -> Self {
        // Beyond the ends, where there is no water, too: nothing there is nearest to an end.
        let steps = (LENGTH + 4000.0) / SPACING;
        let at = |i: usize| {
            let x = i as f64 * SPACING - 2000.0;
            let valley = Valley::at(x);
            (x, DVec2::new(x, valley.y), valley)
        };
        Self((0..=steps as usize).map(at).collect())
    }

    /// Height over the water at rest of the ground at `place`, m from the map's corner.
    fn height(&self, place: DVec2) -> f64 {
        let away = |(_, centre, valley): &(f64, DVec2, Valley)| place.distance(*centre) - valley.half_width;
        let nearest = self.0.iter().min_by(|a, b| away(a).total_cmp(&away(b))).expect("there is a valley");
        let (x, _, valley) = nearest;
        let beside = away(nearest);
        let beyond = (-x).max(x - LENGTH) * valley.stretch();
        let shore = beside.max(beyond);
        let bed = -valley.depth * bowl((1.0 + beside / valley.half_width).clamp(0.0, 1.0));
        let bank = smooth((shore - BANK[0]) / (BANK[1] - BANK[0]));
        let inland = (shore - BANK[1]).max(0.0);
        bed + (BANK_TOP - bed) * bank + mountains(place, inland)
    }
}

/// What rises `inland` of the banks, m: slopes that flatten out a kilometre away, with ridges and gullies.
fn mountains(place: DVec2, inland: f64) -> f64 {
    let slope = 850.0 * (1.0 - (-inland / 850.0).exp());
    let roughness = (inland / 350.0).min(1.0);
    let mut ridges = 0.0;
    let (mut length, mut height) = (700.0, 260.0);
    for octave in 0..6 {
        let noise = noise(place / length + DVec2::splat(17.3 * f64::from(octave)));
        ridges += height * (0.5 - noise.abs());
        length *= 0.5;
        height *= 0.5;
    }
    slope + roughness * ridges
}

/// Value noise, -1 to 1, smooth to the second derivative (Perlin, *Improving Noise*, 2002, has its weights).
fn noise(place: DVec2) -> f64 {
    let cell = place.floor();
    let weight = (place - cell).to_array().map(|t| t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
    let corner = |x: f64, y: f64| {
        let key = ((cell.x + x) as i64 as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ ((cell.y + y) as i64 as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
        let mixed = (key ^ key >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (mixed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let [south, north] = [0.0, 1.0].map(|y| mix(corner(0.0, y), corner(1.0, y), weight[0]));
    mix(south, north, weight[1])
}

fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Case, CaseOptions};

    #[test]
    fn water_stands_on_the_bed_and_its_banks_hold_it() {
        let ground = ground();
        let rows = ground.heights.len() / ground.columns;
        let at = |position: &[f64; 3]| {
            let [x, y] = [0, 1].map(|axis| (position[axis] - ground.south_west[axis]) / ground.spacing);
            assert!(x > 1.0 && y > 1.0 && x < ground.columns as f64 - 2.0 && y < rows as f64 - 2.0, "inside");
            let height = |dx: f64, dy: f64| {
                f64::from(ground.heights[(y + dy) as usize * ground.columns + (x + dx) as usize])
            };
            let (u, v) = (x.fract(), y.fract());
            (1.0 - v) * ((1.0 - u) * height(0.0, 0.0) + u * height(1.0, 0.0))
                + v * ((1.0 - u) * height(0.0, 1.0) + u * height(1.0, 1.0))
        };
        let options = CaseOptions { particles: 200_000, frames: 1, seed: 1 };
        let frame = Case::FjordTsunami.frame(&options, 0);
        let (mut above, mut lowest) = (0, f64::INFINITY);
        for position in &frame.positions {
            let height = position[2] - at(position);
            above += usize::from(height > 0.0);
            // At its ends the water is as deep as in its middle, and the bank holds all of it.
            if (400.0..LENGTH - 400.0).contains(&(position[0] - ORIGIN.x)) {
                lowest = lowest.min(height);
            }
        }
        // What the bank holds of the columns at the shore, and half a jitter at the bed.
        let share = above as f64 / frame.positions.len() as f64;
        assert!((0.9..1.0).contains(&share), "{share}");
        // The bank is 35 m above the foot of the outermost columns, and more above that of steeper ones farther in.
        assert!((-50.0..-30.0).contains(&lowest), "{lowest}");
        // All around, the land is higher than the water.
        let edge = (0..ground.columns).flat_map(|column| [column, (rows - 1) * ground.columns + column]);
        assert!(edge.map(|i| ground.heights[i]).all(|height| height > 175.0 + 50.0));
    }
}
