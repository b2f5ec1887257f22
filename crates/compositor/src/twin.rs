//! CPU twins: of `shaders/compositor/tone_map.wgsl`, without the dither, and of anti-aliasing.

pub mod bloom;
pub mod fxaa;

use glam::Vec3;
use meniscus_core::srgb;

use crate::{CompositorParameters, ToneCurve};

const MAX_RADIANCE: f32 = 6e4;
/// Of linear Rec. 709.
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);
const MIDDLE_GREY: f32 = 0.18;

/// Khronos PBR neutral tone mapper, specification 1.0; input linear Rec. 709 >= 0, output in [0, 1].
pub fn pbr_neutral(input: Vec3) -> Vec3 {
    const START: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let low = input.min_element();
    let offset = if low < 0.08 { low - 6.25 * low * low } else { 0.04 };
    let color = input - offset;
    let peak = color.max_element();
    if peak < START {
        return color;
    }
    let d = 1.0 - START;
    let new_peak = 1.0 - d * d / (peak + d - START);
    let g = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    color * (new_peak / peak) * (1.0 - g) + Vec3::splat(new_peak) * g
}

/// Narkowicz's rational fit of the ACES reference rendering (2015), at his exposure.
pub fn filmic(input: Vec3) -> Vec3 {
    let x = 0.6 * input;
    x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
}

/// What is a number, from 0 to what is told apart.
fn finite(radiance: [f32; 3]) -> Vec3 {
    Vec3::from(radiance.map(|x| if x.is_nan() { 0.0 } else { x.clamp(0.0, MAX_RADIANCE) }))
}

/// Display colour in [0, 1] of any radiance, NaN and infinities included.
pub fn display_color(parameters: &CompositorParameters, radiance: [f32; 3]) -> [f32; 3] {
    let mut color = finite(radiance) * Vec3::from(parameters.white_balance) * parameters.stops().exp2();
    if parameters.contrast != 1.0 {
        color = MIDDLE_GREY * (color.max(Vec3::splat(1e-6)) / MIDDLE_GREY).powf(parameters.contrast);
    }
    let grey = Vec3::splat(color.dot(LUMINANCE));
    let s = parameters.saturation;
    color = (grey * (1.0 - s) + color * s).clamp(Vec3::ZERO, Vec3::splat(MAX_RADIANCE));
    color = match parameters.tone_curve {
        ToneCurve::Neutral => pbr_neutral(color),
        ToneCurve::Filmic => filmic(color),
        ToneCurve::Clip => color,
    };
    color.clamp(Vec3::ZERO, Vec3::ONE).to_array().map(srgb::encode)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neutral_keeps_colours_and_compresses_highlights() {
        // The specification: above the toe and below the shoulder only the offset of 0.04 is taken.
        let kept = pbr_neutral(Vec3::new(0.5, 0.3, 0.2));
        assert!(kept.distance(Vec3::new(0.46, 0.26, 0.16)) < 1e-6, "{kept}");
        let mut last = 0.0;
        for i in 1..200 {
            let grey = pbr_neutral(Vec3::splat(0.05 * i as f32)).x;
            assert!(grey > last && grey < 1.0, "{grey}");
            last = grey;
        }
        let bright = pbr_neutral(Vec3::new(100.0, 1.0, 1.0));
        assert!(bright.y > 0.5, "highlights lose saturation: {bright}");
    }

    #[test]
    fn curves_meet_their_published_points() {
        // Narkowicz: x = 1 after exposure gives (2.51 + 0.03) / (2.43 + 0.59 + 0.14).
        assert!((filmic(Vec3::splat(1.0 / 0.6)).x - 2.54 / 3.16).abs() < 1e-5);
    }
}
