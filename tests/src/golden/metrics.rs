//! Per-pixel measures of how two pictures differ.

use crate::Pixels;

/// Red, green and blue of a picture, as the FLIP library takes them.
fn flip_image(picture: &Pixels) -> nv_flip::FlipImageRgb8 {
    let rgb: Vec<u8> = picture.rgba.iter().flat_map(|p| p[..3].to_vec()).collect();
    nv_flip::FlipImageRgb8::with_data(picture.size[0], picture.size[1], &rgb)
}

/// FLIP error (Andersson et al. 2020), 0 (nobody sees a difference) to 1, per pixel, for a screen at the usual distance (67
/// pixels per degree). Both pictures have the same size.
pub fn flip_map(expected: &Pixels, ours: &Pixels) -> Vec<f32> {
    let ppd = nv_flip::DEFAULT_PIXELS_PER_DEGREE;
    nv_flip::flip(flip_image(expected), flip_image(ours), ppd).to_vec()
}

/// A FLIP map in the colours of its authors: black is no difference, yellow to white the largest.
pub fn heat_map(flip: &[f32], size: [u32; 2]) -> Pixels {
    let map = nv_flip::FlipImageFloat::with_data(size[0], size[1], flip);
    let rgb = map.apply_color_lut(&nv_flip::magma_lut()).to_vec();
    Pixels { size, rgba: rgb.chunks_exact(3).map(|c| [c[0], c[1], c[2], 255]).collect() }
}

/// Side of the square window, pixels: seven is what scikit-image takes for uniform windows.
const WINDOW: usize = 7;

/// Structural similarity of the luma (Wang et al. 2004, equation 13), -1 to 1 (equal), per pixel over a uniform window
/// around it. Our own: the `image-compare` crate divides neither variances nor covariance by the window's area, which takes
/// the stabilising constants of the formula out of proportion.
pub fn ssim_map(expected: &Pixels, ours: &Pixels) -> Vec<f32> {
    let [width, height] = expected.size.map(|side| side as usize);
    // Rec. 601, on display values, as the authors do.
    let luma = |p: &[u8; 4]| 0.299 * f64::from(p[0]) + 0.587 * f64::from(p[1]) + 0.114 * f64::from(p[2]);
    let [x, y] = [expected, ours].map(|picture| picture.rgba.iter().map(luma).collect::<Vec<f64>>());
    let (c1, c2) = ((0.01f64 * 255.0).powi(2), (0.03f64 * 255.0).powi(2));
    let reach = WINDOW / 2;
    let at = |column: usize, row: usize| {
        let (mut n, mut sums) = (0.0, [0.0; 5]);
        for r in row.saturating_sub(reach)..(row + reach + 1).min(height) {
            for c in column.saturating_sub(reach)..(column + reach + 1).min(width) {
                let (a, b) = (x[r * width + c], y[r * width + c]);
                n += 1.0;
                for (sum, value) in sums.iter_mut().zip([a, b, a * a, b * b, a * b]) {
                    *sum += value;
                }
            }
        }
        let [mx, my, xx, yy, xy] = sums.map(|sum| sum / n);
        let (vx, vy, cov) = (xx - mx * mx, yy - my * my, xy - mx * my);
        let ssim = (2.0 * mx * my + c1) * (2.0 * cov + c2) / ((mx * mx + my * my + c1) * (vx + vy + c2));
        ssim as f32
    };
    (0..height).flat_map(|row| (0..width).map(move |column| (column, row))).map(|(c, r)| at(c, r)).collect()
}

/// The value below which the part `fraction` (0 to 1) of the values lies; 0 of none.
pub fn percentile(mut values: Vec<f32>, fraction: f64) -> f64 {
    values.sort_by(f32::total_cmp);
    let index = (fraction * values.len().saturating_sub(1) as f64).round() as usize;
    values.get(index).copied().map_or(0.0, f64::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(value: u8) -> Pixels {
        Pixels { size: [16, 16], rgba: vec![[value, value, value, 255]; 256] }
    }

    #[test]
    fn equal_pictures_do_not_differ() {
        let picture = Pixels {
            size: [16, 16],
            rgba: (0..=255).map(|i: u8| [i, i.wrapping_mul(7), 255 - i, 255]).collect(),
        };
        assert!(flip_map(&picture, &picture).iter().all(|v| *v == 0.0));
        assert!(ssim_map(&picture, &picture).iter().all(|v| (v - 1.0).abs() < 1e-6));
    }

    #[test]
    fn ssim_of_plain_pictures_is_the_luminance_term() {
        // Without variance the formula is (2 a b + c1) / (a a + b b + c1), for 100 and 120 by hand:
        let by_hand = (2.0 * 100.0 * 120.0 + 6.5025) / (100.0f32 * 100.0 + 120.0 * 120.0 + 6.5025);
        assert!(ssim_map(&plain(100), &plain(120)).iter().all(|v| (v - by_hand).abs() < 1e-5));
    }

    #[test]
    fn flip_of_black_and_white_is_its_largest() {
        // The authors scale the colour difference so that the most distant colours are 1 apart; black and white are almost.
        let map = flip_map(&plain(0), &plain(255));
        assert!(map.iter().all(|v| *v > 0.9 && *v <= 1.0), "{:?}", &map[..4]);
    }

    #[test]
    fn percentiles() {
        let values: Vec<f32> = (0..101).rev().map(|v| v as f32).collect();
        assert_eq!(percentile(values.clone(), 0.99), 99.0);
        assert_eq!(percentile(values, 0.5), 50.0);
        assert_eq!(percentile(Vec::new(), 0.5), 0.0);
    }
}
