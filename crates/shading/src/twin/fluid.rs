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
use super::refraction::{Footprint, Path, background_over, footprint_at_end, refracted_path};
use super::shadow::{shadow, sky_at};
use super::view::{point_to_world, px_per_world, to_world};
use super::water::{WaterPoint, center_px, coverage, faced, over, water_point};
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

/// The path of what is seen through the water, and what the pixel covers at its end.
fn seen_through(
    fluid: &FluidUniform,
    input: &TwinInput<'_>,
    pixel: [u32; 2],
    water: &WaterPoint,
    around: &Neighbourhood,
) -> (Path, Footprint) {
    let changes = [around.to_right, around.to_below];
    let normals = calmed(input, pixel, water.normal_view, changes, fluid.spacing_world);
    let calm = water_point(input, pixel, water.distance, normals.own);
    let thickness = input.thickness[input.pixel_index(pixel)];
    let (index, scale) = (fluid.refractive_index, fluid.refraction_scale);
    let path = refracted_path(input, &calm, thickness, index, scale, fluid.spacing_world);
    let beside = [normals.right, normals.below].map(|normal| faced(normal, calm.to_eye_view));
    let footprint = footprint_at_end(input, &calm, &path, beside, index, scale);
    (path, footprint)
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
    let (path, footprint) = seen_through(fluid, input, pixel, &water, &around);
    let dim = shadow(path.end_px, path.length_world);
    let behind = background_over(input, path.end_px, &footprint, path.nearest_distance, scene.truncate());
    let behind = dim * wet(fluid, input, &path) * behind;
    let sky = &sky_at(input, pixel);
    let color = shade(fluid, input, sky, &water, &around, behind, path.length_world, input.tint(index));
    over(scene * dim.extend(1.0), color, coverage(thickness, fluid.spacing_world))
}

#[cfg(test)]
mod tests {
    use glam::Vec2;
    use meniscus_core::{Aabb, Camera, UpAxis};
    use meniscus_gpu::CameraUniform;
    use meniscus_scene::Scene;

    use super::*;
    use crate::conformance::{Frame, cast};
    use crate::{FluidParameters, Formula, Surroundings};

    /// What a pixel covers is as long as the ends of its path and its neighbours' paths lie apart.
    #[test]
    fn footprints_reach_from_path_to_path() {
        let size = [160, 160];
        let bounds = Aabb { min: Vec3::splat(-0.1), max: Vec3::new(1.1, 0.8, 1.1) };
        let camera = Camera::fit(&bounds.corners(), Vec3::new(-0.4, -0.6, -0.8), Vec3::Y, 0.8, size, 0.9);
        // Waves of thirty spacings, which calm normals keep, steep enough to gather what lies below from several pixels into one.
        let k = std::f32::consts::TAU / 1.5;
        let wave = |p: Vec3| 0.7 * (p.y - 0.5 - 0.12 * (k * p.x).sin() * (k * p.z).cos());
        let water = cast(&CameraUniform::new(&camera, size), bounds, 0.01, wave);
        let mut scene = Scene::around(bounds, UpAxis::Y, 0.0);
        scene.floor = None;
        let mut frame = Frame::plain(&camera, size, &scene, water, [1.0; 4], 1e3);
        // How the thickness changes is left out of footprints.
        frame.water.thickness.fill(0.5);
        let fluid = FluidParameters::default().uniform(frame.scale, &Surroundings::new(&scene));
        // Where the path ends, and the longer side of the footprint.
        let found = frame.on_host(|input, pixel| {
            let index = input.pixel_index(pixel);
            if !input.shows_water(index) {
                return [f32::NAN; 4];
            }
            let around = neighbourhood(input, pixel, input.distance[index], fluid.spacing_world);
            let water = water_point(input, pixel, input.distance[index], around.normal_sum);
            let (path, footprint) = seen_through(&fluid, input, pixel, &water, &around);
            [path.end_px.x, path.end_px.y, footprint.along.length(), 0.0]
        });
        let end = |i: usize| Vec2::new(found[i][0], found[i][1]);
        let width = size[0] as usize;
        let mut ratios = Vec::new();
        for i in (0..found.len() - width).filter(|i| (i % width) + 1 < width) {
            let longer = (end(i + 1) - end(i)).length().max((end(i + width) - end(i)).length());
            // Farther apart they are of two waves, one behind the other.
            if (1.5..30.0).contains(&longer) {
                ratios.push(found[i][2] / longer);
            }
        }
        assert!(ratios.len() > 1000, "{}", ratios.len());
        ratios.sort_by(f32::total_cmp);
        let [low, median, high] = [1, 5, 9].map(|tenths| ratios[ratios.len() * tenths / 10]);
        // From differences over a stencil, and to the same pixel of the next one: a tenth in the middle, a third for the most part.
        assert!((median - 1.0).abs() < 0.1 && low > 0.67 && high < 1.33, "{low} {median} {high}");
    }
}
