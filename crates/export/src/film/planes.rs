//! Brightness and colour differences as films have them: ITU-T BT.709, video range, one colour for two by two pixels.

use rayon::prelude::*;

/// Fixed point: one is this.
const ONE: f64 = 65536.0;
/// Shares of red, green and blue in the brightness (BT.709, 3.2).
const RED: f64 = 0.2126;
const BLUE: f64 = 0.0722;
const GREEN: f64 = 1.0 - RED - BLUE;
/// Steps from black to white, and from one end of the colour differences to the other (BT.709, 4.6).
const BRIGHTNESS_STEPS: f64 = 219.0;
const COLOUR_STEPS: f64 = 224.0;

/// Weights of red, green and blue.
type Weights = [i32; 3];
const BRIGHTNESS: Weights = weights([RED, GREEN, BLUE], BRIGHTNESS_STEPS);
/// `(B - Y) / (2 (1 - BLUE))`
const BLUENESS: Weights = weights([-RED, -GREEN, 1.0 - BLUE], COLOUR_STEPS / (2.0 * (1.0 - BLUE)));
/// `(R - Y) / (2 (1 - RED))`
const REDNESS: Weights = weights([1.0 - RED, -GREEN, -BLUE], COLOUR_STEPS / (2.0 * (1.0 - RED)));

const fn weights([red, green, blue]: [f64; 3], steps: f64) -> Weights {
    let scale = ONE * steps / 255.0;
    [(red * scale).round() as i32, (green * scale).round() as i32, (blue * scale).round() as i32]
}

/// The planes of a picture with even sides, row by row without gaps.
pub(super) struct Planes {
    pub size: [usize; 2],
    pub brightness: Vec<u8>,
    /// Half as wide and half as high.
    pub blueness: Vec<u8>,
    /// As [`Self::blueness`].
    pub redness: Vec<u8>,
}

impl Planes {
    /// Room for pictures of `size` pixels.
    pub fn new(size: [u32; 2]) -> Self {
        let size = size.map(|side| side as usize);
        let pixels = size[0] * size[1];
        Self {
            size,
            brightness: vec![0; pixels],
            blueness: vec![0; pixels / 4],
            redness: vec![0; pixels / 4],
        }
    }

    /// Takes over a display image, red in the lowest byte, of the same size.
    pub fn convert(&mut self, pixels: &[u32]) {
        let width = self.size[0];
        self.brightness
            .par_chunks_mut(2 * width)
            .zip(self.blueness.par_chunks_mut(width / 2))
            .zip(self.redness.par_chunks_mut(width / 2))
            .zip(pixels.par_chunks(2 * width))
            .for_each(|(((brightness, blueness), redness), rows)| {
                for (value, pixel) in brightness.iter_mut().zip(rows) {
                    *value = step(channels(*pixel), 1, BRIGHTNESS, 16);
                }
                let (upper, lower) = rows.split_at(width);
                for (x, (blue, red)) in blueness.iter_mut().zip(redness).enumerate() {
                    let four = [upper[2 * x], upper[2 * x + 1], lower[2 * x], lower[2 * x + 1]];
                    let sum = four
                        .into_iter()
                        .map(channels)
                        .fold([0; 3], |sum, pixel| [sum[0] + pixel[0], sum[1] + pixel[1], sum[2] + pixel[2]]);
                    *blue = step(sum, 4, BLUENESS, 128);
                    *red = step(sum, 4, REDNESS, 128);
                }
            });
    }
}

fn channels(pixel: u32) -> [i32; 3] {
    [pixel & 0xff, pixel >> 8 & 0xff, pixel >> 16 & 0xff].map(|channel| channel as i32)
}

/// The nearest step of a value whose zero is `zero`; `sum` is of `count` pixels.
fn step(sum: [i32; 3], count: i32, [red, green, blue]: Weights, zero: i32) -> u8 {
    let value = sum[0] * red + sum[1] * green + sum[2] * blue;
    let one = count * ONE as i32;
    (zero + (value + one / 2).div_euclid(one)) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the formulas of BT.709 in floating point.
    fn expected([r, g, b]: [f64; 3]) -> [f64; 3] {
        let y = (RED * r + GREEN * g + BLUE * b) / 255.0;
        let blue = (b / 255.0 - y) / (2.0 * (1.0 - BLUE));
        let red = (r / 255.0 - y) / (2.0 * (1.0 - RED));
        [16.0 + 219.0 * y, 128.0 + 224.0 * blue, 128.0 + 224.0 * red]
    }

    #[test]
    fn colours_are_those_of_the_formulas() {
        let mut planes = Planes::new([2, 2]);
        for color in 0..4096_u32 {
            let [r, g, b] = [color & 15, color >> 4 & 15, color >> 8 & 15].map(|c| c * 17);
            planes.convert(&[0xff00_0000 | b << 16 | g << 8 | r; 4]);
            let steps = [planes.brightness[3], planes.blueness[0], planes.redness[0]];
            for (step, expected) in steps.into_iter().zip(expected([r, g, b].map(f64::from))) {
                // Half a step of rounding, and what fixed point adds.
                assert!((f64::from(step) - expected).abs() < 0.502, "{r} {g} {b}");
            }
        }
    }

    #[test]
    fn four_pixels_share_their_mean_colour_and_none_their_brightness() {
        let mut planes = Planes::new([4, 2]);
        let (red, black) = (0xff00_00ff, 0xff00_0000);
        planes.convert(&[red, black, black, black, black, red, black, black]);
        let half = expected([127.5, 0.0, 0.0]);
        assert!((f64::from(planes.redness[0]) - half[2]).abs() < 0.502);
        assert_eq!((planes.redness[1], planes.blueness[1]), (128, 128));
        assert_eq!(planes.brightness, [63, 16, 16, 16, 16, 63, 16, 16]);
    }
}
