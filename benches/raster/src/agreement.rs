use meniscus_gpu::role::NO_SURFACE;

/// Largest difference between distances that are the same but for rounding, in radii. Both passes subtract coordinates of up to 0.4
/// that are known to 3e-8, a ten-thousandth of the smallest radius, and take square roots of what remains, which near an outline is
/// ten times less certain.
const TOLERANCE_RADII: f32 = 0.01;

/// Least share of the pixels that has to agree with a software driver. The others lie on outlines, where a rounding decides which
/// sphere is hit.
const LEAST_SHARE: f64 = 0.999;
/// The same with a GPU, which places the corners of triangles in steps of 1/256 pixel: an NVIDIA H100 moves 0.34 % of the pixels of
/// spheres of 1.25 pixels.
const LEAST_SHARE_OF_GPUS: f64 = 0.995;

/// How two pictures of the same spheres compare.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Agreement {
    /// Pixels with a sphere in either.
    pub covered: usize,
    /// Those of them in which the distances agree.
    pub equal: usize,
}

impl Agreement {
    /// Compares distances along the view axis, pixel by pixel.
    pub(crate) fn of(a: &[f32], b: &[f32], radius_world: f32) -> Self {
        assert_eq!(a.len(), b.len(), "pictures of different sizes");
        let covered = a.iter().zip(b).filter(|(a, b)| a.min(**b) < NO_SURFACE);
        let is_equal = |(a, b): &(&f32, &f32)| (**a - **b).abs() <= TOLERANCE_RADII * radius_world;
        Self { covered: covered.clone().count(), equal: covered.filter(is_equal).count() }
    }

    /// Share of the covered pixels that differ.
    pub(crate) fn differing_percent(self) -> f64 {
        100.0 * (self.covered - self.equal) as f64 / self.covered as f64
    }

    /// Whether both are the same picture, as far as a software driver or a GPU can be asked for.
    pub(crate) fn is_enough(self, is_software: bool) -> bool {
        let least = if is_software { LEAST_SHARE } else { LEAST_SHARE_OF_GPUS };
        self.covered > 0 && self.equal as f64 >= least * self.covered as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_rounding_and_few_of_the_covered_pixels_may_differ() {
        let mut a = vec![1.0; 1000];
        a.extend([NO_SURFACE; 5000]);
        let mut b = a.clone();
        b[0] = 1.0009;
        assert_eq!(Agreement::of(&a, &b, 0.1), Agreement { covered: 1000, equal: 1000 });
        b[0] = 1.0011;
        let agreement = Agreement::of(&a, &b, 0.1);
        assert!(agreement.is_enough(true) && agreement.is_enough(false));
        // Only one of them has a sphere here.
        b[1] = NO_SURFACE;
        let agreement = Agreement::of(&a, &b, 0.1);
        assert_eq!(agreement, Agreement { covered: 1000, equal: 998 });
        assert!(!agreement.is_enough(true) && agreement.is_enough(false));
        b[2..6].fill(NO_SURFACE);
        let agreement = Agreement::of(&a, &b, 0.1);
        assert_eq!(agreement, Agreement { covered: 1000, equal: 994 });
        assert!(!agreement.is_enough(false));
        assert!(!Agreement::of(&[NO_SURFACE], &[NO_SURFACE], 0.1).is_enough(false), "two empty pictures");
    }
}
