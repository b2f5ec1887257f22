//! Twin of `meniscus::reflection`.

use glam::Vec3;

use super::brdf::{fresnel_dielectric, ggx};
use super::smoothstep;
use crate::{SkyUniform, Surroundings};

const MAX_GLINT: f32 = 6.0;

/// Where the mirror of the water looks.
pub(super) fn mirrored(surroundings: &Surroundings, normal: Vec3, to_eye: Vec3) -> Vec3 {
    let direction = (-to_eye).reflect(normal);
    let up = Vec3::from(surroundings.sky.up);
    let level = smoothstep(0.15, 0.5, normal.dot(up));
    (direction - 2.0 * level * direction.dot(up).min(0.0) * up).normalize()
}

/// The sun in a rough mirror of GGX width `alpha`.
pub(super) fn sun_glint(
    sky: &SkyUniform,
    normal: Vec3,
    to_eye: Vec3,
    n_v: f32,
    alpha: f32,
    refractive_index: f32,
) -> Vec3 {
    let sun = Vec3::from(sky.sun_direction);
    let n_l = normal.dot(sun);
    let between = sun + to_eye;
    let half_way = between / between.length().max(1e-6);
    let lobe = ggx(n_l.max(1e-3), n_v, normal.dot(half_way).max(0.0), alpha) * n_l.max(0.0);
    let glint =
        fresnel_dielectric(to_eye.dot(half_way), refractive_index) * lobe * Vec3::from(sky.sun_irradiance);
    glint.min(Vec3::splat(MAX_GLINT))
}
