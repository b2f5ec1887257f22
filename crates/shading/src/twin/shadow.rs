//! Twin of `meniscus::shadow`.

use std::f32::consts::LOG2_E;

use glam::{IVec2, Vec2, Vec3};
use meniscus_gpu::role::Sunlight;

use super::{TwinInput, mix};
use crate::{MediumUniform, SkyUniform, SunlightPass};

const SHADOW_TINT: f32 = 0.7;
const BLURRING: f32 = 1.5;

fn block_at(input: &TwinInput<'_>, block: IVec2) -> [u32; 2] {
    let size = SunlightPass::size_blocks(input.camera.size_px).map(|blocks| blocks as i32);
    let at = block.clamp(IVec2::ZERO, IVec2::from(size) - 1);
    input.sunlight[((at.y * size[0] + at.x) as usize).min(input.sunlight.len() - 1)]
}

fn through_water(input: &TwinInput<'_>, px: Vec2) -> Vec2 {
    let corner = px / SunlightPass::BLOCK_PX as f32 - 0.5;
    let base = corner.floor();
    let f = corner - base;
    let value = |k: i32| {
        let [path, focus, _] = Sunlight::unpack(block_at(input, base.as_ivec2() + IVec2::new(k & 1, k >> 1)));
        Vec2::new(path, focus)
    };
    value(0).lerp(value(1), f.x).lerp(value(2).lerp(value(3), f.x), f.y)
}

/// Sun and sky as the water's surface sees them in a pixel.
pub(super) fn sky_at(input: &TwinInput<'_>, pixel: [u32; 2]) -> SkyUniform {
    let mut sky = input.surroundings.sky;
    let block = pixel.map(|at| (at / SunlightPass::BLOCK_PX) as i32);
    let [_, _, share] = Sunlight::unpack(block_at(input, block.into()));
    sky.sun_irradiance = sky.sun_irradiance.map(|light| light * share);
    sky
}

/// What the water between scene and sun makes of the light on the scene seen at `px`, through so much water.
pub(super) fn shadow(
    input: &TwinInput<'_>,
    px: Vec2,
    seen_through_world: f32,
    medium: &MediumUniform,
    bent_away: f32,
    deepest: f32,
) -> Vec3 {
    let light = through_water(input, px);
    let sky = &input.surroundings.sky;
    let sun = Vec3::from(sky.sun_irradiance) * Vec3::from(sky.sun_direction).dot(sky.up.into()).max(0.0);
    let share = sun / (sun + Vec3::from(sky.irradiance_up)).max(Vec3::splat(1e-30));
    let absorption = Vec3::from(medium.absorption);
    let grey = absorption.element_sum() / 3.0;
    let tinted = mix(Vec3::splat(grey), absorption, SHADOW_TINT);
    let extinction = tinted + medium.scattering + bent_away;
    let left = 1.0 - deepest * (1.0 - (-LOG2_E * extinction * light.x).map(f32::exp2));
    let blurring = BLURRING * (grey + medium.scattering);
    let clarity = (-LOG2_E * blurring * (light.x + seen_through_world)).exp2();
    1.0 + share * ((1.0 + (light.y - 1.0) * clarity) * left - 1.0)
}
