use std::fmt;
use std::str::FromStr;

/// Pictures per second, exactly: `numerator / denominator`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRate {
    /// At least 1.
    pub numerator: u32,
    /// At least 1.
    pub denominator: u32,
}

impl FrameRate {
    /// `pictures` per second.
    pub const fn whole(pictures: u32) -> Self {
        Self { numerator: pictures, denominator: 1 }
    }

    /// Pictures per second.
    pub fn per_second(self) -> f64 {
        f64::from(self.numerator) / f64::from(self.denominator)
    }

    /// Seconds that picture `number` is shown after the first.
    pub fn seconds(self, number: u64) -> f64 {
        number as f64 * f64::from(self.denominator) / f64::from(self.numerator)
    }
}

impl FromStr for FrameRate {
    type Err = String;

    /// `24`, `12.5`, `30000/1001`; 23.976, 29.97 and 59.94 mean the rates of television, 24000/1001 and so on.
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong =
            || "expected pictures per second from 0.01 to 1000, like 24, 29.97 or 30000/1001".to_owned();
        let rate = match text.split_once('/') {
            Some((above, below)) => {
                let number =
                    |text: &str| text.trim().parse::<u32>().ok().filter(|n| *n > 0).ok_or_else(wrong);
                Self { numerator: number(above)?, denominator: number(below)? }
            }
            None => {
                let value: f64 = text.trim().parse().map_err(|_| wrong())?;
                let rounded = (value * 1000.0).round();
                if !(10.0..=1e6).contains(&rounded) {
                    return Err(wrong());
                }
                // Two or three decimals of a rate that is a thousand and first part below a whole one.
                let whole = value.ceil();
                let is_television = value.fract() != 0.0 && (whole * 1000.0 / 1001.0 - value).abs() < 5e-3;
                match (is_television, value.fract() == 0.0) {
                    (true, _) => Self { numerator: whole as u32 * 1000, denominator: 1001 },
                    (_, true) => Self::whole(value as u32),
                    _ => Self { numerator: rounded as u32, denominator: 1000 },
                }
            }
        };
        let fits = (0.01..=1000.0).contains(&rate.per_second()) && rate.numerator <= 1_000_000;
        if fits { Ok(rate) } else { Err(wrong()) }
    }
}

impl fmt::Display for FrameRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.denominator {
            1 => write!(f, "{}", self.numerator),
            denominator => write!(f, "{}/{denominator}", self.numerator),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_exact_and_those_of_television_are_meant() {
        let rate = |text: &str| text.parse::<FrameRate>().map(|rate| (rate.numerator, rate.denominator));
        assert_eq!(rate("24"), Ok((24, 1)));
        assert_eq!(rate("12.5"), Ok((12500, 1000)));
        assert_eq!(rate("23.976"), Ok((24000, 1001)));
        assert_eq!(rate("29.97"), Ok((30000, 1001)));
        assert_eq!(rate("59.94"), Ok((60000, 1001)));
        assert_eq!(rate("30000/1001"), Ok((30000, 1001)));
        for bad in ["0", "-1", "nan", "inf", "1e9", "24/0", "x", "", "5000000/5000"] {
            assert!(rate(bad).is_err(), "{bad}");
        }
        // 1e-12: rounding of f64.
        assert!((FrameRate { numerator: 24000, denominator: 1001 }.seconds(24) - 1.001).abs() < 1e-12);
    }
}
