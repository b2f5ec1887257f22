//! How much a film with less detail flickers beyond what really moves.

use super::metrics::percentile;
use crate::{Mask, Pixels};

/// Change from picture to picture that the film with all detail does not have, in steps of 8 bits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flicker {
    /// Mean over the pixels and steps.
    pub mean: f64,
    /// 99th percentile.
    pub p99: f64,
}

/// Compares two films of the same moments: the difference of the changes of luma from one picture to the next, where `water`
/// (one mask per picture of the full film) has water before or after. 0 for films of less than two pictures.
pub fn flicker(full: &[Pixels], reduced: &[Pixels], water: &[Mask]) -> Flicker {
    let luma = |p: &[u8; 4]| 0.299 * f32::from(p[0]) + 0.587 * f32::from(p[1]) + 0.114 * f32::from(p[2]);
    let change = |film: &[Pixels], step: usize| -> Vec<f32> {
        let pairs = film[step].rgba.iter().zip(&film[step + 1].rgba);
        pairs.map(|(before, after)| luma(after) - luma(before)).collect()
    };
    let mut all = Vec::new();
    for step in 0..full.len().saturating_sub(1) {
        let (expected, ours) = (change(full, step), change(reduced, step));
        let apart: Vec<f32> = expected.iter().zip(&ours).map(|(a, b)| (a - b).abs()).collect();
        all.extend(water[step].union(&water[step + 1]).pick(&apart));
    }
    let mean = all.iter().map(|&v| f64::from(v)).sum::<f64>() / all.len().max(1) as f64;
    Flicker { mean, p99: percentile(all, 0.99) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(grey: u8) -> Pixels {
        Pixels { size: [10, 10], rgba: vec![[grey, grey, grey, 255]; 100] }
    }

    fn everywhere() -> Mask {
        Mask::new([10, 10], vec![true; 100])
    }

    #[test]
    fn what_moves_in_both_films_is_no_flicker() {
        let full: Vec<Pixels> = [10, 60, 30].map(plain).into();
        // Another brightness all the time is an error, but it does not flicker.
        let darker: Vec<Pixels> = [5, 55, 25].map(plain).into();
        let masks = [everywhere(), everywhere(), everywhere()];
        let found = flicker(&full, &darker, &masks);
        // f32 rounding of lumas up to 60.
        assert!(found.mean < 1e-4 && found.p99 < 1e-4, "{found:?}");
    }

    #[test]
    fn a_pixel_that_blinks_is_counted_where_there_is_water() {
        let full = vec![plain(50); 3];
        let mut blinking = full.clone();
        blinking[1].rgba[7] = [150, 150, 150, 255];
        let masks = vec![everywhere(); 3];
        let found = flicker(&full, &blinking, &masks);
        // Once up, once down by 100: two of two hundred changes.
        assert!((found.mean - 1.0).abs() < 1e-4, "{found:?}");
        let dry = vec![Mask::new([10, 10], vec![false; 100]); 3];
        assert_eq!(flicker(&full, &blinking, &dry), Flicker { mean: 0.0, p99: 0.0 });
    }
}
