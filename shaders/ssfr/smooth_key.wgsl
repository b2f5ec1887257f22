// Distances to keys, on which the smoothing passes work; with PAPER they are the distances themselves. Gaps, and what is no distance, are
// there already. Lists the tiles that show fluid.
#import meniscus::camera::Camera
#import meniscus::covered::{Filling, pack_pixel}
#import meniscus::key::{key_of, is_surface}
#import meniscus::smoothing::TILE

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var front: texture_2d<f32>;
@group(0) @binding(2) var key: texture_storage_2d<r32float, write>;
@group(0) @binding(3) var<storage, read_write> tiles: Filling;

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let first = TILE * id.xy;
    if any(first >= camera.size_px) {
        return;
    }
    let end = min(first + TILE, camera.size_px);
    var shows = false;
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            let pixel = vec2(x, y);
            let distance = textureLoad(front, pixel, 0).x;
            if is_surface(distance) {
                shows = true;
#ifdef PAPER
                textureStore(key, pixel, vec4(distance));
#else
                textureStore(key, pixel, vec4(key_of(camera, distance)));
#endif
            }
        }
    }
    if shows {
        tiles.packed[atomicAdd(&tiles.count, 1u)] = pack_pixel(id.xy);
    }
}
