//! Twin of `shaders/shading/lambert.wgsl`.

use glam::Vec4;

use super::TwinInput;
use super::medium::veiled;
use super::view::to_world;
use super::water::{coverage, over};
use crate::models::LambertUniform;

/// Radiance and coverage of `pixel`.
pub(crate) fn shade_pixel(model: &LambertUniform, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4] {
    let index = input.pixel_index(pixel);
    let scene = Vec4::from(input.scene_color[index]);
    if !input.shows_water(index) {
        return scene.to_array();
    }
    let thickness = input.thickness[index];
    let normal = to_world(input.camera, input.plain_water_point(pixel, index).normal_view);
    let color = veiled(
        &model.medium,
        &input.surroundings.sky,
        normal,
        scene.truncate(),
        thickness,
        model.color.into(),
        input.tint(index),
    );
    over(scene, color, coverage(thickness, model.spacing_world))
}
