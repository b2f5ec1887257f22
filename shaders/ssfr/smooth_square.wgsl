// The last pass of a smoothing filter: a small one in two dimensions that removes the streaks of the passes along rows and
// columns (algorithms.md 3.5), and the pattern of their taps where these are two pixels apart or four. From keys to distances, four
// pixels of a row at a time. In extreme close-ups, where the pattern is wider, passes with COARSE come before it, each with taps a
// quarter as far apart as those of the one before: what repeats by four of its taps is gone after each.
#import meniscus::tally::count
#import meniscus::covered::{CoveredTiles, TILE, unpack_pixel}
#import meniscus::camera::Camera
#import meniscus::four::{PLACES, distances_of, smaller_steps, fronts_at, loads_at}
#import meniscus::smoothing::{Smoothing, sigmas, pattern_of, LEAST_SIGMA_PX}
#import meniscus::rule::{Rule, Pair, rule_at, pair, smoothed_key}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> smoothing: Smoothing;
// Distances before any pass, and radii; keys before this one.
@group(0) @binding(2) var front: texture_2d<f32>;
@group(0) @binding(3) var source: texture_2d<f32>;
// Distances; with COARSE keys.
@group(0) @binding(4) var smoothed: texture_storage_2d<r32float, write>;
@group(0) @binding(5) var<storage, read> tiles: CoveredTiles;
#ifdef ADAPTIVE
@group(0) @binding(6) var<storage, read> complexity: array<f32>;
#endif

const ROW: vec2<i32> = vec2(1, 0);

// Half of the square, in taps; the other samples of the pairs are the other half.
const HALF: array<vec2<i32>, 12> = array(
    vec2(1, 0), vec2(0, 1), vec2(1, 1), vec2(1, -1), vec2(2, 0), vec2(0, 2),
    vec2(2, 1), vec2(2, -1), vec2(1, 2), vec2(1, -2), vec2(2, 2), vec2(2, -2),
);

// Four pixels, the planes through them, and how taps weigh.
struct Square {
    rule: Rule,
    // In keys per tap.
    slope_x: vec4<f32>,
    slope_y: vec4<f32>,
    // Weights at distances of one and two taps along rows and columns.
    near: vec4<f32>,
    far: vec4<f32>,
}

fn weight_along(square: Square, offset: i32) -> vec4<f32> {
    return select(select(square.far, square.near, abs(offset) == 1), vec4(1.0), offset == 0);
}

fn add(sum: ptr<function, Pair>, square: Square, offset: vec2<i32>, after: vec4<f32>, before: vec4<f32>) {
    let rise = f32(offset.x) * square.slope_x + f32(offset.y) * square.slope_y;
    let added = pair(square.rule, after - square.rule.center - rise, before - square.rule.center + rise);
    let weight = weight_along(square, offset.x) * weight_along(square, offset.y);
    (*sum).total += weight * added.total;
    (*sum).weight += weight * added.weight;
}

// Keys of eight pixels of a row, of which the four in the middle are those that are smoothed, or above or below them.
struct Keys {
    left: vec4<f32>,
    right: vec4<f32>,
}

fn keys_at(first: vec2<i32>) -> Keys {
    return Keys(loads_at(source, first, ROW, PLACES - 2), loads_at(source, first, ROW, PLACES + 2));
}

fn one_before(keys: Keys) -> vec4<f32> {
    return vec4(keys.left.yzw, keys.right.x);
}

fn middle(keys: Keys) -> vec4<f32> {
    return vec4(keys.left.zw, keys.right.xy);
}

fn one_after(keys: Keys) -> vec4<f32> {
    return vec4(keys.left.w, keys.right.xyz);
}

// Keys of the four pixels `offset` taps further, which are `gap` pixels apart.
fn taps_apart(first: vec2<i32>, gap: vec4<i32>, offset: vec2<i32>) -> vec4<f32> {
    return vec4(
        textureLoad(source, first + gap.x * offset, 0).x,
        textureLoad(source, first + ROW + gap.y * offset, 0).x,
        textureLoad(source, first + 2 * ROW + gap.z * offset, 0).x,
        textureLoad(source, first + 3 * ROW + gap.w * offset, 0).x,
    );
}

// Gives the number of samples that are weighed.
fn smooth_four(first: vec2<i32>) -> u32 {
#ifdef COARSE
    let center = loads_at(source, first, ROW, PLACES);
#else
    let two_up = keys_at(first - vec2(0, 2));
    let up = keys_at(first - vec2(0, 1));
    let own = keys_at(first);
    let down = keys_at(first + vec2(0, 1));
    let two_down = keys_at(first + vec2(0, 2));
    let center = middle(own);
#endif
    let d = distances_of(camera, center);
    let original = fronts_at(front, first, ROW);
    let widths = sigmas(camera, smoothing, d, original.radius);
    let sigma_px = max(widths.square_px, vec4(LEAST_SIGMA_PX));
    let pattern = pattern_of(smoothing, widths.pass_px);
    let last = vec2<i32>(camera.size_px) - 1;
    let x = first.x + PLACES;
    let room = min(min(x, last.x - x), vec4(min(first.y, last.y - first.y)));
#ifdef COARSE
    // Pixels from one tap to the next; near the picture's border a smaller one.
    let gap = min(min(vec4<i32>(pattern.period) / 4, vec4(smoothing.most_gap)), room / 2);
    let is_smoothed = (gap >= vec4(1)) & (pattern.period > vec4<f32>(vec4(smoothing.most_gap)));
#else
    let is_smoothed = (room >= vec4(2)) & (widths.square_px >= vec4(LEAST_SIGMA_PX));
#endif
    var square: Square;
    // A Gaussian, or where taps along lines have gaps what takes away all that repeats after four taps or two, namely 1, 2, 2, 2, 1
    // (the mean of four twice, one tap apart).
    let w = exp(-0.5 / (sigma_px * sigma_px));
    square.near = mix(w, vec4(1.0), pattern.gaps);
    square.far = mix(w * w * w * w, vec4(0.5), pattern.gaps);
    square.rule = rule_at(camera, smoothing, center, d, original.distance, original.radius);
#ifdef ADAPTIVE
    let pixels = first.y * i32(camera.size_px.x) + x;
    square.rule.complexity =
        vec4(complexity[pixels.x], complexity[pixels.y], complexity[pixels.z], complexity[pixels.w]);
#endif
    var sum = Pair(vec4(0.0), vec4(0.0));
#ifdef COARSE
    // The first two pairs tell the slopes. A loop that ends before it begins is what software drivers can leave out.
    var half = HALF;
    for (var i = 0; i < select(0, 12, any(is_smoothed)); i++) {
        let offset = half[i];
        let after = taps_apart(first, gap, offset);
        let before = taps_apart(first, gap, -offset);
#ifndef GAUSSIAN
        let slope = smaller_steps(after, center, before);
        square.slope_x = select(square.slope_x, slope, i == 0);
        square.slope_y = select(square.slope_y, slope, i == 1);
#endif
        add(&sum, square, offset, after, before);
    }
#else
#ifndef GAUSSIAN
    square.slope_x = smaller_steps(one_after(own), center, one_before(own));
    square.slope_y = smaller_steps(middle(down), center, middle(up));
#endif
    add(&sum, square, vec2(1, 0), one_after(own), one_before(own));
    add(&sum, square, vec2(0, 1), middle(down), middle(up));
    add(&sum, square, vec2(1, 1), one_after(down), one_before(up));
    add(&sum, square, vec2(1, -1), one_after(up), one_before(down));
    add(&sum, square, vec2(2, 0), own.right, own.left);
    add(&sum, square, vec2(0, 2), middle(two_down), middle(two_up));
    add(&sum, square, vec2(2, 1), down.right, up.left);
    add(&sum, square, vec2(2, -1), up.right, down.left);
    add(&sum, square, vec2(1, 2), one_after(two_down), one_before(two_up));
    add(&sum, square, vec2(1, -2), one_after(two_up), one_before(two_down));
    add(&sum, square, vec2(2, 2), two_down.right, two_up.left);
    add(&sum, square, vec2(2, -2), two_up.right, two_down.left);
#endif
    var found = select(center, smoothed_key(square.rule, sum), is_smoothed);
#ifndef COARSE
    found = distances_of(camera, found);
#endif
    textureStore(smoothed, first, vec4(found.x));
    textureStore(smoothed, first + ROW, vec4(found.y));
    textureStore(smoothed, first + 2 * ROW, vec4(found.z));
    textureStore(smoothed, first + 3 * ROW, vec4(found.w));
    return 24u * countOneBits(dot(vec4<u32>(is_smoothed), vec4(1u, 2u, 4u, 8u)));
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    var taps = 0u;
    let end = tiles.count * TILE;
    for (var i = id.x; i < end; i += groups.x * 64u) {
        let tile = unpack_pixel(tiles.packed[i / TILE]);
        taps += smooth_four(vec2<i32>(TILE * tile + vec2(0u, i % TILE)));
    }
    count(taps);
}
