// The last pass of the narrow-range filter: a small one in two dimensions that removes the streaks of the passes along
// rows and columns (algorithms.md 3.5). From keys to distances.
#import meniscus::tally::count
#import meniscus::covered::{CoveredPixels, unpack_pixel}
#import meniscus::camera::Camera
#import meniscus::key::{distance_of, key_of, key_per_distance, smaller_step}
#import meniscus::narrow_range::{NarrowRange, sigmas, clamp_behind, keep_in_front, LEAST_SIGMA_PX}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> narrow: NarrowRange;
@group(0) @binding(2) var<storage, read> radius: array<f32>;
// Distances before any pass; keys before this one.
@group(0) @binding(3) var<storage, read> unfiltered: array<f32>;
@group(0) @binding(4) var<storage, read> source: array<f32>;
@group(0) @binding(5) var<storage, read_write> distance: array<f32>;
@group(0) @binding(6) var<storage, read> covered: CoveredPixels;

// What the pixel's range makes of its pairs.
struct Pairs {
    center: f32,
    range: f32,
    clamped: f32,
    total: f32,
    weights: f32,
}

fn add(pairs: ptr<function, Pairs>, after_key: f32, before_key: f32, rise: f32, weight: f32) {
    let after = after_key - (*pairs).center - rise;
    let before = before_key - (*pairs).center + rise;
    let w = weight * keep_in_front(max(after, before), (*pairs).range);
    let a = clamp_behind(after, (*pairs).range, (*pairs).clamped);
    let b = clamp_behind(before, (*pairs).range, (*pairs).clamped);
    (*pairs).total += w * (a + b);
    (*pairs).weights += 2.0 * w;
}

// Gives the number of samples read besides the pixel's own.
fn clean_pixel(id: vec2<u32>) -> u32 {
    let width = i32(camera.size_px.x);
    let pixel = i32(id.y) * width + i32(id.x);
    let center = source[pixel];
    let d = distance_of(camera, center);
    distance[pixel] = d;
    let room = min(id, camera.size_px - 1u - id);
    if min(room.x, room.y) < 2u {
        return 0u;
    }
    let r = radius[pixel];
    let sigma_px = sigmas(camera, narrow, d, r).clean_px;
    if sigma_px < LEAST_SIGMA_PX {
        return 0u;
    }
    // Weights at distances whose squares are 1, 2, 4, 5 and 8.
    let w1 = exp(-0.5 / (sigma_px * sigma_px));
    let w2 = w1 * w1;
    let w4 = w2 * w2;
    let w5 = w4 * w1;
    let w8 = w4 * w4;
    let left = source[pixel - 1];
    let right = source[pixel + 1];
    let above = source[pixel - width];
    let below = source[pixel + width];
    let gx = smaller_step(right, center, left);
    let gy = smaller_step(below, center, above);
    let per_radius = r * key_per_distance(camera, center);
    let clamped = key_of(camera, unfiltered[pixel]) - narrow.clamp_radii * per_radius - center;
    var pairs = Pairs(center, max(narrow.range_radii * per_radius, 1e-30), clamped, 0.0, 1.0);
    add(&pairs, right, left, gx, w1);
    add(&pairs, below, above, gy, w1);
    add(&pairs, source[pixel + 1 + width], source[pixel - 1 - width], gx + gy, w2);
    add(&pairs, source[pixel + 1 - width], source[pixel - 1 + width], gx - gy, w2);
    add(&pairs, source[pixel + 2], source[pixel - 2], 2.0 * gx, w4);
    add(&pairs, source[pixel + 2 * width], source[pixel - 2 * width], 2.0 * gy, w4);
    add(&pairs, source[pixel + 2 + width], source[pixel - 2 - width], 2.0 * gx + gy, w5);
    add(&pairs, source[pixel + 2 - width], source[pixel - 2 + width], 2.0 * gx - gy, w5);
    add(&pairs, source[pixel + 1 + 2 * width], source[pixel - 1 - 2 * width], gx + 2.0 * gy, w5);
    add(&pairs, source[pixel + 1 - 2 * width], source[pixel - 1 + 2 * width], gx - 2.0 * gy, w5);
    add(&pairs, source[pixel + 2 + 2 * width], source[pixel - 2 - 2 * width], 2.0 * (gx + gy), w8);
    add(&pairs, source[pixel + 2 - 2 * width], source[pixel - 2 + 2 * width], 2.0 * (gx - gy), w8);
    let last = key_of(camera, d + narrow.range_radii * r);
    distance[pixel] = distance_of(camera, max(center + pairs.total / pairs.weights, last));
    return 24u;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    var taps = 0u;
    for (var i = id.x; i < covered.count; i += groups.x * 64u) {
        taps += clean_pixel(unpack_pixel(covered.packed[i]));
    }
    count(taps);
}
