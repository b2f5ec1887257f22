//! Twin of `shaders/shading/point_light.wgsl`.

use glam::{Vec3, Vec4};

use super::body::{COLOR_MIRROR, tinted};
use super::brdf::fresnel_dielectric;
use super::medium::transmitted;
use super::neighbourhood::neighbourhood;
use super::reflection::mirrored;
use super::refraction::{background_over, footprint_at_end, refracted_path};
use super::shadow::{shadow, sky_at};
use super::view::{point_to_world, to_world};
use super::water::{center_px, coverage, faced, over, water_point};
use super::{TwinInput, mix};
use crate::models::PointLightUniform;

const MAX_SHADOW: f32 = 0.55;
const MIN_INCIDENCE: f32 = 0.2;
const MIN_NEARNESS: f32 = 0.25;

/// Radiance and coverage of `pixel`.
pub(crate) fn shade_pixel(model: &PointLightUniform, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4] {
    let index = input.pixel_index(pixel);
    let shadow = |px, through| shadow(input, px, through, &model.medium, model.shadow_extinction, MAX_SHADOW);
    let scene = Vec4::from(input.scene_color[index]);
    if !input.shows_water(index) {
        return (scene * shadow(center_px(pixel), 0.0).extend(1.0)).to_array();
    }
    let (distance, thickness) = (input.distance[index], input.thickness[index]);
    let sky = &sky_at(input, pixel);
    let around = neighbourhood(input, pixel, distance, model.spacing_world);
    let water = water_point(input, pixel, distance, around.normal_sum);
    let normal = to_world(input.camera, water.normal_view);
    let to_eye = to_world(input.camera, water.to_eye_view);
    let position = point_to_world(input.camera, water.position_view);
    let tint = input.tint(index);

    let to_light = Vec3::from(model.light_position_world) - position;
    let nearness = (to_light.length() / model.light_distance_world).max(MIN_NEARNESS);
    let light = to_light / to_light.length().max(1e-30);
    let cos_i = normal.dot(light).max(0.0);
    let intensity = Vec3::from(model.intensity) / (nearness * nearness);
    let reflectance = fresnel_dielectric(cos_i.max(MIN_INCIDENCE), model.refractive_index);
    let theta = (-light).reflect(normal).dot(to_eye).max(0.0);
    let highlight = if cos_i > 0.0 { theta.powf(model.shininess) } else { 0.0 };

    let path = refracted_path(
        input,
        &water,
        thickness,
        model.refractive_index,
        model.refraction_scale,
        model.spacing_world,
    );
    let beside =
        [around.to_right, around.to_below].map(|to| faced(water.normal_view + to, water.to_eye_view));
    let footprint =
        footprint_at_end(input, &water, &path, beside, model.refractive_index, model.refraction_scale);
    let dim = shadow(path.end_px, path.length_world);
    let behind =
        dim * background_over(input, path.end_px, &footprint, path.nearest_distance, scene.truncate());
    let clear = transmitted(&model.medium, sky, normal, behind, path.length_world);
    let refracted = tinted(sky, clear, tint, normal);
    let direction = mirrored(input.surroundings, normal, to_eye);
    let mirror = input.mirror_radiance(position, direction, 0.0);
    let left = reflectance * (1.0 + (COLOR_MIRROR - 1.0) * tint.w);
    let color = mix(refracted, mirror, left) + intensity * left * (cos_i + highlight);
    over(scene * dim.extend(1.0), color, coverage(thickness, model.spacing_world))
}
