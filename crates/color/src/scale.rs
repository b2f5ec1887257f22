use crate::{ColorError, ColorMap, Quantity};

/// Share of the values at either end that an automatic range leaves out: single particles that fly off would take up most of
/// the colours.
const STRAY: f64 = 1e-3;
/// Most orders of magnitude of an automatic logarithmic range.
const MOST_DECADES: f64 = 12.0;

/// Which colour a quantity has, the same over a whole series.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorScale {
    /// What is shown.
    pub quantity: Quantity,
    /// In which colours.
    pub map: ColorMap,
    /// Value at the start of the map.
    pub min: f64,
    /// Value at the end of the map, >= `min`.
    pub max: f64,
    /// Whether equal ratios have equal distances, instead of equal differences; `min` is then > 0.
    pub log: bool,
}

impl ColorScale {
    /// A scale with these limits.
    ///
    /// # Errors
    /// [`ColorError::Range`]: limits that are not finite or fall, or a logarithm of nothing.
    pub fn new(
        quantity: Quantity,
        map: ColorMap,
        [min, max]: [f64; 2],
        log: bool,
    ) -> Result<Self, ColorError> {
        let fail = |expected| Err(ColorError::Range { min, max, expected });
        if !(min.is_finite() && max.is_finite()) {
            return fail("both must be numbers");
        }
        if min > max {
            return fail("the first must not be larger than the second");
        }
        if log && min <= 0.0 {
            return fail("a logarithmic scale begins above 0");
        }
        Ok(Self { quantity, map, min, max, log })
    }

    /// Start of the map, and the factor that brings what follows to 0..=1; on a logarithmic scale of natural logarithms.
    /// A scale without extent shows the middle of its map.
    pub fn offset_and_factor(&self) -> [f64; 2] {
        let [from, to] = [self.min, self.max].map(|x| if self.log { x.ln() } else { x });
        // Limits may be as far apart as numbers are.
        let span = to - from;
        match span.is_finite() && span > f64::MIN_POSITIVE {
            true => [from, span.recip()],
            false => [from - 0.5, 1.0],
        }
    }

    /// Place of `value` on the map, 0..=1, beyond its ends at them; `None` for NaN.
    pub fn position(&self, value: f64) -> Option<f64> {
        let [from, factor] = self.offset_and_factor();
        let x = if self.log { value.max(f64::MIN_POSITIVE).ln() } else { value };
        (!value.is_nan()).then(|| ((x - from) * factor).clamp(0.0, 1.0))
    }

    /// Round values within the limits for a legend, rising, `most` at most but at least one.
    pub fn ticks(&self, most: usize) -> Vec<f64> {
        let most = most.max(1);
        if self.min == self.max {
            return vec![self.min];
        }
        let decades = self.log.then(|| (self.min.log10().ceil() as i32, self.max.log10().floor() as i32));
        if let Some((first, last)) = decades.filter(|(first, last)| last > first) {
            let step = ((last - first) as usize / most + 1) as i32;
            return (first..=last).step_by(step as usize).map(|decade| 10_f64.powi(decade)).collect();
        }
        let raw = (self.max - self.min) / most as f64;
        let unit = 10_f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .map(|factor| factor * unit)
            .into_iter()
            .find(|step| *step >= raw * (1.0 - 1e-9));
        let step = step.unwrap_or(raw);
        // Counted in steps, so that no rounding adds up; a little beyond, so that limits that are round are among them.
        let (first, last) = ((self.min / step - 1e-6).ceil(), (self.max / step + 1e-6).floor());
        let ticks: Vec<f64> = (0..=(last - first).max(0.0) as usize)
            .take(most + 1)
            .map(|i| (first + i as f64) * step)
            .collect();
        if last < first { vec![self.min] } else { ticks }
    }
}

/// The range of `values` for a scale: all but a thousandth at either end; on a logarithmic scale of the positive ones. Sorts
/// them. `None` where there is no value.
pub fn range_of(values: &mut Vec<f32>, log: bool) -> Option<[f64; 2]> {
    values.retain(|value| value.is_finite() && (!log || *value > 0.0));
    values.sort_unstable_by(f32::total_cmp);
    let stray = (values.len() as f64 * STRAY) as usize;
    let (min, max) = (*values.get(stray)?, *values.get(values.len() - 1 - stray)?);
    let [min, max] = [f64::from(min), f64::from(max)];
    Some([if log { min.max(max * 10_f64.powf(-MOST_DECADES)) } else { min }, max])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scale(min: f64, max: f64, log: bool) -> ColorScale {
        ColorScale::new("v".parse().unwrap(), ColorMap::Viridis, [min, max], log).unwrap()
    }

    #[test]
    fn values_have_their_places() {
        let linear = scale(-2.0, 6.0, false);
        assert_eq!(
            [-2.0, 0.0, 6.0, -9.0, f64::INFINITY].map(|v| linear.position(v).unwrap()),
            [0.0, 0.25, 1.0, 0.0, 1.0]
        );
        assert_eq!(linear.position(f64::NAN), None);
        let log = scale(0.01, 100.0, true);
        for (value, place) in [(0.01, 0.0), (1.0, 0.5), (100.0, 1.0), (0.0, 0.0), (-5.0, 0.0)] {
            assert!((log.position(value).unwrap() - place).abs() < 1e-12, "{value}");
        }
        assert_eq!(scale(3.0, 3.0, false).position(3.0), Some(0.5));
        assert!(scale(-1e308, 1e308, false).position(0.0).is_some_and(f64::is_finite));
    }

    #[test]
    fn limits_that_are_none_are_refused() {
        let new = |range, log| ColorScale::new("v".parse().unwrap(), ColorMap::Viridis, range, log).is_ok();
        assert!(!new([1.0, 0.0], false) && !new([f64::NAN, 0.0], false) && !new([0.0, 1.0], true));
        assert!(!new([0.0, f64::INFINITY], false) && new([1.0, 1.0], true));
    }

    #[test]
    fn ticks_are_round_and_within() {
        assert_eq!(scale(0.0, 10.0, false).ticks(5), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        let ticks = scale(0.013, 0.29, false).ticks(5);
        assert!(ticks.len() >= 2 && (ticks[0] - 0.1).abs() < 1e-12, "{ticks:?}");
        assert_eq!(scale(0.5, 2e4, true).ticks(5), [1.0, 10.0, 100.0, 1000.0, 1e4]);
        assert_eq!(scale(7.0, 7.0, false).ticks(5), [7.0]);
        for (min, max, log) in
            [(-1e300, 1e300, false), (999.9, 1000.1, false), (1.2, 1.9, true), (1e-30, 1e30, true)]
        {
            let scale = scale(min, max, log);
            for most in 1..9 {
                let ticks = scale.ticks(most);
                assert!((1..=most + 1).contains(&ticks.len()), "{min} {max} {most}: {ticks:?}");
                let slack = 1e-6 * (max - min);
                assert!(ticks.iter().all(|t| (min - slack..=max + slack).contains(t)), "{ticks:?}");
            }
        }
    }

    #[test]
    fn stray_values_and_what_is_no_number_do_not_stretch_the_range() {
        let mut values: Vec<f32> = (0..10_000).map(|i| i as f32).collect();
        values.extend([1e30, f32::NAN, f32::NEG_INFINITY, -1e30]);
        assert_eq!(range_of(&mut values, false), Some([9.0, 9990.0]));
        assert_eq!(range_of(&mut vec![-1.0, 0.0, 4.0], true), Some([4.0, 4.0]));
        assert_eq!(range_of(&mut vec![f32::NAN], false), None);
        assert_eq!(range_of(&mut vec![1e-30, 1.0], true), Some([1e-12, 1.0]));
    }
}
