// Clear liquid over the opaque scene (algorithms.md 10, recommended composite): exact Fresnel, refraction marched against the
// scene's distance, Beer-Lambert with single scattering along the marched path, reflected surroundings, the sun's GGX lobe.

#define_import_path meniscus::model

#import meniscus::body::{COLOR_MIRROR, irradiance, tinted}
#import meniscus::brdf::{PI, fresnel_dielectric}
#import meniscus::calm::calmed
#import meniscus::camera::px_per_world
#import meniscus::lighting_inputs::{camera, surroundings, distance_at, thickness_at, scene_color, attribute_color, coverage, point_to_world, to_world}
#import meniscus::medium::{Medium, transmitted}
#import meniscus::neighbourhood::{Neighbourhood, neighbourhood}
#ifdef OBJECTS
#import meniscus::reflected_objects::reflected_object
#endif
#import meniscus::reflection::{environment, mirrored, sun_glint}
#import meniscus::refraction::{Path, background_over, footprint_at_end, refracted_path}
#import meniscus::shadow::{shadow, sky_at}
#import meniscus::sky::Sky
#import meniscus::water::{WaterPoint, faced, water_point}

struct Fluid {
    medium: Medium,
    refractive_index: f32,
    refraction_scale: f32,
    additional_reflection: f32,
    // GGX alpha of the calm surface.
    alpha: f32,
    spray: f32,
    spacing_world: f32,
    // 1 / world unit: sunlight that the water bends away, on top of what it absorbs.
    shadow_extinction: f32,
    pad: f32,
}

@group(0) @binding(2) var<uniform> model: Fluid;

// Share of sunlight that the deepest shadow takes: waves focus as much light as they take away, and light comes in from all
// sides, so that a good part always arrives.
const MAX_SHADOW: f32 = 0.35;

// Single particles are spray when they are this small, and drops, with so much of the white left, from this size on; pixels.
const SPRAY_PX: f32 = 2.0;
const DROP_PX: f32 = 8.0;
const NEAR_SPRAY: f32 = 0.4;

// Share of diffuse light that a surface of water reflects back down.
const INTERNAL_REFLECTANCE: f32 = 0.48;
// How much of that is applied: a finite body of water lets light out at its sides.
const WET_SHARE: f32 = 0.7;

// How much darker the floor looks where the water at the end of the path wets it: light that it scatters is reflected back at
// the water's surface and meets it again (Lekner & Dorf 1988). Water ends at the floor only to within its
// resolution.
fn wet(path: Path) -> f32 {
    // Without colour: what comes back is tinted by the water, which the path accounts for.
    let albedo = dot(surroundings.floor.color, vec3(1.0 / 3.0));
    let ratio = (1.0 - INTERNAL_REFLECTANCE) / (1.0 - INTERNAL_REFLECTANCE * albedo);
    let near = model.spacing_world + 0.2 * path.length_world;
    // Soft where the water begins, so that the scallops of single particles do not show.
    let begin = smoothstep(0.0, 1.5 * model.spacing_world + 1e-30, path.length_world);
    let contact = WET_SHARE * begin * (1.0 - smoothstep(near, 2.0 * near + 1e-30, path.to_floor_world));
    return mix(1.0, ratio, contact);
}

// Radiance of a pixel that is all water, with `behind` at the end of a path of the given length.
fn shade(sky: Sky, water: WaterPoint, around: Neighbourhood, behind: vec3<f32>, path_world: f32, tint: vec4<f32>) -> vec3<f32> {
    let normal = to_world(water.normal_view);
    let to_eye = to_world(water.to_eye_view);
    let position = point_to_world(water.position_view);

    let clear = transmitted(model.medium, sky, normal, behind, path_world);
    let through = tinted(sky, clear, tint, normal);
    let direction = mirrored(normal, to_eye);
    var mirror = environment(position, direction, model.alpha);
#ifdef OBJECTS
    let object = reflected_object(water, direction, model.alpha);
    mirror = mix(mirror, object.rgb, object.a);
#endif

    // The variance of the normals widens the sun's lobe (Kaplanyan et al. 2016), so that noise does not become speckle. At
    // grazing view the lobe is fed by the rims of single particles: fade it.
    let drop = smoothstep(0.65, 1.0, around.isolation);
    let alpha = min(sqrt(model.alpha * model.alpha + (0.5 - 0.4 * drop) * around.spread), 0.6);
    let facing = smoothstep(0.15, 0.5, water.n_v);
    let glint = facing * sun_glint(sky, normal, to_eye, water.n_v, alpha, model.refractive_index);

    // Uncertain normals have a larger root mean square cosine: reflectance at edges is not that of a mirror seen edge on.
    let cosine = min(sqrt(water.n_v * water.n_v + 0.2 * around.spread), 1.0);
    let fresnel = mix(fresnel_dielectric(cosine, model.refractive_index), 1.0, model.additional_reflection);
    let left = mix(1.0, COLOR_MIRROR, tint.a);
    let surface = mix(through, mirror, left * fresnel) + left * glint;

    // Single particles stand for many small drops, which scatter like a white diffuser. From near by they are the drops.
    let spacing_px = model.spacing_world * px_per_world(camera, water.distance);
    let near = mix(1.0, NEAR_SPRAY, smoothstep(SPRAY_PX, DROP_PX, spacing_px));
    let white = model.spray * near * drop * (1.0 - tint.a);
    let diffuse = irradiance(sky, normal) + 0.3 * (1.0 - max(dot(normal, sky.sun_direction), 0.0)) * sky.sun_irradiance;
    return mix(surface, diffuse / PI, white);
}

// Where there is no water.
fn scene_radiance(pixel: vec2<u32>) -> vec4<f32> {
    let dim = shadow(vec2<f32>(pixel) + 0.5, 0.0, model.medium, model.shadow_extinction, MAX_SHADOW);
    return textureLoad(scene_color, pixel, 0) * vec4(dim, 1.0);
}

fn water_radiance(pixel: vec2<u32>) -> vec4<f32> {
    let scene = textureLoad(scene_color, pixel, 0);
    let thickness = thickness_at(pixel);
    let distance = distance_at(pixel);
    // The mean normal: differences between single pixels are mostly noise.
    let around = neighbourhood(pixel, distance, model.spacing_world);
    let water = water_point(camera, pixel, distance, around.normal_sum);
    let normals = calmed(pixel, water.normal_view, around.to_right, around.to_below);
    let calm = water_point(camera, pixel, distance, normals.own);
    let path = refracted_path(calm, thickness, model.refractive_index, model.refraction_scale, model.spacing_world);
    let right = faced(normals.right, calm.to_eye_view);
    let below = faced(normals.below, calm.to_eye_view);
    let footprint = footprint_at_end(calm, path, right, below, model.refractive_index, model.refraction_scale);
    let dim = shadow(path.end_px, path.length_world, model.medium, model.shadow_extinction, MAX_SHADOW);
    let behind = dim * wet(path) * background_over(path.end_px, footprint, path.nearest_distance, scene.rgb);
    let color = shade(sky_at(pixel), water, around, behind, path.length_world, attribute_color(pixel));
    return mix(scene * vec4(dim, 1.0), vec4(color, 1.0), coverage(thickness, model.spacing_world));
}
