// Foam over the lit picture, whatever lit it (algorithms.md 11): bubbles show through the water above them, foam lies on the surface
// and takes the place of what it reflects and lets through, spray is in front of everything. All scatter like a white diffuser.

#import meniscus::body::soft_irradiance
#import meniscus::brdf::{PI, fresnel_dielectric}
#import meniscus::camera::{px_per_world, towards_eye, view_position}
#import meniscus::lighting_inputs::{camera, distance_at, thickness_at, normal_at, radiance, pixel_index, shows_water, to_world}
#import meniscus::shadow::sky_at
#import meniscus::sky::Sky
#import meniscus::water::water_point

struct FoamLook {
    // 1 / world unit: what the water takes of light from bubbles.
    extinction: vec3<f32>,
    spacing_world: f32,
    // Optical depth of foam where the surface is bent sharply; 0: none.
    curvature: f32,
    // Sine of the angle between normals at which it begins.
    curvature_threshold: f32,
    pad_a: f32,
    pad_b: f32,
}

@group(0) @binding(2) var<uniform> model: FoamLook;
// Optical depth in front, in the surface, behind, and behind times depth in spacings, in steps.
@group(0) @binding(11) var<storage, read> foam_layers: array<vec4<u32>>;
// Without foam.
@group(0) @binding(13) var bare_radiance: texture_2d<f32>;

const PER_STEP: f32 = 1.0 / 4096.0;
// Share of light that foam scatters back.
const ALBEDO: f32 = 0.92;
// Light reaches around bubbles and drops.
const SOFTNESS: f32 = 0.4;
// Index of refraction of the surface over the bubbles.
const REFRACTIVE_INDEX: f32 = 1.333;
// Share of a spacing over which normals are compared; finer detail is not in the particles.
const STENCIL_SPACINGS: f32 = 0.6;
const MAX_STENCIL_PX: f32 = 8.0;

// Radiance of foam that faces `normal`.
fn white(sky: Sky, normal: vec3<f32>) -> vec3<f32> {
    return ALBEDO / PI * soft_irradiance(sky, normal, SOFTNESS);
}

// Share of light that foam of this optical depth stops.
fn opacity(optical_depth: f32) -> f32 {
    return 1.0 - exp2(-1.44269504 * optical_depth);
}

// Sine of the angle between this pixel's normal and the mean of those beside it, mean over both axes: [Z] 3.2,
// sin(acos(n.n_x)), where the neighbour lies on the same surface.
fn bend(pixel: vec2<u32>, distance: f32) -> f32 {
    let stride = i32(clamp(STENCIL_SPACINGS * model.spacing_world * px_per_world(camera, distance), 1.0, MAX_STENCIL_PX));
    let last = vec2<i32>(camera.size_px) - 1;
    let here = normal_at(pixel);
    let offsets = array(vec2(stride, 0), vec2(0, stride));
    var sum = 0.0;
    for (var k = 0; k < 2; k++) {
        let at = vec2<u32>(clamp(vec2<i32>(pixel) + offsets[k], vec2(0), last));
        let is_same = abs(distance_at(at) - distance) <= 2.0 * model.spacing_world;
        let cosine = select(1.0, dot(here, normal_at(at)), is_same);
        sum += 0.5 * sqrt(max(1.0 - cosine * cosine, 0.0));
    }
    return sum;
}

// Optical depth of foam at crests; none where the water is thinner than a particle.
fn crest(pixel: vec2<u32>, distance: f32) -> f32 {
    let share = smoothstep(model.curvature_threshold, 2.0 * model.curvature_threshold, bend(pixel, distance));
    return model.curvature * share * smoothstep(0.0, 2.0 * model.spacing_world, thickness_at(pixel));
}

// `lit` under foam of these optical depths: in front, in the surface, behind, and behind times depth in spacings.
fn composed(pixel: vec2<u32>, layers: vec4<f32>, lit: vec4<f32>) -> vec4<f32> {
    let ray = towards_eye(camera, view_position(camera, vec2<f32>(pixel) + 0.5, 1.0));
    let sky = sky_at(pixel);
    let cloud = to_world(ray) + sky.up;
    let cloud_light = white(sky, cloud / max(length(cloud), 1e-3));
    var color = lit;
    if shows_water(pixel) {
        let water = water_point(camera, pixel, distance_at(pixel), normal_at(pixel));
        let light = white(sky, to_world(water.normal_view));
        // Along the ray, but no further than there is water.
        let depth = layers.w / max(layers.z, PER_STEP) * model.spacing_world;
        let path = min(depth / max(water.to_eye_view.z, 1e-3), thickness_at(pixel));
        let through = exp2(-1.44269504 * model.extinction * path) * (1.0 - fresnel_dielectric(water.n_v, REFRACTIVE_INDEX));
        color = vec4(mix(color.rgb, light, opacity(layers.z) * through), color.a);
        color = mix(color, vec4(light, 1.0), opacity(layers.y));
    } else {
        // Water too thin to be seen hides no bubbles.
        color = mix(color, vec4(cloud_light, 1.0), opacity(layers.y + layers.z));
    }
    return mix(color, vec4(cloud_light, 1.0), opacity(layers.x));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= camera.size_px) {
        return;
    }
    let index = pixel_index(id.xy);
    var layers = vec4<f32>(foam_layers[index]) * PER_STEP;
    if model.curvature > 0.0 && shows_water(id.xy) {
        layers.y += crest(id.xy, distance_at(id.xy));
    }
    var color = textureLoad(bare_radiance, id.xy, 0);
    if layers.x + layers.y + layers.z > 0.0 {
        color = composed(id.xy, layers, color);
    }
    textureStore(radiance, id.xy, color);
}
