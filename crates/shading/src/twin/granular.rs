//! Twin of `shaders/shading/granular.wgsl`.

use std::f32::consts::PI;

use glam::{IVec2, Vec3, Vec4};

use super::body::ambient;
use super::brdf::fresnel_dielectric;
use super::reflection::{mirrored, sun_glint};
use super::shadow::{shadow, sky_at};
use super::view::{point_to_world, px_per_world, to_world, view_position};
use super::water::{WaterPoint, center_px, coverage, over};
use super::{TwinInput, mix};
use crate::MediumUniform;
use crate::models::GranularUniform;

const MAX_SHADOW: f32 = 0.9;
const FILM_INDEX: f32 = 1.333;
const FILM_ALPHA: f32 = 0.12;
const WET_TONE: f32 = 0.55;
const NEAR_SPACINGS: f32 = 0.8;
const FAR_SPACINGS: f32 = 2.2;
const MAX_GAP_PX: f32 = 48.0;

fn enclosed(model: &GranularUniform, input: &TwinInput<'_>, pixel: [u32; 2], water: &WaterPoint) -> f32 {
    let spacing_px = model.spacing_world * px_per_world(input.camera, water.distance);
    let here = IVec2::new(pixel[0] as i32, pixel[1] as i32);
    let mut sum = 0.0;
    for spacings in [NEAR_SPACINGS, FAR_SPACINGS] {
        let reach_px = (spacings * spacing_px).clamp(1.0, MAX_GAP_PX) as i32;
        for offset in [IVec2::NEG_X, IVec2::X, IVec2::NEG_Y, IVec2::Y] {
            let at = (here + reach_px * offset).clamp(IVec2::ZERO, input.size() - 1);
            let nearest = water.distance - 4.0 * model.spacing_world;
            let other = input.distance[input.index(at)].clamp(nearest, 2.0 * water.distance);
            let across = view_position(input.camera, at.as_vec2() + 0.5, other) - water.position_view;
            let rise = water.normal_view.dot(across) / across.length().max(1e-20);
            sum += (rise - 0.05).clamp(0.0, 1.0);
        }
    }
    (sum * 0.25).min(1.0)
}

/// Radiance and coverage of `pixel`.
pub(crate) fn shade_pixel(model: &GranularUniform, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4] {
    let index = input.pixel_index(pixel);
    let medium = MediumUniform { absorption: [0.0; 3], scattering: model.shadow_extinction };
    let dim = shadow(input, center_px(pixel), 0.0, &medium, 0.0, MAX_SHADOW);
    let scene = Vec4::from(input.scene_color[index]) * dim.extend(1.0);
    if !input.shows_water(index) {
        return scene.to_array();
    }
    let sky = &sky_at(input, pixel);
    let water = input.plain_water_point(pixel, index);
    let normal = to_world(input.camera, water.normal_view);
    let to_eye = to_world(input.camera, water.to_eye_view);
    let tint = input.tint(index);

    let wet = model.wetness * (1.0 - tint.w);
    let albedo = mix(model.color.into(), tint.truncate(), tint.w) * (1.0 + (WET_TONE - 1.0) * wet);
    let s2 = model.roughness * model.roughness;
    let a = 1.0 - 0.5 * s2 / (s2 + 0.33);
    let b = 0.45 * s2 / (s2 + 0.09);
    let sun = Vec3::from(sky.sun_direction);
    let n_l = normal.dot(sun).max(0.0);
    let across = sun.dot(to_eye) - n_l * water.n_v;
    let lobe = a + b * across / if across > 0.0 { n_l.max(water.n_v).max(1e-3) } else { 1.0 };
    let open = 1.0 - model.gaps * enclosed(model, input, pixel, &water);
    let light = ambient(sky, normal) + lobe.max(0.0) * n_l * Vec3::from(sky.sun_irradiance);
    let body = albedo / PI * open * light;

    let position = point_to_world(input.camera, water.position_view);
    let direction = mirrored(input.surroundings, normal, to_eye);
    let mirror = input.mirror_radiance(position, direction, FILM_ALPHA);
    let glint = sun_glint(sky, normal, to_eye, water.n_v, FILM_ALPHA, FILM_INDEX);
    let film = wet * open * fresnel_dielectric(water.n_v, FILM_INDEX);
    let color = mix(body, mirror, film) + wet * open * glint;
    over(scene, color, coverage(input.thickness[index], model.spacing_world))
}
