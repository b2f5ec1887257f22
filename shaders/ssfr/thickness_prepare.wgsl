// What the reduced thickness image needs to know of the full picture, block by block; empties the sums. IN_FRONT: of water that
// nothing opaque cuts.
#import meniscus::camera::{Camera, px_per_world}
#import meniscus::thickness::Thickness
#import meniscus::surface::{NO_SURFACE, is_empty}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> thickness: Thickness;
#ifndef IN_FRONT
@group(0) @binding(2) var scene_distance: texture_2d<f32>;
// Farthest the fluid is seen in a block.
@group(0) @binding(5) var<storage, read_write> limit: array<f32>;
#endif
@group(0) @binding(3) var front: texture_2d<f32>;
@group(0) @binding(4) var reduced: texture_storage_2d<rgba32float, write>;
#ifdef PAIRS
@group(0) @binding(6) var<storage, read_write> sum: array<vec2<u32>>;
#else
@group(0) @binding(6) var<storage, read_write> sum: array<u32>;
#endif

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= thickness.size_px) {
        return;
    }
    let first = id.xy * thickness.scale;
    let end = min(first + thickness.scale, camera.size_px);
#ifndef IN_FRONT
    var farthest = 0.0;
#endif
    var surface = NO_SURFACE;
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
#ifndef IN_FRONT
            farthest = max(farthest, textureLoad(scene_distance, vec2(x, y), 0).x);
#endif
            surface = min(surface, textureLoad(front, vec2(x, y), 0).x);
        }
    }
    var fluid = 0.0;
    var open = 0.0;
    var widest = 0.0;
    if !is_empty(surface) {
        for (var y = first.y; y < end.y; y++) {
            for (var x = first.x; x < end.x; x++) {
                let own = textureLoad(front, vec2(x, y), 0);
                widest = max(widest, own.y);
                let is_fluid = !is_empty(own.x);
#ifdef IN_FRONT
                let is_open = true;
#else
                let is_open = is_fluid || textureLoad(scene_distance, vec2(x, y), 0).x > surface;
#endif
                fluid += f32(is_fluid);
                open += f32(is_open);
            }
        }
    }
    let spacing_px = widest * thickness.spacing_per_radius * px_per_world(camera, surface) / f32(thickness.scale);
    // As `block_of` reads it.
    let block = vec4(surface, fluid / max(open, 1.0), thickness.sigma_spacings * spacing_px, 0.0);
    textureStore(reduced, id.xy, block);
    let pixel = id.y * thickness.size_px.x + id.x;
#ifndef IN_FRONT
    limit[pixel] = farthest;
#endif
#ifdef PAIRS
    sum[pixel] = vec2(0u);
#else
    sum[pixel] = 0u;
#endif
}
