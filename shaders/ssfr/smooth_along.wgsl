// A smoothing filter along one direction (algorithms.md 3.7). Works on keys: deviations from the plane through the pixel are
// then plain differences, and what the rule of the filter tests and averages.
#import meniscus::tally::count
#import meniscus::covered::{CoveredPixels, unpack_pixel}
#import meniscus::camera::Camera
#import meniscus::key::{distance_of, smaller_step}
#import meniscus::smoothing::{Smoothing, Smoothed, sigmas, taps_of, tap_weight, WIDENED, LEAST_SIGMA_PX}
#import meniscus::rule::{Pair, rule_at, pair, smoothed_key}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> smoothing: Smoothing;
// Distances before any pass, and radii; keys before and after this one.
@group(0) @binding(2) var front: texture_2d<f32>;
@group(0) @binding(3) var source: texture_2d<f32>;
@group(0) @binding(4) var smoothed: texture_storage_2d<r32float, write>;
@group(0) @binding(5) var<storage, read> covered: CoveredPixels;
#ifdef ADAPTIVE
@group(0) @binding(6) var<storage, read> complexity: array<f32>;
#endif

// Distance of the taps that give the slope, in standard deviations: far enough apart to see the surface behind the bumps.
const SLOPE_SIGMAS: f32 = 0.75;

fn key_at(pixel: vec2<i32>) -> f32 {
    return textureLoad(source, pixel, 0).x;
}

fn smooth_pixel(id: vec2<u32>) -> Smoothed {
    let pixel = vec2<i32>(id);
    let center = key_at(pixel);
    let d = distance_of(camera, center);
    let original = textureLoad(front, pixel, 0).xy;
    let r = original.y;
    let sigma_px = sigmas(camera, smoothing, d, r).pass_px * WIDENED;
    if sigma_px < LEAST_SIGMA_PX {
        return Smoothed(center, 0u);
    }
    var read = 0u;
    let is_row = smoothing.direction.x == 1u;
    let place = i32(select(id.y, id.x, is_row));
    let room = min(place, i32(select(camera.size_px.y, camera.size_px.x, is_row)) - 1 - place);
    let stride = vec2<i32>(smoothing.direction);

    var slope = 0.0;
#ifndef GAUSSIAN
    let baseline = min(max(i32(round(SLOPE_SIGMAS * sigma_px)), 1), room);
    if baseline > 0 {
        slope = smaller_step(key_at(pixel + baseline * stride), center, key_at(pixel - baseline * stride)) / f32(baseline);
        read += 2u;
    }
#endif
    var rule = rule_at(camera, smoothing, center, d, original.x, r);
#ifdef ADAPTIVE
    rule.complexity = complexity[id.y * camera.size_px.x + id.x];
#endif
    let taps = taps_of(smoothing, sigma_px, room);
    var sum = Pair(0.0, 0.0);
    // Only whole pairs count, also at the picture's border.
    for (var k = 1; k <= taps.count; k++) {
        let offset = k * taps.step;
        read += 2u;
        let rise = slope * f32(offset);
        let after = key_at(pixel + offset * stride) - center - rise;
        let before = key_at(pixel - offset * stride) - center + rise;
        let weight = tap_weight(taps, k);
        let added = pair(rule, after, before);
        sum.total += weight * added.total;
        sum.weight += weight * added.weight;
    }
    return Smoothed(smoothed_key(rule, sum), read);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    var taps = 0u;
    let end = covered.count;
    for (var i = id.x; i < end; i += groups.x * 64u) {
        let pixel = unpack_pixel(covered.packed[i]);
        let found = smooth_pixel(pixel);
        textureStore(smoothed, pixel, vec4(found.value));
        taps += found.taps;
    }
    count(taps);
}
