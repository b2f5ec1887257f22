#define_import_path meniscus::lighting_inputs

#import meniscus::camera::Camera
#import meniscus::covered::CoveredPixels
#import meniscus::surface::{is_empty, unpack_normal}
#import meniscus::surroundings::Surroundings

// What lighting models read and write, under the names that `LightingInputs::bindings` gives it. Binding 2 is left for the
// model's own uniform, `model`.

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> surroundings: Surroundings;
@group(0) @binding(3) var distances: texture_2d<f32>;
@group(0) @binding(4) var thicknesses: texture_2d<f32>;
@group(0) @binding(5) var normals: texture_2d<u32>;
@group(0) @binding(6) var scene_color: texture_2d<f32>;
@group(0) @binding(7) var scene_distance: texture_2d<f32>;
// One value per block of pixels, or a single one: length of water that sunlight crosses to the scene (bits of a float), and
// `meniscus::sunlight` of how it is focused there and of the share that reaches the water.
@group(0) @binding(8) var sunlight: texture_2d<u32>;
@group(0) @binding(9) var radiance: texture_storage_2d<rgba16float, write>;
#ifdef COLORED
@group(0) @binding(10) var surface_colors: texture_2d<f32>;
#endif

// The pixels that may show water.
@group(0) @binding(12) var<storage, read> covered: CoveredPixels;

fn pixel_index(pixel: vec2<u32>) -> u32 {
    return pixel.y * camera.size_px.x + pixel.x;
}

// Distance of the water in a pixel; `NO_SURFACE` where there is none.
fn distance_at(pixel: vec2<u32>) -> f32 {
    return textureLoad(distances, pixel, 0).x;
}

// Length of water along the ray through a pixel up to the scene, world units.
fn thickness_at(pixel: vec2<u32>) -> f32 {
    return textureLoad(thicknesses, pixel, 0).x;
}

// Unit normal of the water in a pixel, view space.
fn normal_at(pixel: vec2<u32>) -> vec3<f32> {
    return unpack_normal(textureLoad(normals, pixel, 0).x);
}

// Whether the pixel shows water: there is some, in front of the scene.
fn shows_water(pixel: vec2<u32>) -> bool {
    let distance = distance_at(pixel);
    return distance > 0.0 && !is_empty(distance) && thickness_at(pixel) > 0.0 && distance < textureLoad(scene_distance, pixel, 0).x;
}

// Colour that an attribute gives the water; alpha is how much of the water's own it replaces.
fn attribute_color(pixel: vec2<u32>) -> vec4<f32> {
#ifdef COLORED
    return clamp(textureLoad(surface_colors, pixel, 0), vec4(0.0), vec4(1.0));
#else
    return vec4(0.0);
#endif
}

// Less water than a fraction of a particle is a soft edge, not a surface.
fn coverage(thickness: f32, spacing_world: f32) -> f32 {
    return smoothstep(0.0, max(0.5 * spacing_world, 1e-30), thickness);
}

fn to_world(direction_view: vec3<f32>) -> vec3<f32> {
    return (camera.world_from_view * vec4(direction_view, 0.0)).xyz;
}

fn point_to_world(position_view: vec3<f32>) -> vec3<f32> {
    return (camera.world_from_view * vec4(position_view, 1.0)).xyz;
}
