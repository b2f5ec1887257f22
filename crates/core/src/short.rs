use std::fmt;

/// A number as people read it, of any size: five significant digits, without zeros behind them, and a power of ten where there
/// would be many zeros before them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Short(pub f64);

/// Significant digits.
const DIGITS: i32 = 5;

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rounded = format!("{:.*e}", DIGITS as usize - 1, self.0);
        let power: Option<i32> = rounded.split_once('e').and_then(|(_, power)| power.parse().ok());
        // Rounded to these digits, the shortest form has no more of them.
        let value: f64 = rounded.parse().unwrap_or(self.0);
        match power {
            Some(power) if !(-DIGITS..=DIGITS + 2).contains(&power) => write!(f, "{value:e}"),
            _ => write!(f, "{value}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Short;

    #[test]
    fn digits_count_from_the_first_that_is_not_zero() {
        for (value, text) in [
            (0.029_968_574, "0.029969"),
            (0.018_73, "0.01873"),
            (2.345_678e-6, "2.3457e-6"),
            (0.000_123_456, "0.00012346"),
            (12_345.678, "12346"),
            (9.999_999, "10"),
            (1e20, "1e20"),
            (1.0, "1"),
            (0.0, "0"),
            (-0.5, "-0.5"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(Short(value).to_string(), text);
        }
    }
}
