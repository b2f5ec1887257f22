//! What a ray meets that meets neither water nor an object.

use glam::Vec3;
use meniscus_gpu::role::NO_SURFACE;

use super::environment::environment_radiance;
use super::mix;
use super::sky::{sky_and_ground_radiance, sky_radiance};
use crate::Surroundings;

/// Length along the unit direction to the floor; [`NO_SURFACE`] if it is not met from above.
pub(crate) fn trace_floor(s: &Surroundings, origin: Vec3, direction: Vec3) -> f32 {
    let height = origin.dot(s.sky.up.into()) - s.floor_height_world;
    let descent = -direction.dot(s.sky.up.into());
    if s.has_floor == 0 || height < 0.0 || descent * NO_SURFACE * 1e-9 <= height {
        return NO_SURFACE;
    }
    height / descent
}

/// What is far away in the unit direction, seen in a mirror of this perceptual roughness.
pub(crate) fn blurred_far_radiance(
    s: &Surroundings,
    texels: &[[f32; 4]],
    direction: Vec3,
    roughness: f32,
) -> Vec3 {
    if s.environment.sharp[0] > 0 {
        let along = |axis: [f32; 3]| direction.dot(axis.into());
        let mut local = Vec3::new(along(s.east), along(s.north), along(s.sky.up));
        if s.has_floor != 0 {
            local.z = local.z.max(0.0);
        }
        return environment_radiance(&s.environment, texels, local / local.length().max(1e-6), roughness);
    }
    let sky = sky_radiance(&s.sky, direction);
    if s.has_floor != 0 { sky } else { sky_and_ground_radiance(&s.sky, direction, sky) }
}

/// Radiance that arrives at `origin` (world) against the unit `direction`, with the floor's pattern averaged out.
pub(crate) fn surroundings_radiance(
    s: &Surroundings,
    texels: &[[f32; 4]],
    origin: Vec3,
    direction: Vec3,
    roughness: f32,
) -> Vec3 {
    let far = blurred_far_radiance(s, texels, direction, roughness);
    let length = trace_floor(s, origin, direction);
    if length == NO_SURFACE {
        return far;
    }
    let clear = (-std::f32::consts::LOG2_E * length * s.haze_per_world).exp2();
    mix(far, s.floor_radiance.into(), clear)
}
