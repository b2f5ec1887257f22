//! CPU twin of `shaders/common/particle.inc.wgsl`: what the splat passes make of a kept particle.

use meniscus_gpu::role::KeptRange;

/// Fraction of the keep probability over which particles fade in (`main-renderer.md` 3.3).
pub const RAMP: f32 = 0.2;

/// Keep probabilities below which splats begin to grow, and below which they have grown by `p^(-1/3)`, to close holes
/// (`algorithms.md` 2.3). The shell of the fluid is two layers and more: most of it still covers what is behind.
pub const GROWS_BELOW: f32 = 0.75;
/// See [`GROWS_BELOW`].
pub const GROWN_BELOW: f32 = 0.4;

/// Most that splats grow by.
pub const MAX_GROWTH: f32 = 2.0;

/// What level of detail makes of one kept particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kept {
    /// Factor on the particle's volume. Horvitz-Thompson: over all hashes, dropped ones counted as 0, its mean is 1.
    pub weight: f32,
    /// Factor on the drawn radius.
    pub radius: f32,
}

/// Weight and size of a particle under keep probability `keep / 65536`, `None` where it is dropped. `packed` holds the
/// identity hash in its low 16 bits. The ramp narrows to nothing as the probability goes to 1, so that full detail is
/// reached without a step. `closing`, at most 1, is how much of the growth closes holes: the drawn radius that just covers a
/// lattice, over the drawn radius.
pub fn kept(packed: u32, keep: u32, closing: f32) -> Option<Kept> {
    let hash = packed & 0xffff;
    if hash >= keep {
        return None;
    }
    if keep >= KeptRange::KEEP_ALL {
        return Some(Kept { weight: 1.0, radius: 1.0 });
    }
    let p = keep as f32 / 65536.0;
    let u = (hash as f32 + 0.5) / 65536.0;
    let ramp = (RAMP * p).min(1.0 - p);
    let fade = ((p - u) / ramp).clamp(0.0, 1.0);
    let mean_fade = 1.0 - 0.5 * ramp / p;
    Some(Kept { weight: fade / (mean_fade * p), radius: growth(p, closing) * fade.cbrt() })
}

/// Factor on the drawn radius of particles that are kept with probability `p` and do not fade in; `closing` as in [`kept`].
pub(crate) fn growth(p: f32, closing: f32) -> f32 {
    let share = ((GROWS_BELOW - p) / (GROWS_BELOW - GROWN_BELOW)).clamp(0.0, 1.0);
    1.0 + ((closing * p.powf(-1.0 / 3.0)).clamp(1.0, MAX_GROWTH) - 1.0) * share
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cut::MIN_KEEP;

    #[test]
    fn the_mean_weight_over_all_hashes_is_one() {
        for keep in [MIN_KEEP, 17, 100, 1000, 19_661, 40_000, 54_613, 60_000, 65_000, 65_535, 65_536] {
            let sum: f64 =
                (0..65536).filter_map(|hash| kept(hash, keep, 1.0)).map(|k| f64::from(k.weight)).sum();
            // The sum is a midpoint rule, exact but for the cell that holds the ramp's kink: at most 1 / (8 ramp) of a
            // cell, relative 1 / (1.6 keep^2) or less. The rest is the rounding of 65536 weights.
            let bound = 1.0 / (1.6 * f64::from(keep).powi(2)) + 2e-6;
            assert!((sum / 65536.0 - 1.0).abs() < bound, "keep {keep}: {}", sum / 65536.0);
        }
    }

    #[test]
    fn a_particle_comes_in_from_nothing_and_full_detail_has_no_step() {
        for keep in [2000, 30_000, 65_000] {
            let last = kept(keep - 1, keep, 1.0).unwrap();
            // Half a hash step into the ramp, the narrowest of which is 400 steps wide.
            assert!(last.weight * (keep as f32 / 65536.0) < 2e-3, "{last:?}");
            assert_eq!(kept(keep, keep, 1.0), None);
        }
        let almost = kept(30_000, KeptRange::KEEP_ALL - 1, 1.0).unwrap();
        // p = 1 - 1/65536: the weight is 1/p.
        assert!((almost.weight - 1.0).abs() < 3e-5 && almost.radius == 1.0, "{almost:?}");
        // Large spheres cover what smaller ones grow to cover; none shrinks.
        let [grown, half, none] = [1.0, 0.8, 0.1].map(|closing| kept(0, 8192, closing).unwrap().radius);
        assert_eq!([grown, half, none], [2.0, 1.6, 1.0]);
        assert_eq!(kept(65_535, KeptRange::KEEP_ALL, 1.0), Some(Kept { weight: 1.0, radius: 1.0 }));
    }
}
