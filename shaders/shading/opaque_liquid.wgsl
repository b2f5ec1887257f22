// Liquids that nothing is seen through, like milk or paint: a diffuse body, soft because light enters and leaves elsewhere,
// under a dielectric surface that mirrors the surroundings.

#define_import_path meniscus::model

#import meniscus::body::{COLOR_MIRROR, LEGEND_SOFTNESS, soft_irradiance}
#import meniscus::brdf::{PI, fresnel_dielectric}
#import meniscus::lighting_inputs::{camera, distance_at, thickness_at, scene_color, attribute_color, coverage, point_to_world, to_world}
#import meniscus::medium::Medium
#import meniscus::neighbourhood::neighbourhood
#import meniscus::reflection::{environment, mirrored, sun_glint}
#import meniscus::shadow::{shadow, sky_at}
#import meniscus::water::water_point

struct OpaqueLiquid {
    color: vec3<f32>,
    softness: f32,
    refractive_index: f32,
    // GGX alpha of the calm surface.
    alpha: f32,
    spacing_world: f32,
    // 1 / world unit.
    shadow_extinction: f32,
}

@group(0) @binding(2) var<uniform> model: OpaqueLiquid;

// Share of sunlight that the shadow takes: the rest comes around the body.
const MAX_SHADOW: f32 = 0.9;

// Where there is no water.
fn scene_radiance(pixel: vec2<u32>) -> vec4<f32> {
    let dim = shadow(vec2<f32>(pixel) + 0.5, 0.0, Medium(vec3(0.0), model.shadow_extinction), 0.0, MAX_SHADOW);
    return textureLoad(scene_color, pixel, 0) * vec4(dim, 1.0);
}

fn water_radiance(pixel: vec2<u32>) -> vec4<f32> {
    let scene = scene_radiance(pixel);
    let sky = sky_at(pixel);
    let distance = distance_at(pixel);
    let around = neighbourhood(pixel, distance, model.spacing_world);
    let water = water_point(camera, pixel, distance, around.normal_sum);
    let normal = to_world(water.normal_view);
    let to_eye = to_world(water.to_eye_view);
    let tint = attribute_color(pixel);

    let albedo = mix(model.color, tint.rgb, tint.a);
    let softness = mix(model.softness, LEGEND_SOFTNESS, tint.a);
    let body = albedo * soft_irradiance(sky, normal, softness) / PI;
    let alpha = min(sqrt(model.alpha * model.alpha + 0.5 * around.spread), 0.6);
    let facing = smoothstep(0.15, 0.5, water.n_v);
    let glint = facing * sun_glint(sky, normal, to_eye, water.n_v, alpha, model.refractive_index);
    let mirror = environment(point_to_world(water.position_view), mirrored(normal, to_eye), model.alpha);
    let cosine = min(sqrt(water.n_v * water.n_v + 0.2 * around.spread), 1.0);
    let left = mix(1.0, COLOR_MIRROR, tint.a);
    let color = mix(body, mirror, left * fresnel_dielectric(cosine, model.refractive_index)) + left * glint;
    return mix(scene, vec4(color, 1.0), coverage(thickness_at(pixel), model.spacing_world));
}
