// The last pass of a smoothing filter: a small one in two dimensions that removes the streaks of the passes along rows and
// columns (algorithms.md 3.5). From keys to distances.
#import meniscus::tally::count
#import meniscus::covered::{CoveredPixels, unpack_pixel}
#import meniscus::camera::Camera
#import meniscus::key::{distance_of, smaller_step}
#import meniscus::smoothing::{Smoothing, sigmas, LEAST_SIGMA_PX}
#import meniscus::rule::{Rule, Pair, rule_at, pair, smoothed_key}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> smoothing: Smoothing;
@group(0) @binding(2) var<storage, read> radius: array<f32>;
// Distances before any pass; keys before this one.
@group(0) @binding(3) var<storage, read> unfiltered: array<f32>;
@group(0) @binding(4) var<storage, read> source: array<f32>;
// With ADAPTIVE it holds the complexity until this pass writes it.
@group(0) @binding(5) var<storage, read_write> distance: array<f32>;
@group(0) @binding(6) var<storage, read> covered: CoveredPixels;

fn add(sum: ptr<function, Pair>, rule: Rule, after: f32, before: f32, rise: f32, weight: f32) {
    let added = pair(rule, after - rule.center - rise, before - rule.center + rise);
    (*sum).total += weight * added.total;
    (*sum).weight += weight * added.weight;
}

// Gives the number of samples read besides the pixel's own.
fn smooth_pixel(id: vec2<u32>) -> u32 {
    let width = i32(camera.size_px.x);
    let pixel = i32(id.y) * width + i32(id.x);
    let center = source[pixel];
    let d = distance_of(camera, center);
#ifdef ADAPTIVE
    let complexity = distance[pixel];
#endif
    distance[pixel] = d;
    let room = min(id, camera.size_px - 1u - id);
    if min(room.x, room.y) < 2u {
        return 0u;
    }
    let r = radius[pixel];
    let sigma_px = sigmas(camera, smoothing, d, r).square_px;
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
#ifdef GAUSSIAN
    let gx = 0.0;
    let gy = 0.0;
#else
    let gx = smaller_step(right, center, left);
    let gy = smaller_step(below, center, above);
#endif
    var rule = rule_at(camera, smoothing, center, d, unfiltered[pixel], r);
#ifdef ADAPTIVE
    rule.complexity = complexity;
#endif
    var sum = Pair(0.0, 0.0);
    add(&sum, rule, right, left, gx, w1);
    add(&sum, rule, below, above, gy, w1);
    add(&sum, rule, source[pixel + 1 + width], source[pixel - 1 - width], gx + gy, w2);
    add(&sum, rule, source[pixel + 1 - width], source[pixel - 1 + width], gx - gy, w2);
    add(&sum, rule, source[pixel + 2], source[pixel - 2], 2.0 * gx, w4);
    add(&sum, rule, source[pixel + 2 * width], source[pixel - 2 * width], 2.0 * gy, w4);
    add(&sum, rule, source[pixel + 2 + width], source[pixel - 2 - width], 2.0 * gx + gy, w5);
    add(&sum, rule, source[pixel + 2 - width], source[pixel - 2 + width], 2.0 * gx - gy, w5);
    add(&sum, rule, source[pixel + 1 + 2 * width], source[pixel - 1 - 2 * width], gx + 2.0 * gy, w5);
    add(&sum, rule, source[pixel + 1 - 2 * width], source[pixel - 1 + 2 * width], gx - 2.0 * gy, w5);
    add(&sum, rule, source[pixel + 2 + 2 * width], source[pixel - 2 - 2 * width], 2.0 * (gx + gy), w8);
    add(&sum, rule, source[pixel + 2 - 2 * width], source[pixel - 2 + 2 * width], 2.0 * (gx - gy), w8);
    distance[pixel] = distance_of(camera, smoothed_key(rule, sum));
    return 24u;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    var taps = 0u;
    for (var i = id.x; i < covered.count; i += groups.x * 64u) {
        taps += smooth_pixel(unpack_pixel(covered.packed[i]));
    }
    count(taps);
}
