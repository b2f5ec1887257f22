use crate::CompositorParameters;

/// What the log-mean of the luminance is brought to in a picture that is neither bright nor dark by nature (Reinhard et al. 2002,
/// Photographic Tone Reproduction, equation 2).
const KEY: f64 = 0.18;
/// Stops by which it is more in a picture of snow, and less in one of the night (Reinhard 2003, Parameter Estimation for
/// Photographic Tone Reproduction).
const KEY_STOPS: f64 = 2.0;
/// Stops between dark and bright from which on they say all of the picture's nature: in a flat one, where the mean lies is chance.
const LEAST_RANGE: f64 = 4.0;
/// Shares of the darkest and of the brightest pixels that do not count: black borders, and glints and the sun.
const LEFT_OUT: f64 = 0.1;
/// Digits that are kept, so that the number that is printed is the one that is used.
const STEPS_PER_STOP: f64 = 100.0;

/// Mantissa bits that tell bins apart: 32 per stop.
const FINE_BITS: u32 = 5;
const FINE: usize = 1 << FINE_BITS;
const OCTAVES: usize = 255;

/// A histogram of log-luminance over any number of pictures.
///
/// Bins are cut by the bits of floating-point numbers, so that light that is 2^k times as bright moves them by k octaves without
/// rounding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Meter {
    bins: Vec<u64>,
}

impl Default for Meter {
    fn default() -> Self {
        Self { bins: vec![0; OCTAVES * FINE] }
    }
}

impl Meter {
    /// Counts the pixels of a picture: linear radiance, Rec. 709, with coverage, before exposure. What is no number, is black or, in a
    /// transparent picture, covers less than half of its pixel does not count.
    pub fn add(&mut self, parameters: &CompositorParameters, radiance: &[[f32; 4]]) {
        let [r, g, b] = parameters.white_balance;
        let (r, g, b) = (0.2126 * r, 0.7152 * g, 0.0722 * b);
        for pixel in radiance {
            let luminance = r * pixel[0] + g * pixel[1] + b * pixel[2];
            let is_seen = !parameters.transparent || pixel[3] >= 0.5;
            if is_seen && luminance.is_normal() && luminance > 0.0 {
                self.bins[(luminance.to_bits() >> (f32::MANTISSA_DIGITS - 1 - FINE_BITS)) as usize] += 1;
            }
        }
    }

    /// The exposure in stops, to a hundredth, within the range of [`CompositorParameters::exposure`]; `None` where no pixel counts.
    pub fn exposure(&self) -> Option<f32> {
        let count: u64 = self.bins.iter().sum();
        if count == 0 {
            return None;
        }
        let (lowest, highest) = (LEFT_OUT * count as f64, (1.0 - LEFT_OUT) * count as f64);
        let (mut below, mut sum) = (0.0, 0.0);
        let (mut darkest, mut brightest) = (f64::MAX, f64::MIN);
        for (bin, &pixels) in self.bins.iter().enumerate() {
            let above = below + pixels as f64;
            let share = (above.min(highest) - f64::max(below, lowest)).max(0.0);
            if share > 0.0 {
                sum += share * log2_of_bin(bin);
                darkest = darkest.min(log2_of_bin(bin));
                brightest = brightest.max(log2_of_bin(bin));
            }
            below = above;
        }
        let mean = sum / (highest - lowest);
        // -1 to 1: where the mean lies between dark and bright.
        let nature = (2.0 * mean - darkest - brightest) / (brightest - darkest).max(LEAST_RANGE);
        let stops = KEY.log2() + KEY_STOPS * nature - mean;
        let [least, most] = CompositorParameters::EXPOSURE_RANGE;
        let stops = (stops * STEPS_PER_STOP).round() / STEPS_PER_STOP;
        // 0 has no sign when it is printed.
        Some(stops.clamp(least.into(), most.into()) as f32 + 0.0)
    }
}

/// Logarithm of the luminance in the middle of a bin.
fn log2_of_bin(bin: usize) -> f64 {
    let bias = i32::from(i8::MAX);
    let octave = (bin / FINE) as i32 - bias;
    f64::from(octave) + (1.0 + ((bin % FINE) as f64 + 0.5) / FINE as f64).log2()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn metered(radiance: &[[f32; 4]]) -> Option<f32> {
        let mut meter = Meter::default();
        meter.add(&CompositorParameters::default(), radiance);
        meter.exposure()
    }

    /// A gradient over nine stops.
    fn gradient() -> Vec<[f32; 4]> {
        (0..9000)
            .map(|i| [1.3, 0.8, 2.1].map(|c: f32| c * (f32::from(i as i16) / 1000.0).exp2() / 30.0))
            .map(|[r, g, b]| [r, g, b, 1.0])
            .collect()
    }

    #[test]
    fn grey_becomes_middle_grey() {
        // A bin is 1/32 wide, so that its middle is off by at most 1/64, which is 0.023 stops; 0.005 of rounding to hundredths.
        for level in [0.18, 0.02, 1.0, 7.3, 900.0] {
            let exposure = metered(&[[level, level, level, 1.0]; 100]).unwrap();
            assert!((level * exposure.exp2() / 0.18).log2().abs() < 0.028, "{level}: {exposure}");
        }
    }

    #[test]
    fn bright_pictures_stay_bright_and_dark_ones_dark() {
        let picture = |most: f32, rest: f32| -> Vec<[f32; 4]> {
            (0..100).map(|i| if i < 80 { most } else { rest }).map(|c| [c, c, c, 1.0]).collect()
        };
        // Of the middle 80 pixels, 70 have the light of most. Bright: the mean is 4 * 10 / 80 = 0.5 stops below most, so that
        // the key is 2 * (4 - 1) / 4 = 1.5 stops above middle grey; dark: as much above, 1.5 below.
        for (most, rest, sign) in [(1.0, 1.0 / 16.0, 1.0), (1.0 / 16.0, 1.0, -1.0)] {
            let expected = f64::from(0.18 / most).log2() + sign * (1.5 + 0.5);
            let found = f64::from(metered(&picture(most, rest)).unwrap());
            // 0.023 for the mean and as much for each of dark and bright, which differ by the same where bins are the same.
            assert!((found - expected).abs() < 0.05, "{found} for {expected}");
        }
    }

    #[test]
    fn light_of_twice_the_brightness_is_one_stop_less_exactly() {
        let gradient = gradient();
        let hundredths = |radiance: &[[f32; 4]]| (100.0 * metered(radiance).unwrap()).round() as i32;
        for stops in [-9, -1, 1, 4, 13] {
            let scaled: Vec<_> = gradient.iter().map(|p| p.map(|c| c * (stops as f32).exp2())).collect();
            assert_eq!(hundredths(&scaled), hundredths(&gradient) - 100 * stops);
        }
    }

    #[test]
    fn a_few_extreme_pixels_change_nothing() {
        let plain = gradient();
        let mut odd = plain.clone();
        odd.extend([[6e4, 6e4, 6e4, 1.0]; 20]);
        odd.extend([[1e-20, 0.0, 0.0, 1.0]; 20]);
        odd.extend([
            [f32::NAN, 1.0, 1.0, 1.0],
            [f32::INFINITY, 0.0, 0.0, 1.0],
            [0.0, 0.0, 0.0, 1.0],
            [-1.0, 0.0, 0.0, 1.0],
        ]);
        assert_eq!(metered(&odd), metered(&plain));
        let mut glints = vec![[0.5, 0.5, 0.5, 1.0]; 1000];
        let calm = metered(&glints);
        glints.extend([[6e4, 6e4, 6e4, 1.0]; 50]);
        assert_eq!(metered(&glints), calm);
        // All else alike, they would: a quarter of the picture is no exception.
        odd.extend(vec![[6e4, 6e4, 6e4, 1.0]; 3000]);
        assert!(metered(&odd) < metered(&plain));
    }

    #[test]
    fn what_has_no_brightness_is_not_metered() {
        assert_eq!(metered(&[]), None);
        assert_eq!(metered(&[[0.0, 0.0, 0.0, 1.0]; 9]), None);
        assert_eq!(
            metered(&[[f32::NAN, 0.0, 0.0, 1.0], [-3.0, 0.0, 0.0, 1.0], [1e-42, 0.0, 0.0, 1.0]]),
            None
        );
    }

    #[test]
    fn the_range_of_the_parameter_is_kept() {
        assert_eq!(metered(&[[1e30; 4]; 4]), Some(-20.0));
        assert_eq!(metered(&[[1e-30; 4]; 4]), Some(20.0));
    }

    #[test]
    fn what_is_seen_counts_as_it_is_seen() {
        let mut meter = Meter::default();
        let parameters =
            CompositorParameters { transparent: true, white_balance: [2.0; 3], ..Default::default() };
        meter.add(&parameters, &[[0.09, 0.09, 0.09, 1.0], [50.0, 50.0, 50.0, 0.1], [50.0, 50.0, 50.0, 0.0]]);
        // 0.028: as above.
        assert!(meter.exposure().unwrap().abs() < 0.028, "{:?}", meter.exposure());
    }

    #[test]
    fn pictures_add_up() {
        let (mut one, mut both) = (Meter::default(), Meter::default());
        let gradient = gradient();
        one.add(&CompositorParameters::default(), &gradient);
        let (front, back) = gradient.split_at(1234);
        both.add(&CompositorParameters::default(), back);
        both.add(&CompositorParameters::default(), front);
        assert_eq!(one, both);
    }
}
