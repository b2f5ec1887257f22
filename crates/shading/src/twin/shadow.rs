//! Twin of `meniscus::shadow`.

use std::f32::consts::LOG2_E;

use glam::{IVec2, Vec2, Vec3};

use super::{TwinInput, mix};
use crate::{MediumUniform, WaterShadow};

const SHADOW_TINT: f32 = 0.7;

fn sun_path(input: &TwinInput<'_>, px: Vec2) -> f32 {
    let size_px = input.camera.size_px;
    let size = WaterShadow::size_blocks(size_px);
    let last = IVec2::new(size[0] as i32, size[1] as i32) - 1;
    let corner = px / WaterShadow::BLOCK_PX as f32 - 0.5;
    let base = corner.floor();
    let f = corner - base;
    let blocks = [0, 1, 2, 3].map(|k| (base.as_ivec2() + IVec2::new(k & 1, k >> 1)).clamp(IVec2::ZERO, last));
    let weights = [(1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y];
    let path = |block: IVec2| input.sun_path[block.y as usize * size[0] as usize + block.x as usize];
    let edge = Vec2::new(size_px[0] as f32, size_px[1] as f32) - 0.5;
    let shows_water = |px: Vec2| {
        let pixel = px.clamp(Vec2::ZERO, edge).as_uvec2();
        input.shows_water(input.pixel_index(pixel.to_array()))
    };
    let all = std::iter::zip(blocks, weights).map(|(block, weight)| weight * path(block)).sum();
    if shows_water(px) {
        return all;
    }
    let middle = |block: IVec2| (block.as_vec2() + 0.5) * WaterShadow::BLOCK_PX as f32;
    let beside = std::iter::zip(blocks, weights).filter(|(block, _)| !shows_water(middle(*block)));
    let (sum, total) =
        beside.fold((0.0, 0.0), |(sum, total), (block, weight)| (sum + weight * path(block), total + weight));
    if total > 1e-3 { sum / total } else { all }
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
