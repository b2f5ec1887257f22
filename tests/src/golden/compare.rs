//! One picture against the expected one, within limits that say why.

use serde::{Deserialize, Serialize};

use super::metrics::{flip_map, percentile, ssim_map};
use crate::{Mask, Pixels};

/// A limit and its reason.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limit {
    /// The largest value that passes; for similarity the smallest.
    pub limit: f64,
    /// Why this number.
    pub reason: String,
}

/// What a picture is judged by. Those left out are not looked at.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Criteria {
    /// Mean FLIP error in the mask.
    pub flip_mean: Option<Limit>,
    /// 99th percentile of the FLIP error in the mask.
    pub flip_p99: Option<Limit>,
    /// Mean structural similarity in the mask.
    pub ssim: Option<Limit>,
    /// Change of the number of pixels that show water, as a part of the expected number.
    pub mask_area: Option<Limit>,
}

/// Why two pictures cannot be compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CompareError {
    /// A check that cannot fail is none.
    #[error("no criterion is given, so nothing would be checked; give limits in cases.toml")]
    NoCriterion,
    /// Another size.
    #[error("the picture is {}x{}, expected is {}x{}", ours[0], ours[1], expected[0], expected[1])]
    Size {
        /// Of the picture.
        ours: [u32; 2],
        /// Of the expected one.
        expected: [u32; 2],
    },
    /// Neither picture shows water.
    #[error("neither the picture nor the expected one shows water, so nothing would be compared")]
    NoWater,
}

/// One measured value beside its limit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Metric {
    /// Which.
    pub name: &'static str,
    /// Measured.
    pub value: f64,
    /// Its limit.
    pub limit: f64,
    /// Why that.
    pub reason: String,
    /// Whether larger values are better.
    pub more_is_better: bool,
    /// Whether the limit is kept. Not so for NaN.
    pub passed: bool,
}

/// How a picture differs.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// One per criterion.
    pub metrics: Vec<Metric>,
    /// FLIP error per pixel, row by row from the top left.
    pub flip: Vec<f32>,
}

impl Comparison {
    /// Whether every limit is kept.
    pub fn passed(&self) -> bool {
        self.metrics.iter().all(|metric| metric.passed)
    }
}

/// By how much the mask is widened, pixels: anti-aliasing and the filters of FLIP reach over the silhouette.
const MARGIN: usize = 3;

/// Compares `ours` with `expected` where either shows water: what is gone counts like what is new.
///
/// # Errors
/// [`CompareError`]: there is nothing to compare, which never passes for a success.
pub fn compare(
    ours: (&Pixels, &Mask),
    expected: (&Pixels, &Mask),
    criteria: &Criteria,
) -> Result<Comparison, CompareError> {
    let Criteria { flip_mean, flip_p99, ssim, mask_area } = criteria;
    if [flip_mean, flip_p99, ssim, mask_area].into_iter().all(Option::is_none) {
        return Err(CompareError::NoCriterion);
    }
    if ours.0.size != expected.0.size || !ours.1.has_size(expected.1) {
        return Err(CompareError::Size { ours: ours.0.size, expected: expected.0.size });
    }
    let mask = ours.1.union(expected.1).dilated(MARGIN);
    if mask.area() == 0 {
        return Err(CompareError::NoWater);
    }
    let flip = flip_map(expected.0, ours.0);
    let mean = |values: &[f32]| values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64;
    let area = expected.1.area().max(1) as f64;
    let change = ours.1.area().abs_diff(expected.1.area()) as f64 / area;
    let judge = |name, value: f64, criterion: &Option<Limit>, more_is_better: bool| {
        let Limit { limit, reason } = criterion.clone()?;
        let passed = if more_is_better { value >= limit } else { value <= limit };
        Some(Metric { name, value, limit, reason, more_is_better, passed })
    };
    let flip_inside = mask.pick(&flip);
    let metrics = [
        judge("FLIP mean", mean(&flip_inside), flip_mean, false),
        judge("FLIP 99 %", percentile(flip_inside, 0.99), flip_p99, false),
        judge("SSIM", mean(&mask.pick(&ssim_map(expected.0, ours.0))), ssim, true),
        judge("mask area", change, mask_area, false),
    ];
    let metrics = metrics.into_iter().flatten().collect();
    Ok(Comparison { metrics, flip })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [64, 48];

    fn limit(limit: f64) -> Option<Limit> {
        Some(Limit { limit, reason: "a test".to_owned() })
    }

    /// The limits of `cases.toml` for the driver that made the expectations.
    fn strict() -> Criteria {
        Criteria { flip_mean: limit(0.002), flip_p99: limit(0.02), ssim: limit(0.998), mask_area: limit(0.0) }
    }

    /// Rippled water in the middle and, where `splash`, a drop of some pixels above it; moved right by `shift` pixels and
    /// brighter by `light`.
    fn picture(splash: bool, shift: u32, light: u8) -> (Pixels, Mask) {
        let is_water = |x: u32, y: u32| {
            let drop = splash && (30..34).contains(&x) && (8..12).contains(&y);
            drop || ((10..54).contains(&x) && (20..40).contains(&y))
        };
        let pixels = || (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x.wrapping_sub(shift), y)));
        let colour = |(x, y)| match is_water(x, y) {
            true => [40 + (x % 8) as u8 * 6 + light, 90 + (y % 5) as u8 * 9 + light, 140 + light, 255],
            false => [180 + light, 180 + light, 170 + light, 255],
        };
        let water = pixels().map(|(x, y)| is_water(x, y)).collect();
        (Pixels { size: SIZE, rgba: pixels().map(colour).collect() }, Mask::new(SIZE, water))
    }

    fn judged(ours: &(Pixels, Mask)) -> Comparison {
        let expected = picture(true, 0, 0);
        compare((&ours.0, &ours.1), (&expected.0, &expected.1), &strict()).unwrap()
    }

    fn failed(comparison: &Comparison) -> Vec<&'static str> {
        comparison.metrics.iter().filter(|m| !m.passed).map(|m| m.name).collect()
    }

    #[test]
    fn the_same_picture_passes() {
        let comparison = judged(&picture(true, 0, 0));
        assert!(comparison.passed() && comparison.metrics.len() == 4, "{:?}", comparison.metrics);
    }

    #[test]
    fn a_picture_shifted_by_a_pixel_fails() {
        let comparison = judged(&picture(true, 1, 0));
        assert_eq!(failed(&comparison), ["FLIP mean", "FLIP 99 %", "SSIM"], "{:?}", comparison.metrics);
    }

    #[test]
    fn a_brighter_picture_fails() {
        // Two steps of 255 are less than anybody sees, and more than any arithmetic may differ by.
        let comparison = judged(&picture(true, 0, 2));
        assert!(failed(&comparison).contains(&"FLIP mean"), "{:?}", comparison.metrics);
    }

    #[test]
    fn a_missing_splash_fails_though_it_is_small() {
        let comparison = judged(&picture(false, 0, 0));
        assert!(failed(&comparison).contains(&"mask area"), "{:?}", comparison.metrics);
        assert!(failed(&comparison).contains(&"FLIP 99 %"), "{:?}", comparison.metrics);
    }

    #[test]
    fn a_new_splash_fails_by_its_look_too() {
        let (ours, expected) = (picture(true, 0, 0), picture(false, 0, 0));
        let new = compare((&ours.0, &ours.1), (&expected.0, &expected.1), &strict()).unwrap();
        assert!(failed(&new).contains(&"FLIP 99 %"), "{:?}", new.metrics);
    }

    #[test]
    fn what_cannot_be_compared_is_an_error_not_a_pass() {
        let whole = picture(true, 0, 0);
        let small = Pixels { size: [64, 24], rgba: whole.0.rgba[..64 * 24].to_vec() };
        let small_mask = Mask::new([64, 24], vec![true; 64 * 24]);
        let size = compare((&small, &small_mask), (&whole.0, &whole.1), &strict());
        assert!(matches!(size, Err(CompareError::Size { ours: [64, 24], .. })));
        let nothing = compare((&whole.0, &whole.1), (&whole.0, &whole.1), &Criteria::default());
        assert_eq!(nothing.unwrap_err(), CompareError::NoCriterion);
        let dry = Mask::new(SIZE, vec![false; 64 * 48]);
        assert_eq!(
            compare((&whole.0, &dry), (&whole.0, &dry), &strict()).unwrap_err(),
            CompareError::NoWater
        );
    }
}
