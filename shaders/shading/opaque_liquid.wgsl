// Liquids that nothing is seen through, like milk or paint: a diffuse body, soft because light enters and leaves elsewhere,
// under a dielectric surface that mirrors the surroundings.

#import meniscus::body::{COLOR_MIRROR, LEGEND_SOFTNESS, soft_irradiance}
#import meniscus::brdf::{PI, fresnel_dielectric}
#import meniscus::lighting_inputs::{camera, surroundings, distances, thicknesses, scene_color, radiance, attribute_color, coverage, pixel_index, point_to_world, shows_water, to_world}
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

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= camera.size_px) {
        return;
    }
    let index = pixel_index(id.xy);
    let here_px = vec2<f32>(id.xy) + 0.5;
    let dim = shadow(here_px, Medium(vec3(0.0), model.shadow_extinction), 0.0, MAX_SHADOW);
    let scene = textureLoad(scene_color, id.xy, 0) * vec4(dim, 1.0);
    if !shows_water(id.xy) {
        radiance[index] = scene;
        return;
    }
    let sky = sky_at(id.xy);
    let distance = distances[index];
    let around = neighbourhood(id.xy, distance, model.spacing_world);
    let water = water_point(camera, id.xy, distance, around.normal_sum);
    let normal = to_world(water.normal_view);
    let to_eye = to_world(water.to_eye_view);
    let tint = attribute_color(id.xy);

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
    radiance[index] = mix(scene, vec4(color, 1.0), coverage(thicknesses[index], model.spacing_world));
}
