// The last pass of a smoothing filter: a small one in two dimensions that removes the streaks of the passes along rows and
// columns (algorithms.md 3.5), and the pattern of their taps where these are more than a pixel apart. From keys to distances.
#import meniscus::tally::count
#import meniscus::covered::{CoveredPixels, unpack_pixel}
#import meniscus::camera::Camera
#import meniscus::key::{distance_of, smaller_step}
#import meniscus::smoothing::{Smoothing, Smoothed, sigmas, pattern_of, LEAST_SIGMA_PX}
#import meniscus::rule::{Rule, Pair, rule_at, pair, smoothed_key}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> smoothing: Smoothing;
// Distances before any pass, and radii; keys before this one.
@group(0) @binding(2) var front: texture_2d<f32>;
@group(0) @binding(3) var source: texture_2d<f32>;
@group(0) @binding(4) var distance: texture_storage_2d<r32float, write>;
@group(0) @binding(5) var<storage, read> covered: CoveredPixels;
#ifdef ADAPTIVE
@group(0) @binding(6) var<storage, read> complexity: array<f32>;
#endif

fn add(sum: ptr<function, Pair>, rule: Rule, after: f32, before: f32, rise: f32, weight: f32) {
    let added = pair(rule, after - rule.center - rise, before - rule.center + rise);
    (*sum).total += weight * added.total;
    (*sum).weight += weight * added.weight;
}

fn key_at(pixel: vec2<i32>) -> f32 {
    return textureLoad(source, pixel, 0).x;
}

fn smooth_pixel(id: vec2<u32>) -> Smoothed {
    let pixel = vec2<i32>(id);
    let center = key_at(pixel);
    let d = distance_of(camera, center);
    let room = min(id, camera.size_px - 1u - id);
    let original = textureLoad(front, pixel, 0).xy;
    let r = original.y;
    let widths = sigmas(camera, smoothing, d, r);
    let sigma_px = widths.square_px;
    let pattern = pattern_of(smoothing, widths.pass_px);
    // Pixels from one tap to the next; near the picture's border a smaller one.
    let gap = min(max(i32(pattern.period) / 4, 1), i32(min(room.x, room.y)) / 2);
    if gap < 1 || sigma_px < LEAST_SIGMA_PX {
        return Smoothed(center, 0u);
    }
    // Weights at distances of one and two taps along rows and columns: a Gaussian, or where taps along lines have gaps what takes
    // away all that repeats after four taps or two, namely 1, 2, 2, 2, 1 (the mean of four twice, one tap apart).
    let w = exp(-0.5 / (sigma_px * sigma_px));
    let near = mix(w, 1.0, pattern.gaps);
    let far = mix(w * w * w * w, 0.5, pattern.gaps);
    // At distances whose squares are 1, 2, 4, 5 and 8.
    let w1 = near;
    let w2 = near * near;
    let w4 = far;
    let w5 = far * near;
    let w8 = far * far;
    let left = key_at(pixel - gap * vec2(1, 0));
    let right = key_at(pixel + gap * vec2(1, 0));
    let above = key_at(pixel - gap * vec2(0, 1));
    let below = key_at(pixel + gap * vec2(0, 1));
#ifdef GAUSSIAN
    let gx = 0.0;
    let gy = 0.0;
#else
    let gx = smaller_step(right, center, left);
    let gy = smaller_step(below, center, above);
#endif
    var rule = rule_at(camera, smoothing, center, d, original.x, r);
#ifdef ADAPTIVE
    rule.complexity = complexity[id.y * camera.size_px.x + id.x];
#endif
    var sum = Pair(0.0, 0.0);
    add(&sum, rule, right, left, gx, w1);
    add(&sum, rule, below, above, gy, w1);
    add(&sum, rule, key_at(pixel + gap * vec2(1, 1)), key_at(pixel - gap * vec2(1, 1)), gx + gy, w2);
    add(&sum, rule, key_at(pixel + gap * vec2(1, -1)), key_at(pixel - gap * vec2(1, -1)), gx - gy, w2);
    add(&sum, rule, key_at(pixel + gap * vec2(2, 0)), key_at(pixel - gap * vec2(2, 0)), 2.0 * gx, w4);
    add(&sum, rule, key_at(pixel + gap * vec2(0, 2)), key_at(pixel - gap * vec2(0, 2)), 2.0 * gy, w4);
    add(&sum, rule, key_at(pixel + gap * vec2(2, 1)), key_at(pixel - gap * vec2(2, 1)), 2.0 * gx + gy, w5);
    add(&sum, rule, key_at(pixel + gap * vec2(2, -1)), key_at(pixel - gap * vec2(2, -1)), 2.0 * gx - gy, w5);
    add(&sum, rule, key_at(pixel + gap * vec2(1, 2)), key_at(pixel - gap * vec2(1, 2)), gx + 2.0 * gy, w5);
    add(&sum, rule, key_at(pixel + gap * vec2(1, -2)), key_at(pixel - gap * vec2(1, -2)), gx - 2.0 * gy, w5);
    add(&sum, rule, key_at(pixel + gap * vec2(2, 2)), key_at(pixel - gap * vec2(2, 2)), 2.0 * (gx + gy), w8);
    add(&sum, rule, key_at(pixel + gap * vec2(2, -2)), key_at(pixel - gap * vec2(2, -2)), 2.0 * (gx - gy), w8);
    return Smoothed(smoothed_key(rule, sum), 24u);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    var taps = 0u;
    let end = covered.count;
    for (var i = id.x; i < end; i += groups.x * 64u) {
        let pixel = unpack_pixel(covered.packed[i]);
        let found = smooth_pixel(pixel);
        textureStore(distance, pixel, vec4(distance_of(camera, found.value)));
        taps += found.taps;
    }
    count(taps);
}
