// The model of Wang et al. 2012 (3.1, equation 21) with a light near the water:
// C = a (1 - R) + b R + I R cos i + I R cos^n theta, where a is the refracted and b the reflected light, and R the Fresnel
// reflectance at the angle i at which the light arrives.

#define_import_path meniscus::model

#import meniscus::body::{COLOR_MIRROR, tinted}
#import meniscus::brdf::fresnel_dielectric
#import meniscus::lighting_inputs::{camera, distance_at, thickness_at, scene_color, attribute_color, coverage, point_to_world, to_world}
#import meniscus::medium::{Medium, transmitted}
#import meniscus::neighbourhood::neighbourhood
#import meniscus::reflection::{environment, mirrored}
#import meniscus::refraction::{background_over, footprint_at_end, refracted_path}
#import meniscus::shadow::{shadow, sky_at}
#import meniscus::water::{faced, water_point}

struct PointLight {
    medium: Medium,
    light_position_world: vec3<f32>,
    // Between the light and the centre of the data on the floor.
    light_distance_world: f32,
    // Radiance of a white diffuser that faces the light at that distance.
    intensity: vec3<f32>,
    shininess: f32,
    refractive_index: f32,
    refraction_scale: f32,
    spacing_world: f32,
    // 1 / world unit.
    shadow_extinction: f32,
}

@group(0) @binding(2) var<uniform> model: PointLight;

const MAX_SHADOW: f32 = 0.55;
// Where the light only grazes the water or does not reach it, its reflectance would go to 1 and the shaded side become a mirror.
const MIN_INCIDENCE: f32 = 0.2;
// Nearer to the light than this share of its distance, water gets no brighter.
const MIN_NEARNESS: f32 = 0.25;

// Where there is no water.
fn scene_radiance(pixel: vec2<u32>) -> vec4<f32> {
    let dim = shadow(vec2<f32>(pixel) + 0.5, 0.0, model.medium, model.shadow_extinction, MAX_SHADOW);
    return textureLoad(scene_color, pixel, 0) * vec4(dim, 1.0);
}

fn water_radiance(pixel: vec2<u32>) -> vec4<f32> {
    let scene = textureLoad(scene_color, pixel, 0);
    let sky = sky_at(pixel);
    let distance = distance_at(pixel);
    let around = neighbourhood(pixel, distance, model.spacing_world);
    let water = water_point(camera, pixel, distance, around.normal_sum);
    let normal = to_world(water.normal_view);
    let to_eye = to_world(water.to_eye_view);
    let position = point_to_world(water.position_view);
    let tint = attribute_color(pixel);

    let to_light = model.light_position_world - position;
    let nearness = max(length(to_light) / model.light_distance_world, MIN_NEARNESS);
    let light = to_light / max(length(to_light), 1e-30);
    let cos_i = max(dot(normal, light), 0.0);
    let intensity = model.intensity / (nearness * nearness);
    let reflectance = fresnel_dielectric(max(cos_i, MIN_INCIDENCE), model.refractive_index);
    let theta = max(dot(reflect(-light, normal), to_eye), 0.0);
    // No highlight on what is turned away.
    let highlight = select(0.0, pow(theta, model.shininess), cos_i > 0.0);

    let path = refracted_path(water, thickness_at(pixel), model.refractive_index, model.refraction_scale, model.spacing_world);
    let right = faced(water.normal_view + around.to_right, water.to_eye_view);
    let below = faced(water.normal_view + around.to_below, water.to_eye_view);
    let footprint = footprint_at_end(water, path, right, below, model.refractive_index, model.refraction_scale);
    let dim = shadow(path.end_px, path.length_world, model.medium, model.shadow_extinction, MAX_SHADOW);
    let behind = dim * background_over(path.end_px, footprint, path.nearest_distance, scene.rgb);
    let refracted = tinted(sky, transmitted(model.medium, sky, normal, behind, path.length_world), tint, normal);
    let mirror = environment(position, mirrored(normal, to_eye), 0.0);
    let left = reflectance * mix(1.0, COLOR_MIRROR, tint.a);
    let color = mix(refracted, mirror, left) + intensity * left * (cos_i + highlight);
    return mix(scene * vec4(dim, 1.0), vec4(color, 1.0), coverage(thickness_at(pixel), model.spacing_world));
}
