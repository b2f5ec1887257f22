// The complexity of every pixel from that of its tile and the next ones: 0 = simple, 1 = complex. Blended between the middles
// of tiles, whose borders would show.
#import meniscus::covered::{CoveredPixels, unpack_pixel}
#import meniscus::camera::Camera
#import meniscus::adaptive::{Adaptive, TILE, BEND_STEPS, tiles, half_px_in_tiles}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> adaptive: Adaptive;
@group(0) @binding(2) var<storage, read> covered: CoveredPixels;
// Per tile: measured pixels in the low, those beside an edge in the high 16 bits; bends.
@group(0) @binding(3) var<storage, read> sums: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read_write> complexity: array<f32>;

// Of a tile in which something was measured.
fn complexity_of(tile: u32) -> f32 {
    let measured = f32(sums[tile].x & 0xffffu);
    let edges = f32(sums[tile].x >> 16u);
    let bend = f32(sums[tile].y) / BEND_STEPS / max(measured - edges, 1.0);
    let reached = max(edges / measured / adaptive.edges, bend / adaptive.bend);
    return clamp(2.0 * reached - 1.0, 0.0, 1.0);
}

fn blend(id: vec2<u32>) {
    let at = vec2<f32>(half_px_in_tiles(camera, id)) / f32(2u * TILE) - 0.5;
    let first = floor(at);
    let last = vec2<f32>(tiles(camera)) - 1.0;
    var total = 0.0;
    var weights = 0.0;
    for (var corner = 0u; corner < 4u; corner++) {
        let tile_at = first + vec2(f32(corner & 1u), f32(corner >> 1u));
        let overlap = 1.0 - abs(at - tile_at);
        let inside = vec2<u32>(clamp(tile_at, vec2(0.0), last));
        let tile = inside.y * tiles(camera).x + inside.x;
        if (sums[tile].x & 0xffffu) > 0u {
            total += overlap.x * overlap.y * complexity_of(tile);
            weights += overlap.x * overlap.y;
        }
    }
    // Water so thin that none of it was measured is all edge.
    complexity[id.y * camera.size_px.x + id.x] = select(1.0, total / max(weights, 1e-6), weights > 1e-6);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let end = covered.count;
    for (var i = id.x; i < end; i += groups.x * 64u) {
        blend(unpack_pixel(covered.packed[i]));
    }
}
