// A smoothing filter along one direction (algorithms.md 3.7). Works on keys: deviations from the plane through the pixel are
// then plain differences, and what the rule of the filter tests and averages. Four pixels of a line at a time: where their taps lie
// side by side, each tap's sample serves all of them.
//
// Where taps are further apart, other loops read them. Software drivers go once through the body of a loop that ends before it begins, so
// that there are variants with fewer: STEPS_OF_ONE is for pictures without taps that are apart; SMALL_STEPS goes pixel by pixel through
// lines whose taps are more than two pixels apart, for pictures with few of these.
#import meniscus::tally::count
#import meniscus::covered::{CoveredTiles, TILE, unpack_pixel}
#import meniscus::camera::Camera
#import meniscus::four::{PLACES, distances_of, smaller_steps, fronts_at, loads_at}
#import meniscus::smoothing::{Smoothing, Taps, sigmas, taps_of, tap_weight, weight_beside, WIDENED}
#import meniscus::rule::{Rule, Pair, rule_at, pair, smoothed_key}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> smoothing: Smoothing;
// Distances before any pass, and radii; keys before and after this one.
@group(0) @binding(2) var front: texture_2d<f32>;
@group(0) @binding(3) var source: texture_2d<f32>;
@group(0) @binding(4) var smoothed: texture_storage_2d<r32float, write>;
@group(0) @binding(5) var<storage, read> tiles: CoveredTiles;
#ifdef ADAPTIVE
@group(0) @binding(6) var<storage, read> complexity: array<f32>;
#endif

// Distance of the taps that give the slope, in standard deviations: far enough apart to see the surface behind the bumps.
const SLOPE_SIGMAS: f32 = 0.75;

// Four pixels, and the planes through them along the line.
struct Line {
    rule: Rule,
    // In keys per pixel.
    slope: vec4<f32>,
    taps: Taps,
}

// Adds pairs that lie as many pixels to each side as `offset` says.
fn add(sum: ptr<function, Pair>, line: Line, offset: vec4<f32>, weight: vec4<f32>, after: vec4<f32>, before: vec4<f32>) {
    let rise = line.slope * offset;
    let added = pair(line.rule, after - line.rule.center - rise, before - line.rule.center + rise);
    (*sum).total += weight * added.total;
    (*sum).weight += weight * added.weight;
}

fn loads_of_two(first: vec2<i32>, stride: vec2<i32>) -> vec2<f32> {
    return vec2(textureLoad(source, first, 0).x, textureLoad(source, first + stride, 0).x);
}

fn largest(values: vec4<f32>) -> i32 {
    return i32(max(max(values.x, values.y), max(values.z, values.w)));
}

// The sums of all pairs. Only whole ones count, also at the picture's border.
fn sum_of(line: Line, first: vec2<i32>, stride: vec2<i32>) -> Pair {
    let taps = line.taps;
    let most = largest(taps.count);
    var sum = Pair(vec4(0.0), vec4(0.0));
    var after = line.rule.center;
    var before = line.rule.center;
#ifdef STEPS_OF_ONE
    let dense = most;
#else ifdef SMALL_STEPS
    let is_double = all(taps.step == vec4(2.0));
    let dense = select(largest(taps.count * taps.step), 0, is_double);
#else
    let is_double = all(taps.step == vec4(2.0));
    let is_dense = all(taps.step == vec4(1.0));
    let dense = select(0, most, is_dense);
#endif
    for (var k = 1; k <= dense; k++) {
        after = vec4(after.yzw, textureLoad(source, first + (k + 3) * stride, 0).x);
        before = vec4(textureLoad(source, first - k * stride, 0).x, before.xyz);
#ifdef SMALL_STEPS
        let weight = weight_beside(taps, k);
#else
        let weight = tap_weight(taps, k);
#endif
        add(&sum, line, vec4(f32(k)), weight, after, before);
    }
#ifndef STEPS_OF_ONE
    let double = select(0, most, is_double);
    for (var k = 1; k <= double; k++) {
        after = vec4(after.zw, loads_of_two(first + (2 * k + 2) * stride, stride));
        before = vec4(loads_of_two(first - 2 * k * stride, stride), before.xy);
        add(&sum, line, vec4(f32(2 * k)), tap_weight(taps, k), after, before);
    }
#ifndef SMALL_STEPS
    let sparse = select(most, 0, is_dense || is_double);
    for (var k = 1; k <= sparse; k++) {
        let offset = f32(k) * taps.step;
        let ahead = loads_at(source, first, stride, PLACES + vec4<i32>(offset));
        let behind = loads_at(source, first, stride, PLACES - vec4<i32>(offset));
        add(&sum, line, offset, tap_weight(taps, k), ahead, behind);
    }
#endif
#endif
    return sum;
}

// Gives the number of samples that are weighed.
fn smooth_line(first: vec2<i32>) -> u32 {
    let stride = vec2<i32>(smoothing.direction);
    let center = loads_at(source, first, stride, PLACES);
    let original = fronts_at(front, first, stride);
    let d = distances_of(camera, center);
    let sigma_px = sigmas(camera, smoothing, d, original.radius).pass_px * WIDENED;
    let place = dot(first, stride) + PLACES;
    let last = dot(vec2<i32>(camera.size_px), stride) - 1;
    let room = vec4<f32>(max(min(place, last - place), vec4(0)));
    var line: Line;
    line.taps = taps_of(smoothing, sigma_px, room);
    line.rule = rule_at(camera, smoothing, center, d, original.distance, original.radius);
#ifdef ADAPTIVE
    let row = vec2(1, i32(camera.size_px.x));
    let pixels = dot(first, row) + PLACES * dot(stride, row);
    line.rule.complexity =
        vec4(complexity[pixels.x], complexity[pixels.y], complexity[pixels.z], complexity[pixels.w]);
#endif
#ifndef GAUSSIAN
    let baseline_px = min(max(round(SLOPE_SIGMAS * sigma_px), vec4(1.0)), room);
    let baseline = vec4<i32>(baseline_px);
    let ahead = loads_at(source, first, stride, PLACES + baseline);
    let behind = loads_at(source, first, stride, PLACES - baseline);
    // At the picture's border, where there is no room, all three are the same.
    line.slope = smaller_steps(ahead, center, behind) / max(baseline_px, vec4(1.0));
#endif
    let counts = line.taps.count;
    let sum = sum_of(line, first, stride);
    // Gaps, and pixels whose radius is none, have no taps and no numbers to reckon with.
    let found = select(center, smoothed_key(line.rule, sum), counts > vec4(0.0));
    textureStore(smoothed, first, vec4(found.x));
    textureStore(smoothed, first + stride, vec4(found.y));
    textureStore(smoothed, first + 2 * stride, vec4(found.z));
    textureStore(smoothed, first + 3 * stride, vec4(found.w));
    return 2u * u32(counts.x + counts.y + counts.z + counts.w);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    var taps = 0u;
    let end = tiles.count * TILE;
    let across = vec2(1u) - smoothing.direction;
    for (var i = id.x; i < end; i += groups.x * 64u) {
        let tile = unpack_pixel(tiles.packed[i / TILE]);
        taps += smooth_line(vec2<i32>(TILE * tile + i % TILE * across));
    }
    count(taps);
}
