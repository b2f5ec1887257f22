//! Twin of `shaders/shading/blinn_phong.wgsl`.

use std::f32::consts::PI;

use glam::{Vec3, Vec4};

use super::TwinInput;
use super::medium::veiled;
use super::view::to_world;
use super::water::{coverage, over};
use crate::models::BlinnPhongUniform;

/// Radiance and coverage of `pixel`.
pub(crate) fn shade_pixel(model: &BlinnPhongUniform, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4] {
    let index = input.pixel_index(pixel);
    let scene = Vec4::from(input.scene_color[index]);
    if !input.shows_water(index) {
        return scene.to_array();
    }
    let sky = &input.surroundings.sky;
    let thickness = input.thickness[index];
    let water = input.plain_water_point(pixel, index);
    let normal = to_world(input.camera, water.normal_view);
    let (color, tint) = (model.color.into(), input.tint(index));
    let body = veiled(&model.medium, sky, normal, scene.truncate(), thickness, color, tint);
    let sun = Vec3::from(sky.sun_direction);
    let between = sun + to_world(input.camera, water.to_eye_view);
    let n_h = normal.dot(between / between.length().max(1e-6)).max(0.0);
    let lit = if normal.dot(sun) > 0.0 { n_h.powf(model.shininess) } else { 0.0 };
    let color = body + model.specular * lit * Vec3::from(sky.sun_irradiance) / PI;
    over(scene, color, coverage(thickness, model.spacing_world))
}
