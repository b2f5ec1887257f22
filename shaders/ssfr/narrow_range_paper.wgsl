// Narrow-range filter as published (Truong and Yuksel 2018; algorithms.md 3.1 to 3.3), on distances. Along one direction,
// or with SQUARE over a small square, ring by ring. Without the defects of the public codes (algorithms.md 3.6).
#import meniscus::tally::count
#import meniscus::covered::{CoveredPixels, unpack_pixel}
#import meniscus::camera::Camera
#import meniscus::smoothing::{Smoothing, sigmas, taps_of, tap_weight, WIDENED, LEAST_SIGMA_PX}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> smoothing: Smoothing;
// Its y: radii.
@group(0) @binding(2) var front: texture_2d<f32>;
@group(0) @binding(3) var source: texture_2d<f32>;
@group(0) @binding(4) var smoothed: texture_storage_2d<r32float, write>;
@group(0) @binding(5) var<storage, read> covered: CoveredPixels;

// A pixel after a pass, and the number of samples read besides its own.
struct Smoothed {
    value: f32,
    taps: u32,
}

struct Range {
    low: f32,
    high: f32,
}

// Whether `d` belongs to the surface, which then may slope on from there (dynamic range, 3.3).
fn accept(range: ptr<function, Range>, d: f32, delta: f32) -> bool {
    let is_same = d >= (*range).low && d <= (*range).high;
    if is_same {
        (*range).low = min((*range).low, d - delta);
        (*range).high = max((*range).high, d + delta);
    }
    return is_same;
}

fn distance_at(pixel: vec2<i32>) -> f32 {
    return textureLoad(source, pixel, 0).x;
}

fn smooth_pixel(id: vec2<u32>) -> Smoothed {
    let at = vec2<i32>(id);
    let center = distance_at(at);
    let r = textureLoad(front, at, 0).y;
    let delta = smoothing.range_radii * r;
    let clamped = center + smoothing.clamp_radii * r;
    let widths = sigmas(camera, smoothing, vec4(center), vec4(r));
    let last = vec2<i32>(camera.size_px) - 1;
    // Sums of differences to the centre: those of the distances themselves would be rounded ten times more coarsely.
    var total = 0.0;
    var weights = 1.0;
    var read = 0u;
#ifdef SQUARE
    let sigma_px = widths.square_px.x;
    let falloff = -0.5 / max(sigma_px * sigma_px, 1e-6);
    // The inner ring slopes on into the outer one, the same way for all of a ring.
    var inner = Range(center - delta, center + delta);
    var outer = inner;
    for (var ring = 1; ring <= 2; ring++) {
        for (var i = 0; i < 2 * ring; i++) {
            for (var turn = 0; turn < 2; turn++) {
                // Half of the ring; the pairs' other samples are the other half.
                let side = vec2(ring, ring - i);
                let offset = select(side, vec2(-side.y, side.x), turn == 1);
                if all(at - abs(offset) >= vec2(0)) && all(at + abs(offset) <= last) {
                    let after = distance_at(at + offset);
                    let before = distance_at(at - offset);
                    read += 2u;
                    if min(after, before) >= inner.low {
                        let weight = exp(falloff * f32(offset.x * offset.x + offset.y * offset.y));
                        for (var s = 0; s < 2; s++) {
                            let d = select(after, before, s == 1);
                            let is_same = d <= inner.high;
                            if is_same {
                                outer.low = min(outer.low, d - delta);
                                outer.high = max(outer.high, d + delta);
                            }
                            total += weight * (select(clamped, d, is_same) - center);
                        }
                        weights += 2.0 * weight;
                    }
                }
            }
        }
        inner = outer;
    }
#else
    let is_row = smoothing.direction.x == 1u;
    let place = select(at.y, at.x, is_row);
    let room = min(place, select(last.y, last.x, is_row) - place);
    let stride = vec2<i32>(smoothing.direction);
    let sigma_px = widths.pass_px.x * WIDENED;
    let taps = taps_of(smoothing, vec4(max(sigma_px, LEAST_SIGMA_PX)), vec4(f32(room)));
    var range_after = Range(center - delta, center + delta);
    var range_before = range_after;
    for (var k = 1; k <= i32(taps.count.x); k++) {
        let offset = k * i32(taps.step.x);
        let after = distance_at(at + offset * stride);
        let before = distance_at(at - offset * stride);
        read += 2u;
        // In front: another surface, which hides part of ours; its mirrored sample goes with it (3.2).
        if after >= range_after.low && before >= range_before.low {
            let weight = tap_weight(taps, k).x;
            let value_after = select(clamped, after, accept(&range_after, after, delta));
            let value_before = select(clamped, before, accept(&range_before, before, delta));
            total += weight * ((value_after - center) + (value_before - center));
            weights += 2.0 * weight;
        }
    }
#endif
    return Smoothed(select(center, center + total / weights, sigma_px >= LEAST_SIGMA_PX), read);
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
