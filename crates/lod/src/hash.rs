//! The 16-bit number that decides which of a chunk's particles go first.

use glam::Vec3;

/// What a particle's hash is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Identity {
    /// The particle's id: the same particles are kept while they move.
    #[default]
    Id,
    /// The source's sine hash of the position (\[T\] equation 3.2). It boils on moving particles and degenerates for large
    /// coordinates; kept for comparison.
    Position,
}

impl Identity {
    /// Hash of the particle with this id and position, uniform over 0..65536.
    pub(crate) fn hash(self, id: u64, position: Vec3) -> u16 {
        match self {
            Self::Id => (murmur_finaliser(id) >> 48) as u16,
            // The source keeps high random numbers first, a prefix keeps low hashes first. The cast saturates.
            Self::Position => ((1.0 - sine_random(position)) * 65536.0) as u16,
        }
    }
}

/// MurmurHash3's 64-bit finaliser (Appleby, public domain): a bijection in which every input bit changes every output bit
/// with probability 1/2, so that consecutive ids give unrelated hashes.
fn murmur_finaliser(mut x: u64) -> u64 {
    x = (x ^ (x >> 33)).wrapping_mul(0xff51_afd7_ed55_8ccd);
    x = (x ^ (x >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    x ^ (x >> 33)
}

/// \[T\] equation 3.2, in single precision as in the source's shader; in [0, 1).
fn sine_random(position: Vec3) -> f32 {
    let wave = position.dot(Vec3::new(12.9898, 78.233, 54.143)).sin() * 437_586.53;
    wave - wave.floor()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn consecutive_ids_fill_the_range_evenly() {
        let n = 1 << 18;
        let mut bins = [0u32; 256];
        (0..n).for_each(|id| bins[usize::from(Identity::Id.hash(id, Vec3::ZERO) >> 8)] += 1);
        let expected = n as f64 / 256.0;
        let chi_squared: f64 = bins.iter().map(|&b| (f64::from(b) - expected).powi(2) / expected).sum();
        // Chi-squared with 255 degrees of freedom: mean 255, standard deviation 22.6; five deviations.
        assert!((255.0 - chi_squared).abs() < 113.0, "{chi_squared}");
    }

    #[test]
    fn the_finaliser_is_the_published_one() {
        // SMHasher's fmix64 maps 0 to 0, and 1 to this.
        assert_eq!(murmur_finaliser(0), 0);
        assert_eq!(murmur_finaliser(1), 0xb456_bcfc_34c2_cb2c);
    }

    #[test]
    fn the_sine_hash_follows_the_formula() {
        for k in 1..50 {
            let p = Vec3::new(1e-4, 2e-5, -3e-5) * k as f32;
            let wave = p.as_dvec3().dot(glam::DVec3::new(12.9898, 78.233, 54.143)).sin() * 437_586.545_3;
            let expected = 1.0 - (wave - wave.floor());
            let apart = (f64::from(Identity::Position.hash(0, p)) / 65536.0 - expected).abs();
            // The sine is below 0.07 and rounded to 4e-9 a few times; times 437586.
            assert!(apart.min(1.0 - apart) < 1e-2, "{k}: off by {apart} of {expected}");
        }
    }
}
