// What becomes of the sun's light on its way to what the picture shows, one value per block of pixels: how much water it
// crosses to the opaque scene, how waves focus it there, and how much of it objects keep from the water.

#import meniscus::camera::{Camera, view_position}
#import meniscus::sun_view::{SunPoint, sun_camera, sun_point, sun_scene_distance}
#ifdef OBJECTS
#import meniscus::sun_view::sun_visibility
#endif
#import meniscus::sunlight::pack_light
#import meniscus::surface::is_empty

@group(0) @binding(0) var<uniform> camera: Camera;
#ifdef OBJECTS
@group(0) @binding(1) var distances: texture_2d<f32>;
#endif
@group(0) @binding(2) var scene_distance: texture_2d<f32>;
// As the sun sees the water.
@group(0) @binding(3) var sun_distances: texture_2d<f32>;
@group(0) @binding(4) var sun_thicknesses: texture_2d<f32>;
// 1 everywhere without caustics.
@group(0) @binding(5) var<storage, read> caustics: array<f32>;
@group(0) @binding(6) var sunlight: texture_storage_2d<rg32uint, write>;

const BLOCK_PX: u32 = 2u;

// Light on a point of the scene: length of water that it crosses, and how it is focused.
fn through_water(s: SunPoint) -> vec2<f32> {
    let corner = s.px - 0.5;
    let base = floor(corner);
    let f = corner - base;
    let width = i32(sun_camera.size_px.x);
    let weights = vec4((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);
    var sum = vec2(0.0);
    for (var k = 0; k < 4; k++) {
        let at = vec2<i32>(base) + vec2(k & 1, k >> 1u);
        let distance = textureLoad(sun_distances, at, 0).x;
        let below = select(s.distance - distance, 0.0, is_empty(distance));
        sum += weights[k] * vec2(clamp(below, 0.0, textureLoad(sun_thicknesses, at, 0).x), caustics[at.y * width + at.x]);
    }
    return sum;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size_blocks = (camera.size_px + BLOCK_PX - 1u) / BLOCK_PX;
    if any(id.xy >= size_blocks) {
        return;
    }
    let pixel = min(id.xy * BLOCK_PX + BLOCK_PX / 2u, camera.size_px - 1u);
    let px = vec2<f32>(pixel) + 0.5;
    var arriving = vec2(0.0, 1.0);
    var share = 1.0;

    let scene = textureLoad(scene_distance, pixel, 0).x;
    if !is_empty(scene) {
        let position = view_position(camera, px, scene);
        let s = sun_point((camera.world_from_view * vec4(position, 1.0)).xyz);
        // What an object hides is dark already. The distance of the scene is known to within what a pixel of the picture covers.
        let pixel_world = select(scene, 1.0, camera.orthographic != 0u) / camera.px_per_world_at_one;
        let slack = 4.0 * (pixel_world + 1.0 / sun_camera.px_per_world_at_one);
        if s.is_inside && s.distance <= textureLoad(sun_scene_distance, vec2<i32>(s.px), 0).x + slack {
            arriving = through_water(s);
        }
    }
#ifdef OBJECTS
    let water = textureLoad(distances, pixel, 0).x;
    if !is_empty(water) {
        let position = view_position(camera, px, water);
        let to_sun = sun_camera.world_from_view[2].xyz;
        share = sun_visibility((camera.world_from_view * vec4(position, 1.0)).xyz, to_sun);
    }
#endif
    textureStore(sunlight, id.xy, vec4(bitcast<u32>(arriving.x), pack_light(arriving.y, share), 0u, 0u));
}
