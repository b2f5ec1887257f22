// Sums, per tile, what tells how complex the surface is there: pixels beside edges, and how much the surface bends within a
// spacing. In integers, so that the order does not matter.
#import meniscus::tally::count
#import meniscus::covered::{CoveredPixels, unpack_pixel}
#import meniscus::camera::Camera
#import meniscus::key::{key_of, key_per_distance, is_gap}
#import meniscus::smoothing::sigma_in_px
#import meniscus::adaptive::{Adaptive, TILE, BEND_STEPS, MOST_BEND, tiles, half_px_in_tiles}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> adaptive: Adaptive;
@group(0) @binding(2) var front: texture_2d<f32>;
@group(0) @binding(3) var<storage, read> covered: CoveredPixels;
@group(0) @binding(4) var<storage, read_write> sums: array<TileSums>;

// Of a tile.
struct TileSums {
    // Measured pixels in the low, those beside an edge in the high 16 bits.
    pixels: atomic<u32>,
    bends: atomic<u32>,
}

// How far the middle lies off the line between samples `reach` to both sides, in keys; -1 beside a gap.
fn bend_along(pixel: vec2<i32>, stride: vec2<i32>, reach: i32, center: f32) -> f32 {
    let after = key_of(camera, textureLoad(front, pixel + reach * stride, 0).x);
    let before = key_of(camera, textureLoad(front, pixel - reach * stride, 0).x);
    if is_gap(after) || is_gap(before) {
        return -1.0;
    }
    return abs(0.5 * (after + before) - center);
}

// Gives the number of samples read besides the pixel's own.
fn measure(id: vec2<u32>) -> u32 {
    // Every other row and column, counted from the borders; pixels right between two tiles belong to none.
    let room = min(id, camera.size_px - 1u - id);
    let place = half_px_in_tiles(camera, id);
    if any((room & vec2(1u)) != vec2(0u)) || any(place % (2u * TILE) == vec2(0u)) {
        return 0u;
    }
    let pixel = vec2<i32>(id);
    let own = textureLoad(front, pixel, 0);
    let d = own.x;
    let r = own.y;
    let center = key_of(camera, d);
    let spacing_px = sigma_in_px(camera, adaptive.spacing_per_radius, d, r);
    if spacing_px <= 0.0 {
        return 0u;
    }
    let reach = min(vec2(max(i32(round(spacing_px)), 1)), vec2<i32>(room));
    let x = bend_along(pixel, vec2(1, 0), reach.x, center);
    let y = bend_along(pixel, vec2(0, 1), reach.y, center);
    let per_radius = max(r * key_per_distance(camera, center), 1e-30);
    let radii = max(x, y) / per_radius;
    let is_edge = min(x, y) < 0.0 || radii > adaptive.range_radii;
    let tile_at = place / (2u * TILE);
    let tile = tile_at.y * tiles(camera).x + tile_at.x;
    atomicAdd(&sums[tile].pixels, select(1u, 0x10001u, is_edge));
    if !is_edge {
        atomicAdd(&sums[tile].bends, u32(round(BEND_STEPS * min(radii, MOST_BEND))));
    }
    return 4u;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    var taps = 0u;
    let end = covered.count;
    for (var i = id.x; i < end; i += groups.x * 64u) {
        taps += measure(unpack_pixel(covered.packed[i]));
    }
    count(taps);
}
