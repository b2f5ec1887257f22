//! Twin of `shaders/shading/foam.wgsl`.

use std::f32::consts::{LOG2_E, PI};

use glam::{IVec2, Vec3, Vec4};
use meniscus_gpu::role::FoamDrop;

use super::body::soft_irradiance;
use super::brdf::fresnel_dielectric;
use super::shadow::sky_at;
use super::view::{px_per_world, to_world, towards_eye, unpack_normal, view_position};
use super::water::center_px;
use super::{TwinInput, smoothstep};
use crate::FoamLook;

const ALBEDO: f32 = 0.92;
const SOFTNESS: f32 = 0.4;
const REFRACTIVE_INDEX: f32 = 1.333;
const STENCIL_SPACINGS: f32 = 0.6;
const MAX_STENCIL_PX: f32 = 8.0;

fn opacity(optical_depth: f32) -> f32 {
    1.0 - (-LOG2_E * optical_depth).exp2()
}

fn bend(look: &FoamLook, input: &TwinInput<'_>, pixel: IVec2, distance: f32) -> f32 {
    let stride_px = STENCIL_SPACINGS * look.spacing_world * px_per_world(input.camera, distance);
    let stride = stride_px.clamp(1.0, MAX_STENCIL_PX) as i32;
    let here = unpack_normal(input.normal[input.index(pixel)]);
    let sine = |offset: IVec2| {
        let at = input.clamped(pixel + offset);
        let is_same = (input.distance[at] - distance).abs() <= 2.0 * look.spacing_world;
        let cosine = if is_same { here.dot(unpack_normal(input.normal[at])) } else { 1.0 };
        (1.0 - cosine * cosine).max(0.0).sqrt()
    };
    0.5 * (sine(IVec2::X * stride) + sine(IVec2::Y * stride))
}

/// Radiance and coverage of `pixel`, which has `radiance` without foam, under `layers` of foam: optical depth in front, in the
/// surface, behind, and behind times depth in spacings, in [`FoamDrop::STEPS`].
pub fn foam(
    look: &FoamLook,
    input: &TwinInput<'_>,
    layers: [u32; 4],
    radiance: [f32; 4],
    pixel: [u32; 2],
) -> [f32; 4] {
    let (camera, sky) = (input.camera, &sky_at(input, pixel));
    let index = input.pixel_index(pixel);
    let per_step = 1.0 / FoamDrop::STEPS as f32;
    let [front, surface, behind, weighted] = layers.map(|steps| steps as f32 * per_step);
    let is_water = input.shows_water(index);
    let (distance, thickness) = (input.distance[index], input.thickness[index]);
    let mut on_surface = surface;
    if is_water && look.curvature > 0.0 {
        let bend = bend(look, input, IVec2::new(pixel[0] as i32, pixel[1] as i32), distance);
        let share = smoothstep(look.curvature_threshold, 2.0 * look.curvature_threshold, bend);
        on_surface += look.curvature * share * smoothstep(0.0, 2.0 * look.spacing_world, thickness);
    }
    if front + on_surface + behind <= 0.0 {
        return radiance;
    }
    let white = |normal: Vec3| ALBEDO / PI * soft_irradiance(sky, normal, SOFTNESS);
    let over = |color: Vec4, light: Vec3, opacity: f32| color * (1.0 - opacity) + light.extend(1.0) * opacity;
    let ray = towards_eye(camera, view_position(camera, center_px(pixel), 1.0));
    let cloud = to_world(camera, ray) + Vec3::from(sky.up);
    let cloud_light = white(cloud / cloud.length().max(1e-3));
    let mut color = Vec4::from(radiance);
    if is_water {
        let water = input.plain_water_point(pixel, index);
        let light = white(to_world(camera, water.normal_view));
        let depth = weighted / behind.max(per_step) * look.spacing_world;
        let path = (depth / water.to_eye_view.z.max(1e-3)).min(thickness);
        let share = opacity(behind) * (1.0 - fresnel_dielectric(water.n_v, REFRACTIVE_INDEX));
        let through = (-LOG2_E * Vec3::from(look.extinction) * path).map(f32::exp2);
        let rgb = color.truncate();
        color = (rgb + (light - rgb) * share * through).extend(color.w);
        color = over(color, light, opacity(on_surface));
    } else {
        color = over(color, cloud_light, opacity(on_surface + behind));
    }
    over(color, cloud_light, opacity(front)).to_array()
}
