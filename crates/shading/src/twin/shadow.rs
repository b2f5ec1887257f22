//! Twin of `meniscus::shadow`.

use std::f32::consts::LOG2_E;

use glam::{IVec2, Vec2, Vec3};

use super::{TwinInput, mix};
use crate::{MediumUniform, WaterShadow};

const SHADOW_TINT: f32 = 0.7;

fn sun_path(input: &TwinInput<'_>, px: Vec2) -> f32 {
    let size = WaterShadow::size_blocks(input.camera.size_px);
    let last = IVec2::new(size[0] as i32, size[1] as i32) - 1;
    let corner = px / WaterShadow::BLOCK_PX as f32 - 0.5;
    let base = corner.floor();
    let f = corner - base;
    let low = base.as_ivec2().clamp(IVec2::ZERO, last);
    let high = (base.as_ivec2() + 1).clamp(IVec2::ZERO, last);
    let at = |x: i32, y: i32| input.sun_path[y as usize * size[0] as usize + x as usize];
    let row = |y: i32| at(low.x, y) * (1.0 - f.x) + at(high.x, y) * f.x;
    row(low.y) * (1.0 - f.y) + row(high.y) * f.y
}

/// What the water between scene and sun leaves of the light on the scene seen at `px`.
pub(super) fn shadow(
    input: &TwinInput<'_>,
    px: Vec2,
    medium: &MediumUniform,
    bent_away: f32,
    deepest: f32,
) -> Vec3 {
    let path = sun_path(input, px);
    if path <= 0.0 {
        return Vec3::ONE;
    }
    let sky = &input.surroundings.sky;
    let sun = Vec3::from(sky.sun_irradiance) * Vec3::from(sky.sun_direction).dot(sky.up.into()).max(0.0);
    let share = sun / (sun + Vec3::from(sky.irradiance_up)).max(Vec3::splat(1e-30));
    let absorption = Vec3::from(medium.absorption);
    let tinted = mix(Vec3::splat(absorption.element_sum() / 3.0), absorption, SHADOW_TINT);
    let extinction = tinted + medium.scattering + bent_away;
    1.0 - deepest * share * (1.0 - (-LOG2_E * extinction * path).map(f32::exp2))
}
