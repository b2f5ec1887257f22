// What the reduced thickness image needs to know of the full picture, block by block; empties the sums.
#import meniscus::camera::{Camera, px_per_world}
#import meniscus::thickness::Thickness
#import meniscus::surface::{NO_SURFACE, is_empty}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> thickness: Thickness;
@group(0) @binding(2) var scene_distance: texture_2d<f32>;
@group(0) @binding(3) var front: texture_2d<f32>;
@group(0) @binding(4) var reduced: texture_storage_2d<rgba32float, write>;
// Farthest the fluid is seen in a block.
@group(0) @binding(5) var<storage, read_write> limit: array<f32>;
@group(0) @binding(6) var<storage, read_write> sum: array<u32>;

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= thickness.size_px) {
        return;
    }
    let first = id.xy * thickness.scale;
    let end = min(first + thickness.scale, camera.size_px);
    var farthest = 0.0;
    var surface = NO_SURFACE;
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            farthest = max(farthest, textureLoad(scene_distance, vec2(x, y), 0).x);
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
                let is_open = is_fluid || textureLoad(scene_distance, vec2(x, y), 0).x > surface;
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
    limit[pixel] = farthest;
    sum[pixel] = 0u;
}
