//! The transfer between light and what displays take (IEC 61966-2-1).

/// The display value of a linear one, both in [0, 1].
pub fn encode(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The inverse of [`encode`].
pub fn decode(display: f32) -> f32 {
    if display <= 0.040_45 { display / 12.92 } else { ((display + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_meets_its_published_points_and_has_an_inverse() {
        assert_eq!(encode(0.0), 0.0);
        // 1e-4: printed digits of the standard's tables.
        assert!((encode(0.18) - 0.4614).abs() < 1e-4);
        assert!((encode(1.0) - 1.0).abs() < 1e-6);
        for step in 0..=255 {
            let value = step as f32 / 255.0;
            assert!((encode(decode(value)) - value).abs() < 1e-5);
        }
    }
}
