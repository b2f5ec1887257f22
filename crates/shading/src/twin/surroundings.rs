//! What a ray meets that meets neither water nor an object.

use glam::Vec3;
use meniscus_gpu::role::NO_SURFACE;

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

/// Radiance that arrives at `origin` (world) against the unit `direction`, with the floor's pattern averaged out.
pub(crate) fn surroundings_radiance(s: &Surroundings, origin: Vec3, direction: Vec3) -> Vec3 {
    let sky = sky_radiance(&s.sky, direction);
    let far = if s.has_floor != 0 { sky } else { sky_and_ground_radiance(&s.sky, direction, sky) };
    let length = trace_floor(s, origin, direction);
    if length == NO_SURFACE {
        return far;
    }
    let clear = (-std::f32::consts::LOG2_E * length * s.haze_per_world).exp2();
    mix(far, s.floor_radiance.into(), clear)
}
