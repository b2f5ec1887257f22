// Sand, gravel, debris: a rough diffuse body (Oren & Nayar 1994, in the closed form of Fujii), dark in the gaps between
// grains, with a film of water if it is wet.

#define_import_path meniscus::model

#import meniscus::body::ambient
#import meniscus::brdf::{PI, fresnel_dielectric}
#import meniscus::camera::{px_per_world, view_position}
#import meniscus::lighting_inputs::{camera, distance_at, thickness_at, normal_at, scene_color, attribute_color, coverage, point_to_world, to_world}
#import meniscus::medium::Medium
#import meniscus::reflection::{environment, mirrored, sun_glint}
#import meniscus::shadow::{shadow, sky_at}
#import meniscus::water::{WaterPoint, water_point}

struct Granular {
    color: vec3<f32>,
    // 1: rough as dry sand, 0: Lambert's law.
    roughness: f32,
    gaps: f32,
    wetness: f32,
    spacing_world: f32,
    // 1 / world unit.
    shadow_extinction: f32,
}

@group(0) @binding(2) var<uniform> model: Granular;

const MAX_SHADOW: f32 = 0.9;
const FILM_INDEX: f32 = 1.333;
const FILM_ALPHA: f32 = 0.12;
// How much darker wet grains are (Lekner & Dorf 1988).
const WET_TONE: f32 = 0.55;

// How far around the gaps between grains are looked for.
const NEAR_SPACINGS: f32 = 0.8;
const FAR_SPACINGS: f32 = 2.2;
const MAX_GAP_PX: f32 = 48.0;

// How far what is around stands above the surface, 0 to 1.
fn enclosed(pixel: vec2<u32>, water: WaterPoint) -> f32 {
    let spacing_px = model.spacing_world * px_per_world(camera, water.distance);
    let last = vec2<i32>(camera.size_px) - 1;
    let offsets = array(vec2(-1, 0), vec2(1, 0), vec2(0, -1), vec2(0, 1));
    var sum = 0.0;
    for (var k = 0; k < 8; k++) {
        let spacings = select(NEAR_SPACINGS, FAR_SPACINGS, k > 3);
        let reach_px = i32(clamp(spacings * spacing_px, 1.0, MAX_GAP_PX));
        let at = vec2<u32>(clamp(vec2<i32>(pixel) + reach_px * offsets[k & 3], vec2(0), last));
        // What is not there, or far in front, does not enclose.
        let other = clamp(distance_at(at), water.distance - 4.0 * model.spacing_world, 2.0 * water.distance);
        let across = view_position(camera, vec2<f32>(at) + 0.5, other) - water.position_view;
        sum += clamp(dot(water.normal_view, across) / max(length(across), 1e-20) - 0.05, 0.0, 1.0);
    }
    return min(sum * 0.25, 1.0);
}

// Where there is no water.
fn scene_radiance(pixel: vec2<u32>) -> vec4<f32> {
    let dim = shadow(vec2<f32>(pixel) + 0.5, 0.0, Medium(vec3(0.0), model.shadow_extinction), 0.0, MAX_SHADOW);
    return textureLoad(scene_color, pixel, 0) * vec4(dim, 1.0);
}

fn water_radiance(pixel: vec2<u32>) -> vec4<f32> {
    let scene = scene_radiance(pixel);
    let sky = sky_at(pixel);
    let water = water_point(camera, pixel, distance_at(pixel), normal_at(pixel));
    let normal = to_world(water.normal_view);
    let to_eye = to_world(water.to_eye_view);
    let tint = attribute_color(pixel);

    let base = mix(model.color, tint.rgb, tint.a);
    let wet = model.wetness * (1.0 - tint.a);
    let albedo = base * mix(1.0, WET_TONE, wet);
    let s2 = model.roughness * model.roughness;
    let a = 1.0 - 0.5 * s2 / (s2 + 0.33);
    let b = 0.45 * s2 / (s2 + 0.09);
    let n_l = max(dot(normal, sky.sun_direction), 0.0);
    let across = dot(sky.sun_direction, to_eye) - n_l * water.n_v;
    let lobe = a + b * across / select(1.0, max(max(n_l, water.n_v), 1e-3), across > 0.0);
    let open = 1.0 - model.gaps * enclosed(pixel, water);
    let body = albedo / PI * open * (ambient(sky, normal) + max(lobe, 0.0) * n_l * sky.sun_irradiance);

    let mirror = environment(point_to_world(water.position_view), mirrored(normal, to_eye), FILM_ALPHA);
    let glint = sun_glint(sky, normal, to_eye, water.n_v, FILM_ALPHA, FILM_INDEX);
    let film = wet * open * fresnel_dielectric(water.n_v, FILM_INDEX);
    let color = mix(body, mirror, film) + wet * open * glint;
    return mix(scene, vec4(color, 1.0), coverage(thickness_at(pixel), model.spacing_world));
}
