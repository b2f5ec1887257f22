// A smoothing filter along one direction (algorithms.md 3.7). Works on keys: deviations from the plane through the pixel are
// then plain differences, and what the rule of the filter tests and averages. Four pixels of a line at a time: where their taps lie
// side by side, each tap's sample serves all of them.
#import meniscus::tally::count
#import meniscus::covered::{CoveredTiles, TILE, unpack_pixel}
#import meniscus::camera::Camera
#import meniscus::four::{PLACES, distances_of, smaller_steps, fronts_at, loads_at}
#import meniscus::smoothing::{Smoothing, Taps, sigmas, taps_of, tap_weight, WIDENED}
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

fn add(sum: ptr<function, Pair>, line: Line, k: i32, after: vec4<f32>, before: vec4<f32>) {
    let rise = line.slope * vec4<f32>(k * line.taps.step);
    let added = pair(line.rule, after - line.rule.center - rise, before - line.rule.center + rise);
    let weight = tap_weight(line.taps, k);
    (*sum).total += weight * added.total;
    (*sum).weight += weight * added.weight;
}

fn loads_of_two(first: vec2<i32>, stride: vec2<i32>) -> vec2<f32> {
    return vec2(textureLoad(source, first, 0).x, textureLoad(source, first + stride, 0).x);
}

// The sums of all pairs. Only whole ones count, also at the picture's border.
fn sum_of(line: Line, first: vec2<i32>, stride: vec2<i32>) -> Pair {
    let counts = line.taps.count;
    let most = max(max(counts.x, counts.y), max(counts.z, counts.w));
    let is_dense = all(line.taps.step == vec4(1));
    let is_double = all(line.taps.step == vec4(2));
    var sum = Pair(vec4(0.0), vec4(0.0));
    // Three loops, all but one of which end before they begin: software drivers go through all sides of a branch.
    let dense = select(0, most, is_dense);
    var after = line.rule.center;
    var before = line.rule.center;
    for (var k = 1; k <= dense; k++) {
        after = vec4(after.yzw, textureLoad(source, first + (k + 3) * stride, 0).x);
        before = vec4(textureLoad(source, first - k * stride, 0).x, before.xyz);
        add(&sum, line, k, after, before);
    }
    let double = select(0, most, is_double);
    for (var k = 1; k <= double; k++) {
        after = vec4(after.zw, loads_of_two(first + (2 * k + 2) * stride, stride));
        before = vec4(loads_of_two(first - 2 * k * stride, stride), before.xy);
        add(&sum, line, k, after, before);
    }
    let sparse = select(most, 0, is_dense || is_double);
    for (var k = 1; k <= sparse; k++) {
        let offset = k * line.taps.step;
        let ahead = loads_at(source, first, stride, PLACES + offset);
        let behind = loads_at(source, first, stride, PLACES - offset);
        add(&sum, line, k, ahead, behind);
    }
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
    let room = max(min(place, last - place), vec4(0));
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
    let baseline = min(max(vec4<i32>(round(SLOPE_SIGMAS * sigma_px)), vec4(1)), room);
    let ahead = loads_at(source, first, stride, PLACES + baseline);
    let behind = loads_at(source, first, stride, PLACES - baseline);
    // At the picture's border, where there is no room, all three are the same.
    line.slope = smaller_steps(ahead, center, behind) / vec4<f32>(max(baseline, vec4(1)));
#endif
    let counts = line.taps.count;
    let sum = sum_of(line, first, stride);
    // Gaps, and pixels whose radius is none, have no taps and no numbers to reckon with.
    let found = select(center, smoothed_key(line.rule, sum), counts > vec4(0));
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
