//! From what was drawn to the pixels that are written: more bits than a display image has, and several drawn pixels to one.

use glam::Vec3;
use meniscus_core::srgb;
use rayon::prelude::*;

use crate::CompositorParameters;
use crate::twin::bloom::bloomed;
use crate::twin::display_color;

/// The highest number of half floats, which radiance is written in.
const HIGHEST: f32 = 65504.0;

/// The display image with 16 bits per channel of radiance with coverage, a picture of `size` pixels, without dither or anti-aliasing.
pub fn display_16(parameters: &CompositorParameters, radiance: &[[f32; 4]], size: [u32; 2]) -> Vec<[u16; 4]> {
    let bloomed = (parameters.bloom > 0.0).then(|| bloomed(parameters, radiance, size));
    let radiance = bloomed.as_deref().unwrap_or(radiance);
    let pixel = |&[r, g, b, coverage]: &[f32; 4]| {
        let [r, g, b] = display_color(parameters, [r, g, b]);
        let alpha = if parameters.transparent { coverage } else { 1.0 };
        [r, g, b, alpha].map(|c| steps(c, 65535.0) as u16)
    };
    radiance.par_iter().map(pixel).collect()
}

/// The radiance as it was computed, with what is no number left out; alpha is coverage, or 1 for opaque pictures.
pub fn finite_radiance(parameters: &CompositorParameters, radiance: &[[f32; 4]]) -> Vec<[f32; 4]> {
    let channel = |c: f32| if c.is_nan() { 0.0 } else { c.clamp(0.0, HIGHEST) };
    let pixel = |&[r, g, b, coverage]: &[f32; 4]| {
        let alpha = if parameters.transparent { channel(coverage).min(1.0) } else { 1.0 };
        [channel(r), channel(g), channel(b), alpha]
    };
    radiance.par_iter().map(pixel).collect()
}

/// A picture of `size` pixels from one that is `factor` times as wide and high: means of light, not of its code, and of colours by
/// how much they cover.
pub fn reduce_display_8(pixels: &[u32], size: [u32; 2], factor: u32) -> Vec<u32> {
    let code: Vec<f32> = (0..256).map(|step| srgb::decode(step as f32 / 255.0)).collect();
    let light = |pixel: u32| {
        let [r, g, b, a] = pixel.to_le_bytes();
        [code[usize::from(r)], code[usize::from(g)], code[usize::from(b)], f32::from(a) / 255.0]
    };
    let pack = |[r, g, b, a]: [f32; 4]| {
        let color = [srgb::encode(r), srgb::encode(g), srgb::encode(b), a].map(|c| steps(c, 255.0) as u8);
        u32::from_le_bytes(color)
    };
    means(pixels, size, factor, light).into_par_iter().map(pack).collect()
}

/// As [`reduce_display_8`].
pub fn reduce_display_16(pixels: &[[u16; 4]], size: [u32; 2], factor: u32) -> Vec<[u16; 4]> {
    let light = |pixel: [u16; 4]| {
        let [r, g, b, a] = pixel.map(|c| f32::from(c) / 65535.0);
        [srgb::decode(r), srgb::decode(g), srgb::decode(b), a]
    };
    let pack = |[r, g, b, a]: [f32; 4]| {
        [srgb::encode(r), srgb::encode(g), srgb::encode(b), a].map(|c| steps(c, 65535.0) as u16)
    };
    means(pixels, size, factor, light).into_par_iter().map(pack).collect()
}

/// As [`reduce_display_8`], of linear pixels.
pub fn reduce_linear(pixels: &[[f32; 4]], size: [u32; 2], factor: u32) -> Vec<[f32; 4]> {
    means(pixels, size, factor, |pixel| pixel)
}

/// The nearest of `highest` steps from 0 to 1.
fn steps(value: f32, highest: f32) -> f32 {
    (value.clamp(0.0, 1.0) * highest).round()
}

fn means<P: Copy + Sync>(
    pixels: &[P],
    size: [u32; 2],
    factor: u32,
    light: impl Fn(P) -> [f32; 4] + Sync,
) -> Vec<[f32; 4]> {
    let ([width, height], factor) = (size.map(|side| side as usize), factor as usize);
    assert_eq!(pixels.len(), width * height * factor * factor, "pixels of {factor} times {size:?}");
    let mean = |i: usize| {
        let (x, y) = (i % width * factor, i / width * factor);
        let (mut plain, mut covered, mut coverage) = (Vec3::ZERO, Vec3::ZERO, 0.0);
        for row in y..y + factor {
            let start = row * width * factor + x;
            for &pixel in &pixels[start..start + factor] {
                let [r, g, b, a] = light(pixel);
                let color = Vec3::new(r, g, b);
                plain += color;
                covered += color * a;
                coverage += a;
            }
        }
        let count = (factor * factor) as f32;
        // Where nothing is covered, the colour does not count, but there is one.
        let color = if coverage > 0.0 { covered / coverage } else { plain / count };
        [color.x, color.y, color.z, coverage / count]
    };
    (0..width * height).into_par_iter().map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_of_light() {
        let (black, white) = (0xff00_0000, 0xffff_ffff);
        // Half the light is code 188, not 128: IEC 61966-2-1.
        assert_eq!(reduce_display_8(&[black, white, white, black], [1, 1], 2), [0xffbc_bcbc]);
        let deep =
            reduce_display_16(&[[0, 0, 0, 65535], [65535; 4], [65535; 4], [0, 0, 0, 65535]], [1, 1], 2);
        assert_eq!(deep[0][0] >> 8, 0xbc);
        assert_eq!(reduce_linear(&[[0.0, 4.0, 1.0, 1.0]; 9], [1, 1], 3), [[0.0, 4.0, 1.0, 1.0]]);
    }

    #[test]
    fn a_picture_of_one_colour_stays_it_and_places_stay() {
        let pixels: Vec<u32> =
            (0..6 * 4).map(|i| 0xff00_0000 | (i % 6 / 2) << 8 | ((i / 12) * 200)).collect();
        let expected: Vec<u32> = (0..3 * 2).map(|i| 0xff00_0000 | (i % 3) << 8 | ((i / 3) * 200)).collect();
        assert_eq!(reduce_display_8(&pixels, [3, 2], 2), expected);
    }

    #[test]
    fn what_is_transparent_does_not_colour_what_is_not() {
        let (red, clear) = (0xff00_00ff, 0x00ff_ffff);
        assert_eq!(reduce_display_8(&[red, clear, clear, clear], [1, 1], 2), [0x4000_00ff]);
        assert_eq!(reduce_display_8(&[clear; 4], [1, 1], 2), [clear]);
    }

    #[test]
    fn sixteen_bits_have_bloom() {
        let mut radiance = vec![[0.1, 0.1, 0.1, 1.0]; 16 * 16];
        radiance[8 * 16 + 8] = [9.0, 9.0, 9.0, 1.0];
        let beside = |bloom: f32| {
            let parameters = CompositorParameters { bloom, ..Default::default() };
            display_16(&parameters, &radiance, [16, 16])[8 * 16 + 10][0]
        };
        assert!(beside(0.5) > beside(0.1) && beside(0.1) > beside(0.0), "{} {}", beside(0.5), beside(0.0));
    }

    #[test]
    fn sixteen_bits_are_the_eight_with_more_digits_and_nothing_is_nan() {
        let parameters = CompositorParameters { transparent: true, ..Default::default() };
        let radiance =
            [[0.2, 0.5, 3.0, 0.5], [f32::NAN, 0.0, -1.0, 2.0], [f32::INFINITY, 0.0, 0.0, f32::NAN]];
        let deep = display_16(&parameters, &radiance, [3, 1]);
        let expected = display_color(&parameters, [0.2, 0.5, 3.0]);
        for (deep, expected) in deep[0].iter().zip(expected.into_iter().chain([0.5])) {
            assert!((f32::from(*deep) / 65535.0 - expected).abs() < 1e-5);
        }
        assert_eq!((deep[1], deep[2][3]), ([0, 0, 0, 65535], 0));
        assert!(deep[2][0] > 65000);
        let linear = finite_radiance(&parameters, &radiance);
        assert_eq!(linear, [[0.2, 0.5, 3.0, 0.5], [0.0, 0.0, 0.0, 1.0], [65504.0, 0.0, 0.0, 0.0]]);
        let opaque = finite_radiance(&CompositorParameters::default(), &radiance);
        assert_eq!(opaque[0][3], 1.0);
    }
}
