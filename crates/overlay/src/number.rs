//! Numbers as people write them.

/// Most digits after the point.
const MOST_DECIMALS: i32 = 9;

/// Digits after the point that tell numbers apart which differ by `step`.
pub fn decimals_of_step(step: f64) -> usize {
    if !(step.is_finite() && step > 0.0) {
        return 0;
    }
    // A step of 0.25 needs a digit more than its size says.
    let first = -(step.log10() + 1e-9).floor() as i32;
    let is_round = |decimals: i32| {
        let scaled = step * 10_f64.powi(decimals);
        (scaled - scaled.round()).abs() < 1e-6 * scaled
    };
    let enough = (first..first + 3).find(|&decimals| is_round(decimals)).unwrap_or(first + 1);
    enough.clamp(0, MOST_DECIMALS) as usize
}

/// `value`, told apart from others that differ from it by `step`.
pub fn written(value: f64, step: f64) -> String {
    let size = value.abs().max(step.abs());
    // `-0` is no number to show.
    let value = if value == 0.0 { 0.0 } else { value };
    if size != 0.0 && !(1e-3..1e6).contains(&size) {
        let short = format!("{value:.3e}");
        let (mantissa, exponent) = short.split_once('e').unwrap_or((&short, "0"));
        return format!("{}e{exponent}", mantissa.trim_end_matches('0').trim_end_matches('.'));
    }
    format!("{value:.0$}", decimals_of_step(step))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_digits_as_steps_need() {
        for (step, decimals) in [
            (1.0, 0),
            (5.0, 0),
            (0.5, 1),
            (0.25, 2),
            (0.004, 3),
            (0.0167, 4),
            (1.0 / 24.0, 3),
            (0.0, 0),
            (1e-30, 9),
        ] {
            assert_eq!(decimals_of_step(step), decimals, "{step}");
        }
        assert_eq!(decimals_of_step(f64::NAN), 0);
        for (value, step, text) in [
            (0.2, 0.1, "0.2"),
            (1200.0, 200.0, "1200"),
            (-0.0, 0.5, "0.0"),
            (1e5, 1e5, "100000"),
            (2.5e7, 5e6, "2.5e7"),
            (1e-5, 1e-5, "1e-5"),
        ] {
            assert_eq!(written(value, step), text);
        }
    }
}
