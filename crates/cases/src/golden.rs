//! Evenly spread points in any number, and random numbers that depend on the particle alone.

/// Fractional part of the golden ratio.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// Point `rank` of `count` in the unit square: the lattice of steps `(1 / count, golden ratio)`, wrapped in the second
/// coordinate.
///
/// Area-preserving stretches along the two axes leave its points apart: no two come nearer than 0.87 of the root of the
/// area per point, because the golden ratio is the number worst approximated by fractions. It is what makes a lattice
/// survive planar elongation (Kraynik and Reinelt, *Int. J. Multiphase Flow* 18, 1992), here the collapse of a column into
/// a sheet. Wrapped around an axis as `(r^2, angle)` it is Vogel's sunflower, which an opening cavity shifts outwards
/// without changing its spacing.
pub(crate) fn golden_point(rank: u64, count: u64, shift: [f64; 2]) -> [f64; 2] {
    let along = (rank as f64 + shift[0]) / count as f64;
    let across = (rank as f64 * GOLDEN + shift[1]).fract();
    [along, across]
}

/// Random numbers of one particle: a function of the seed and the particle's identity, so neither order nor threads
/// matter (SplitMix64; Steele, Lea and Flood, OOPSLA 2014).
pub(crate) struct Dice(u64);

impl Dice {
    /// The sequence of particle `id`.
    pub(crate) fn new(seed: u64, id: u64) -> Self {
        Self(scramble(seed) ^ scramble(id.wrapping_mul(0x2545_f491_4f6c_dd1d)))
    }

    /// Next number, uniform in [0, 1).
    pub(crate) fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (scramble(self.0) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Next number, uniform in [low, high).
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + self.roll() * (high - low)
    }
}

fn scramble(mut z: u64) -> u64 {
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

/// Shares `total` items out in proportion to `weights`: where each part begins, and `total` at the end. Each part gets its
/// exact share to within one item. All items go to the last part where no weight is positive.
pub(crate) fn share_out(total: u64, weights: &[f64]) -> Vec<u64> {
    let sum: f64 = weights.iter().sum();
    let mut before = 0.0;
    let mut starts: Vec<u64> = weights
        .iter()
        .map(|weight| {
            let start = if sum > 0.0 { (total as f64 * (before / sum)) as u64 } else { 0 };
            before += weight;
            start.min(total)
        })
        .collect();
    starts.push(total);
    starts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stretched_golden_points_stay_apart() {
        let count = 400;
        for stretch in [0.1, 0.3, 1.0, 2.2, 5.0, 9.0_f64] {
            let points: Vec<_> = (0..count)
                .map(|rank| {
                    let [a, b] = golden_point(rank, count, [0.5, 0.0]);
                    [a * stretch, b / stretch]
                })
                .collect();
            let spacing = (1.0 / count as f64).sqrt();
            let nearest = points
                .iter()
                .enumerate()
                .flat_map(|(i, a)| points[..i].iter().map(move |b| (a[0] - b[0]).hypot(a[1] - b[1])))
                .fold(f64::INFINITY, f64::min);
            assert!(nearest > 0.87 * spacing, "stretch {stretch}: {}", nearest / spacing);
        }
    }

    #[test]
    fn shares_are_exact() {
        assert_eq!(share_out(10, &[1.0, 3.0, 1.0]), [0, 2, 8, 10]);
        assert_eq!(share_out(1, &[1.0, 1.0, 1.0]), [0, 0, 0, 1]);
        assert_eq!(share_out(7, &[0.0]), [0, 7]);
    }

    #[test]
    fn dice_are_even_and_differ_by_particle_and_seed() {
        let mean: f64 = (0..10_000).map(|id| Dice::new(1, id).roll()).sum::<f64>() / 1e4;
        // Standard deviation of the mean is 0.0029.
        assert!((mean - 0.5).abs() < 0.012, "{mean}");
        assert_ne!(Dice::new(1, 5).roll(), Dice::new(2, 5).roll());
        assert_ne!(Dice::new(1, 5).roll(), Dice::new(1, 6).roll());
    }
}
