//! Twin of `shaders/shading/opaque_liquid.wgsl`.

use std::f32::consts::PI;

use glam::Vec4;

use super::body::{COLOR_MIRROR, LEGEND_SOFTNESS, soft_irradiance};
use super::brdf::fresnel_dielectric;
use super::neighbourhood::neighbourhood;
use super::reflection::{mirrored, sun_glint};
use super::shadow::{shadow, sky_at};
use super::view::{point_to_world, to_world};
use super::water::{center_px, coverage, over, water_point};
use super::{TwinInput, mix, smoothstep};
use crate::MediumUniform;
use crate::models::OpaqueLiquidUniform;

const MAX_SHADOW: f32 = 0.9;

/// Radiance and coverage of `pixel`.
pub(crate) fn shade_pixel(model: &OpaqueLiquidUniform, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4] {
    let index = input.pixel_index(pixel);
    let medium = MediumUniform { absorption: [0.0; 3], scattering: model.shadow_extinction };
    let dim = shadow(input, center_px(pixel), 0.0, &medium, 0.0, MAX_SHADOW);
    let scene = Vec4::from(input.scene_color[index]) * dim.extend(1.0);
    if !input.shows_water(index) {
        return scene.to_array();
    }
    let sky = &sky_at(input, pixel);
    let distance = input.distance[index];
    let around = neighbourhood(input, pixel, distance, model.spacing_world);
    let water = water_point(input, pixel, distance, around.normal_sum);
    let normal = to_world(input.camera, water.normal_view);
    let to_eye = to_world(input.camera, water.to_eye_view);
    let tint = input.tint(index);

    let albedo = mix(model.color.into(), tint.truncate(), tint.w);
    let softness = model.softness * (1.0 - tint.w) + LEGEND_SOFTNESS * tint.w;
    let body = albedo * soft_irradiance(sky, normal, softness) / PI;
    let alpha = (model.alpha * model.alpha + 0.5 * around.spread).sqrt().min(0.6);
    let facing = smoothstep(0.15, 0.5, water.n_v);
    let glint = facing * sun_glint(sky, normal, to_eye, water.n_v, alpha, model.refractive_index);
    let position = point_to_world(input.camera, water.position_view);
    let direction = mirrored(input.surroundings, normal, to_eye);
    let mirror = input.mirror_radiance(position, direction, model.alpha);
    let cosine = (water.n_v * water.n_v + 0.2 * around.spread).sqrt().min(1.0);
    let left = 1.0 + (COLOR_MIRROR - 1.0) * tint.w;
    let reflectance = fresnel_dielectric(cosine, model.refractive_index);
    let color = mix(body, mirror, left * reflectance) + left * glint;
    over(scene, color, coverage(input.thickness[index], model.spacing_world))
}
