//! CPU twin of `shaders/compositor/bloom_down.wgsl` and `bloom_up.wgsl`, and the bloom of pictures of 16 bits.

use glam::Vec3;
use rayon::prelude::*;

use super::{LUMINANCE, MAX_RADIANCE, finite};
use crate::CompositorParameters;
use crate::bloom::{SPREAD, level_sizes};

/// A level of the pyramid.
struct Level {
    size: [u32; 2],
    texels: Vec<Vec3>,
}

impl Level {
    fn make(size: [u32; 2], texel: impl Fn(i32, i32) -> Vec3 + Sync) -> Self {
        let width = size[0] as i32;
        let texels =
            (0..width * size[1] as i32).into_par_iter().map(|i| texel(i % width, i / width)).collect();
        Self { size, texels }
    }

    /// Beyond the border the picture goes on as it ends.
    fn at(&self, x: i32, y: i32) -> Vec3 {
        let [width, height] = self.size.map(|side| side as i32);
        self.texels[(y.clamp(0, height - 1) * width + x.clamp(0, width - 1)) as usize]
    }

    /// Half as wide and high: 13 taps, each the mean of four (Jimenez 2014); `first`: bright ones count less (Karis 2013).
    fn halved(&self, size: [u32; 2], first: bool) -> Self {
        let weight = |light: Vec3| if first { 1.0 / (1.0 + light.dot(LUMINANCE)) } else { 1.0 };
        Self::make(size, |x, y| {
            let tap = |dx: i32, dy: i32| {
                let (x, y) = (2 * x + dx, 2 * y + dy);
                0.25 * (self.at(x, y) + self.at(x + 1, y) + self.at(x, y + 1) + self.at(x + 1, y + 1))
            };
            let mean = |dx: i32, dy: i32| {
                let taps = [tap(dx, dy), tap(dx + 2, dy), tap(dx, dy + 2), tap(dx + 2, dy + 2)];
                let weighted: Vec3 = taps.iter().map(|&light| weight(light) * light).sum();
                weighted / taps.iter().map(|&light| weight(light)).sum::<f32>()
            };
            0.5 * mean(-1, -1) + 0.125 * (mean(-2, -2) + mean(0, -2) + mean(-2, 0) + mean(0, 0))
        })
    }

    /// At a point of a picture twice as wide and high, by a tent of three texels on bilinear samples.
    fn enlarged(&self, x: i32, y: i32) -> Vec3 {
        let weights = [(2, 1.0), (1, 5.0), (0, 7.0), (-1, 3.0)];
        let side = |at: i32| 2 * (at & 1) - 1;
        let mut sum = Vec3::ZERO;
        for (dy, wy) in weights {
            for (dx, wx) in weights {
                sum += wx * wy * self.at(x / 2 + side(x) * dx, y / 2 + side(y) * dy);
            }
        }
        sum / 256.0
    }

    /// The same, bilinear.
    fn between(&self, x: i32, y: i32) -> Vec3 {
        let [last_x, last_y] = self.size.map(|side| side as i32 - 1);
        let (near_x, near_y) = ((x / 2).min(last_x), (y / 2).min(last_y));
        let (far_x, far_y) = (near_x + 2 * (x & 1) - 1, near_y + 2 * (y & 1) - 1);
        let row = |y: i32| 3.0 * self.at(near_x, y) + self.at(far_x, y);
        (3.0 * row(near_y) + row(far_y)) / 16.0
    }
}

/// Radiance of a picture of `size` pixels after bloom: a share of the light is mixed with what the lens scatters of it. What is no number
/// counts as nothing, and coverage stays.
///
/// # Panics
/// If there are not as many pixels as `size` says.
pub fn bloomed(parameters: &CompositorParameters, radiance: &[[f32; 4]], size: [u32; 2]) -> Vec<[f32; 4]> {
    assert_eq!(radiance.len() as u64, u64::from(size[0]) * u64::from(size[1]), "pixels of {size:?}");
    let exposure = parameters.stops().exp2();
    let exposed = |x: i32, y: i32| {
        let [r, g, b, _] = radiance[y as usize * size[0] as usize + x as usize];
        (exposure * finite([r, g, b])).min(Vec3::splat(MAX_RADIANCE))
    };
    let mut levels = vec![Level::make(size, exposed)];
    for (i, size) in level_sizes(size).into_iter().enumerate() {
        levels.push(levels[i].halved(size, i == 0));
    }
    // The picture itself is no level of the pyramid.
    let scattered = levels.drain(1..).rev().reduce(|coarse, fine| {
        Level::make(fine.size, |x, y| fine.at(x, y).lerp(coarse.enlarged(x, y), SPREAD))
    });
    let Some(scattered) = scattered else { return radiance.to_vec() };
    let width = size[0] as usize;
    let mix = |(i, &[r, g, b, coverage]): (usize, &[f32; 4])| {
        let light = scattered.between((i % width) as i32, (i / width) as i32) / exposure;
        finite([r, g, b]).lerp(light, parameters.bloom).extend(coverage).to_array()
    };
    radiance.par_iter().enumerate().map(mix).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(bloom: f32) -> CompositorParameters {
        CompositorParameters { bloom, ..Default::default() }
    }

    #[test]
    fn a_picture_of_one_colour_stays_it() {
        for size in [[1, 1], [2, 3], [64, 36], [129, 5]] {
            let pixels = vec![[0.3, 7.0, 0.01, 0.5]; (size[0] * size[1]) as usize];
            for found in bloomed(&all(1.0), &pixels, size) {
                for (found, expected) in found.iter().zip(pixels[0]) {
                    // A few roundings of 2^-24 per level.
                    assert!((found / expected - 1.0).abs() < 1e-5, "{found} for {expected} in {size:?}");
                }
            }
        }
    }

    #[test]
    fn light_is_scattered_and_none_is_lost() {
        let size = [256, 256];
        let mut pixels = vec![[0.0, 0.0, 0.0, 1.0]; 256 * 256];
        // Too dim for the weights of bright pixels to matter: 1 / (1 + 1e-4).
        pixels[128 * 256 + 127] = [1e-4, 2e-4, 0.0, 1.0];
        let share = 0.25;
        let found = bloomed(&all(share), &pixels, size);
        let sum: Vec3 = found.iter().map(|&[r, g, b, _]| Vec3::new(r, g, b)).sum();
        // 2e-3: halos of the coarsest levels reach the border, which the picture goes on beyond.
        assert!((sum / Vec3::new(1e-4, 2e-4, 1.0) - Vec3::new(1.0, 1.0, 0.0)).length() < 2e-3, "{sum}");
        let [center, beside, far] =
            [128 * 256 + 127, 128 * 256 + 137, 128 * 256 + 200].map(|i: usize| found[i][0]);
        assert!(center > 0.75e-4 && center > beside && beside > far && far > 0.0, "{center} {beside} {far}");
    }

    #[test]
    fn single_bright_pixels_count_less_and_nothing_is_nan() {
        let size = [64, 64];
        let mut pixels = vec![[0.1, 0.1, 0.1, 1.0]; 64 * 64];
        pixels[32 * 64 + 32] = [f32::INFINITY, 5e4, 5e4, 1.0];
        pixels[5] = [f32::NAN, f32::NEG_INFINITY, -3.0, 0.0];
        let found = bloomed(&all(1.0), &pixels, size);
        assert!(found.iter().flatten().all(|c| c.is_finite() && *c >= 0.0));
        // In the mean it would be 5e4 / 16, weighted it is a few times what is around it.
        assert!(found[32 * 64 + 32][1] < 1.0, "{:?}", found[32 * 64 + 32]);
    }

    #[test]
    fn brightness_of_the_scene_does_not_matter_with_its_exposure() {
        let pixels: Vec<[f32; 4]> =
            (0..48 * 20).map(|i| [(i % 7) as f32, (i % 5) as f32 * 9.0, 0.3, 1.0]).collect();
        let dim: Vec<_> = pixels.iter().map(|p| p.map(|c| c / 1024.0)).collect();
        let exposed = CompositorParameters { exposure: Some(10.0), ..all(0.3) };
        for (bright, dim) in
            bloomed(&all(0.3), &pixels, [48, 20]).iter().zip(bloomed(&exposed, &dim, [48, 20]))
        {
            for c in 0..3 {
                assert!((dim[c] * 1024.0 - bright[c]).abs() <= 1e-5 * bright[c], "{dim:?} {bright:?}");
            }
        }
    }
}
