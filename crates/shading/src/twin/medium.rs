//! Twin of `meniscus::medium`.

use std::f32::consts::{LOG2_E, PI};

use glam::{Vec3, Vec4};

use super::body::{COLOR_OPACITY, irradiance};
use super::{mix, smoothstep};
use crate::{MediumUniform, SkyUniform};

/// Share of light that goes straight through.
pub(super) fn transmittance(medium: &MediumUniform, path_world: f32) -> Vec3 {
    (-LOG2_E * Vec3::from(medium.extinction()) * path_world).map(f32::exp2)
}

/// Light that comes through the water below a surface with this normal.
pub(super) fn transmitted(
    medium: &MediumUniform,
    sky: &SkyUniform,
    normal: Vec3,
    behind: Vec3,
    path_world: f32,
) -> Vec3 {
    let through = transmittance(medium, path_world);
    let around = (Vec3::from(sky.irradiance_up) + Vec3::from(sky.irradiance_down)) / (2.0 * PI)
        + Vec3::from(sky.sun_irradiance) / (4.0 * PI);
    let density = 1.0 - (-LOG2_E * medium.scattering * path_world).exp2();
    let light = mix(around, irradiance(sky, normal) / PI, smoothstep(0.3, 1.0, density));
    let albedo = medium.scattering / Vec3::from(medium.extinction()).max(Vec3::splat(1e-30));
    through * behind + albedo * (1.0 - through) * light
}

/// The scene straight behind, veiled by a diffuse body.
pub(super) fn veiled(
    medium: &MediumUniform,
    sky: &SkyUniform,
    normal: Vec3,
    behind: Vec3,
    path_world: f32,
    color: Vec3,
    tint: Vec4,
) -> Vec3 {
    let through = transmittance(medium, path_world) * (1.0 - COLOR_OPACITY * tint.w);
    let body = mix(color, tint.truncate(), tint.w) * irradiance(sky, normal) / PI;
    body * (1.0 - through) + behind * through
}
