use crate::number::written;

/// A length, as long in the picture as it is.
#[derive(Clone, Debug, PartialEq)]
pub struct ScaleBar {
    /// Length in pixels.
    pub length_px: f32,
    /// What it says.
    pub label: String,
}

impl ScaleBar {
    /// A round length of at most `most_px` pixels where a unit of the file is `px_per_unit` pixels long. `metres_per_unit`: what a
    /// unit is, where that is known. `place`: for which part of the picture it holds, empty for all of it. `None` where there is no
    /// such length.
    pub fn fit(px_per_unit: f64, most_px: f64, metres_per_unit: Option<f64>, place: &str) -> Option<Self> {
        let px_per_unit = px_per_unit / metres_per_unit.unwrap_or(1.0);
        let most = most_px / px_per_unit;
        if !(most.is_normal() && most > 0.0) {
            return None;
        }
        let decade = 10_f64.powf(most.log10().floor());
        let length =
            [5.0, 2.0, 1.0].map(|factor| factor * decade).into_iter().find(|length| *length <= most)?;
        let (shown, unit) = match metres_per_unit {
            None => (length, ""),
            Some(_) if length >= 1000.0 => (length / 1000.0, " km"),
            Some(_) if length >= 1.0 => (length, " m"),
            Some(_) if length >= 0.01 => (length * 100.0, " cm"),
            Some(_) => (length * 1000.0, " mm"),
        };
        let place = if place.is_empty() { String::new() } else { format!(" {place}") };
        Some(Self {
            length_px: (length * px_per_unit) as f32,
            label: format!("{}{unit}{place}", written(shown, shown)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_round_and_true() {
        let fit =
            |px, most, metres| ScaleBar::fit(px, most, metres, "").map(|bar| (bar.length_px, bar.label));
        assert_eq!(fit(100.0, 300.0, None), Some((200.0, "2".into())));
        assert_eq!(fit(100.0, 60.0, None), Some((50.0, "0.5".into())));
        // A unit of the file is a millimetre: 100 px of it are 10 cm in 10 000 px.
        assert_eq!(fit(100.0, 300.0, Some(0.001)), Some((200.0, "2 mm".into())));
        assert_eq!(fit(0.01, 300.0, Some(1.0)), Some((200.0, "20 km".into())));
        assert_eq!(fit(1000.0, 300.0, Some(1.0)), Some((200.0, "20 cm".into())));
        let at = ScaleBar::fit(100.0, 100.0, Some(1.0), "at the centre").unwrap();
        assert_eq!(at.label, "1 m at the centre");
        for absurd in [0.0, f64::NAN, f64::INFINITY, -3.0] {
            assert_eq!(fit(absurd, 300.0, None), None);
        }
    }
}
