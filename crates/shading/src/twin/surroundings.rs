//! The floor and what else a ray meets that meets neither water nor an object.

use glam::{Vec2, Vec3};
use meniscus_gpu::role::NO_SURFACE;

use super::brdf::{burley_diffuse, ggx};
use super::material::pattern_tone;
use super::mix;
use super::sky::{sky_and_ground_radiance, sky_radiance};
use crate::{MaterialUniform, SkyUniform, Surroundings};

/// Width of a pixel's cone: at the origin of the ray and per unit of length.
#[derive(Clone, Copy)]
pub(crate) struct Cone {
    pub width_world: f32,
    pub growth: f32,
}

/// Length along the unit direction to the floor; [`NO_SURFACE`] if it is not met from above.
pub(crate) fn trace_floor(s: &Surroundings, origin: Vec3, direction: Vec3) -> f32 {
    let height = origin.dot(s.sky.up.into()) - s.floor_height_world;
    let descent = -direction.dot(s.sky.up.into());
    if s.has_floor == 0 || height < 0.0 || descent * NO_SURFACE * 1e-9 <= height {
        return NO_SURFACE;
    }
    height / descent
}

/// Radiance of an opaque surface under sun and sky towards `to_eye`.
pub(crate) fn opaque_radiance(
    sky: &SkyUniform,
    material: &MaterialUniform,
    tone: f32,
    normal: Vec3,
    to_eye: Vec3,
) -> Vec3 {
    let base = Vec3::from(material.color) * tone;
    let f0 = mix(Vec3::splat(0.04), base, material.metallic);
    let diffuse = base * (1.0 - material.metallic);
    let n_v = normal.dot(to_eye).max(1e-3);
    let alpha = (material.roughness * material.roughness).max(2e-3);
    let sun_direction = Vec3::from(sky.sun_direction);

    let n_l = normal.dot(sun_direction);
    let mut sun = Vec3::ZERO;
    if n_l > 0.0 {
        let half_way = (sun_direction + to_eye).normalize();
        let l_h = sun_direction.dot(half_way).max(0.0);
        let fresnel = f0 + (1.0 - f0) * (1.0 - l_h).powi(5);
        let specular = fresnel * ggx(n_l, n_v, normal.dot(half_way).max(0.0), alpha);
        let lobe = diffuse * burley_diffuse(n_l, n_v, l_h, material.roughness) + specular;
        sun = lobe * n_l * Vec3::from(sky.sun_irradiance);
    }

    let facing_up = 0.5 + 0.5 * normal.dot(sky.up.into());
    let ambient = mix(sky.irradiance_down.into(), sky.irradiance_up.into(), facing_up);
    let c0 = glam::Vec4::new(-1.0, -0.0275, -0.572, 0.022) * material.roughness
        + glam::Vec4::new(1.0, 0.0425, 1.04, -0.04);
    let a004 = (c0.x * c0.x).min((-9.28 * n_v).exp2()) * c0.x + c0.y;
    let (scale, bias) = (-1.04 * a004 + c0.z, 1.04 * a004 + c0.w);
    sun + (diffuse + f0 * scale + bias) * ambient * std::f32::consts::FRAC_1_PI
}

fn floor_radiance(s: &Surroundings, origin: Vec3, direction: Vec3, length: f32, cone: Cone) -> Vec3 {
    let hit = origin + length * direction - Vec3::from(s.anchor);
    let per_pattern = 1.0 / s.floor.scale_world;
    let on_floor = |v: Vec3| Vec2::new(v.dot(s.east.into()), v.dot(s.north.into()));
    let width = (cone.width_world + cone.growth * length) * per_pattern;
    let descent = (-direction.dot(s.sky.up.into())).max(1e-4);
    let along = on_floor(direction) / descent;
    let footprint = width * (Vec2::ONE + along * along).map(f32::sqrt);
    let tone = pattern_tone(s.floor.pattern, on_floor(hit) * per_pattern, footprint);
    let lit = opaque_radiance(&s.sky, &s.floor, tone, s.sky.up.into(), -direction);
    let clear = (-std::f32::consts::LOG2_E * length * s.haze_per_world).exp2();
    mix(sky_radiance(&s.sky, direction), lit, clear)
}

/// Radiance that arrives at `origin` (world) against the unit `direction`.
pub(crate) fn surroundings_radiance(s: &Surroundings, origin: Vec3, direction: Vec3, cone: Cone) -> Vec3 {
    let length = trace_floor(s, origin, direction);
    if length < NO_SURFACE {
        floor_radiance(s, origin, direction, length, cone)
    } else if s.has_floor != 0 {
        sky_radiance(&s.sky, direction)
    } else {
        sky_and_ground_radiance(&s.sky, direction)
    }
}
