//! Twin of `shaders/shading/fluid.wgsl`.

use std::f32::consts::PI;

use glam::{Vec3, Vec4};

use super::body::{COLOR_MIRROR, irradiance, tinted};
use super::brdf::fresnel_dielectric;
use super::calm::calmed;
use super::medium::transmitted;
use super::neighbourhood::{Neighbourhood, neighbourhood};
use super::reflected_objects::reflected_object;
use super::reflection::{mirrored, sun_glint};
use super::refraction::{Path, background, refracted_path};
use super::shadow::{shadow, sky_at};
use super::view::{point_to_world, px_per_world, to_world};
use super::water::{WaterPoint, center_px, coverage, over, water_point};
use super::{TwinInput, mix, smoothstep};
use crate::SkyUniform;
use crate::models::FluidUniform;

const MAX_SHADOW: f32 = 0.35;
const SPRAY_PX: f32 = 2.0;
const DROP_PX: f32 = 8.0;
const NEAR_SPRAY: f32 = 0.4;
const INTERNAL_REFLECTANCE: f32 = 0.48;
const WET_SHARE: f32 = 0.7;

fn wet(fluid: &FluidUniform, input: &TwinInput<'_>, path: &Path) -> f32 {
    let albedo = Vec3::from(input.surroundings.floor.color).element_sum() / 3.0;
    let ratio = (1.0 - INTERNAL_REFLECTANCE) / (1.0 - INTERNAL_REFLECTANCE * albedo);
    let near = fluid.spacing_world + 0.2 * path.length_world;
    let begin = smoothstep(0.0, 1.5 * fluid.spacing_world + 1e-30, path.length_world);
    let contact = WET_SHARE * begin * (1.0 - smoothstep(near, 2.0 * near + 1e-30, path.to_floor_world));
    1.0 - contact + ratio * contact
}

#[expect(clippy::too_many_arguments, reason = "as many as the shader's, and what that has as globals")]
fn shade(
    fluid: &FluidUniform,
    input: &TwinInput<'_>,
    sky: &SkyUniform,
    water: &WaterPoint,
    around: &Neighbourhood,
    behind: Vec3,
    path_world: f32,
    tint: Vec4,
) -> Vec3 {
    let camera = input.camera;
    let normal = to_world(camera, water.normal_view);
    let to_eye = to_world(camera, water.to_eye_view);
    let position = point_to_world(camera, water.position_view);

    let clear = transmitted(&fluid.medium, sky, normal, behind, path_world);
    let through = tinted(sky, clear, tint, normal);
    let direction = mirrored(input.surroundings, normal, to_eye);
    let object = reflected_object(input, water, direction, fluid.alpha);
    let mirror = mix(input.mirror_radiance(position, direction, fluid.alpha), object.truncate(), object.w);

    let drop = smoothstep(0.65, 1.0, around.isolation);
    let alpha = (fluid.alpha * fluid.alpha + (0.5 - 0.4 * drop) * around.spread).sqrt().min(0.6);
    let facing = smoothstep(0.15, 0.5, water.n_v);
    let glint = facing * sun_glint(sky, normal, to_eye, water.n_v, alpha, fluid.refractive_index);

    let cosine = (water.n_v * water.n_v + 0.2 * around.spread).sqrt().min(1.0);
    let reflectance = fresnel_dielectric(cosine, fluid.refractive_index);
    let reflectance = reflectance + (1.0 - reflectance) * fluid.additional_reflection;
    let left = 1.0 + (COLOR_MIRROR - 1.0) * tint.w;
    let surface = mix(through, mirror, left * reflectance) + left * glint;

    let spacing_px = fluid.spacing_world * px_per_world(camera, water.distance);
    let near = 1.0 + (NEAR_SPRAY - 1.0) * smoothstep(SPRAY_PX, DROP_PX, spacing_px);
    let white = fluid.spray * near * drop * (1.0 - tint.w);
    let n_l = normal.dot(sky.sun_direction.into()).max(0.0);
    let diffuse = irradiance(sky, normal) + 0.3 * (1.0 - n_l) * Vec3::from(sky.sun_irradiance);
    mix(surface, diffuse / PI, white)
}

/// Radiance and coverage of `pixel`.
pub(crate) fn shade_pixel(fluid: &FluidUniform, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4] {
    let index = input.pixel_index(pixel);
    let shadow = |px, through| shadow(input, px, through, &fluid.medium, fluid.shadow_extinction, MAX_SHADOW);
    let scene = Vec4::from(input.scene_color[index]);
    if !input.shows_water(index) {
        return (scene * shadow(center_px(pixel), 0.0).extend(1.0)).to_array();
    }
    let (distance, thickness) = (input.distance[index], input.thickness[index]);
    let around = neighbourhood(input, pixel, distance, fluid.spacing_world);
    let water = water_point(input, pixel, distance, around.normal_sum);
    let calm =
        water_point(input, pixel, distance, calmed(input, pixel, water.normal_view, fluid.spacing_world));
    let path = refracted_path(
        input,
        &calm,
        thickness,
        fluid.refractive_index,
        fluid.refraction_scale,
        fluid.spacing_world,
    );
    let dim = shadow(path.end_px, path.length_world);
    let behind = background(input, path.end_px, path.nearest_distance, scene.truncate());
    let behind = dim * wet(fluid, input, &path) * behind;
    let sky = &sky_at(input, pixel);
    let color = shade(fluid, input, sky, &water, &around, behind, path.length_world, input.tint(index));
    over(scene * dim.extend(1.0), color, coverage(thickness, fluid.spacing_world))
}
