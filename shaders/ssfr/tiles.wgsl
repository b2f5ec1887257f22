// Lists the tiles that show fluid, and counts the pixels that do.
#import meniscus::camera::Camera
#import meniscus::covered::{TILE, pack_pixel}
#import meniscus::key::is_surface

// `CoveredTiles` while it is filled.
struct Filling {
    count: atomic<u32>,
    pixels: atomic<u32>,
    packed: array<u32>,
}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var front: texture_2d<f32>;
// Its counts are 0 before.
@group(0) @binding(2) var<storage, read_write> tiles: Filling;

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let first = TILE * id.xy;
    let end = min(first + TILE, camera.size_px);
    var pixels = 0u;
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            pixels += u32(is_surface(textureLoad(front, vec2(x, y), 0).x));
        }
    }
    if pixels > 0u {
        tiles.packed[atomicAdd(&tiles.count, 1u)] = pack_pixel(id.xy);
        atomicAdd(&tiles.pixels, pixels);
    }
}
