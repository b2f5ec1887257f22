//! Twin of `meniscus::body`.

use std::f32::consts::PI;

use glam::{Vec3, Vec4};

use super::mix;
use crate::SkyUniform;

pub(super) const LEGEND_SOFTNESS: f32 = 0.5;
pub(super) const COLOR_OPACITY: f32 = 0.95;
pub(super) const COLOR_MIRROR: f32 = 0.5;

/// From the sky on a surface that faces `normal`.
pub(super) fn ambient(sky: &SkyUniform, normal: Vec3) -> Vec3 {
    let facing_up = 0.5 + 0.5 * normal.dot(sky.up.into());
    mix(sky.irradiance_down.into(), sky.irradiance_up.into(), facing_up)
}

/// From sun and sky.
pub(super) fn irradiance(sky: &SkyUniform, normal: Vec3) -> Vec3 {
    let n_l = normal.dot(sky.sun_direction.into()).max(0.0);
    ambient(sky, normal) + n_l * Vec3::from(sky.sun_irradiance)
}

/// The same for light that enters and leaves elsewhere.
pub(super) fn soft_irradiance(sky: &SkyUniform, normal: Vec3, softness: f32) -> Vec3 {
    let wide = 1.0 + softness;
    let lit = (normal.dot(sky.sun_direction.into()) + softness).max(0.0) / (wide * wide);
    ambient(sky, normal) + lit * Vec3::from(sky.sun_irradiance)
}

/// `through`, the light that comes through the water, where an attribute colours it with `tint`.
pub(super) fn tinted(sky: &SkyUniform, through: Vec3, tint: Vec4, normal: Vec3) -> Vec3 {
    let colored = tint.truncate() * soft_irradiance(sky, normal, LEGEND_SOFTNESS) / PI;
    mix(through, colored, COLOR_OPACITY * tint.w)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    /// Over all directions soft light is no more than hard light: pi / (4 pi) of the sun.
    #[test]
    fn soft_light_is_taken_from_the_lit_side() {
        let sky =
            SkyUniform { sun_direction: [0.0, 0.0, 1.0], sun_irradiance: [1.0; 3], ..Zeroable::zeroed() };
        for softness in [0.0, 0.35, 1.0] {
            const N: usize = 1000;
            let mean = (0..N)
                .map(|i| {
                    // Uniform in height: uniform on the sphere.
                    let z = 2.0 * (i as f32 + 0.5) / N as f32 - 1.0;
                    soft_irradiance(&sky, Vec3::new((1.0 - z * z).sqrt(), 0.0, z), softness).x / N as f32
                })
                .sum::<f32>();
            // 1e-3: the midpoint rule at the kink.
            assert!((mean - 0.25).abs() < 1e-3, "softness {softness}: {mean}");
        }
    }
}
