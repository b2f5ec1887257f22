//! The analytic sky.

use glam::Vec3;

use super::{mix, smoothstep};
use crate::SkyUniform;

/// Radiance from the unit direction; below the horizon it is that of the horizon under the same azimuth.
pub(crate) fn sky_radiance(sky: &SkyUniform, direction: Vec3) -> Vec3 {
    let height = direction.dot(sky.up.into()).max(0.0);
    let haze = (-5.0 * height).exp2();
    let gradient = mix(sky.zenith.into(), sky.horizon.into(), haze);
    let c = direction.dot(sky.sun_direction.into()).max(0.0);
    let c4 = c.powi(4);
    let c32 = c4.powi(8);
    let c128 = c32.powi(4);
    let glow = sky.glow * (0.035 * c4 + 0.05 * c32 + 0.22 * c128);
    gradient + glow * Vec3::from(sky.sun_irradiance)
}

/// `sky` (from [`sky_radiance`]), but ground below the horizon.
pub(crate) fn sky_and_ground_radiance(s: &SkyUniform, direction: Vec3, sky: Vec3) -> Vec3 {
    let below = smoothstep(0.0, 1.0, (-12.0 * direction.dot(s.up.into())).clamp(0.0, 1.0));
    mix(sky, s.ground.into(), below)
}
