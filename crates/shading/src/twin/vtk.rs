//! Twin of `shaders/shading/vtk.wgsl`.

use std::f32::consts::{LOG2_E, PI};

use glam::{Vec2, Vec3};

use super::body::irradiance;
use super::refraction::{background, refract};
use super::view::{point_to_world, to_world};
use super::water::center_px;
use super::{TwinInput, mix};
use crate::models::VtkUniform;

const SHININESS: f32 = 150.0;

/// Radiance and coverage of `pixel`.
pub(crate) fn shade_pixel(model: &VtkUniform, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4] {
    let index = input.pixel_index(pixel);
    if !input.shows_water(index) {
        return input.scene_color[index];
    }
    let sky = &input.surroundings.sky;
    let water = input.plain_water_point(pixel, index);
    let normal = to_world(input.camera, water.normal_view);
    let to_eye = to_world(input.camera, water.to_eye_view);
    let tint = input.tint(index);

    let sun = Vec3::from(sky.sun_direction);
    let phong = (-sun).reflect(normal).dot(to_eye).max(0.0).powf(SHININESS);
    let highlight = phong * Vec3::from(sky.sun_irradiance) / PI;
    if model.is_opaque != 0 {
        let color = mix(model.color.into(), tint.truncate(), tint.w);
        return (color * irradiance(sky, normal) / PI + highlight).extend(1.0).to_array();
    }

    let f0 = (1.0 - model.refractive_index) / (1.0 + model.refractive_index);
    let schlick = f0 * f0 + (1.0 - f0 * f0) * (1.0 - water.n_v).powi(5);
    let fresnel = schlick + (1.0 - schlick) * model.additional_reflection;
    let bent = refract(-water.to_eye_view, water.normal_view, 1.0 / model.refractive_index);
    let size = input.size().as_vec2();
    let shift = Vec2::new(bent.x, -bent.y) * model.refraction_scale * size;
    let at_px = (center_px(pixel) + shift).clamp(Vec2::ZERO, size);
    let dyed = tint.truncate().max(Vec3::splat(1e-6)).map(|c| c.powf(model.particle_color_power));
    let dye = (1.0 - dyed * model.particle_color_scale).max(Vec3::ZERO) * model.dye_per_world;
    let attenuation = mix(model.attenuation.into(), dye, tint.w);
    let behind = background(input, at_px, 0.0, input.scene_rgb(index));
    let through = (-LOG2_E * attenuation * input.thickness[index]).map(f32::exp2) * behind;
    let position = point_to_world(input.camera, water.position_view);
    let mirror = input.mirror_radiance(position, (-to_eye).reflect(normal), 0.0);
    (mix(through, mirror, fresnel) + highlight).extend(1.0).to_array()
}
