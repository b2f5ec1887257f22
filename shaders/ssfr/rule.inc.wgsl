#define_import_path meniscus::rule
#import meniscus::camera::Camera
#import meniscus::four::{keys_of, keys_per_distance}
#import meniscus::smoothing::Smoothing

// What two mirrored samples contribute to a pixel, given how far they deviate, in keys, from the plane through it. Which
// filter it is lies here alone: GAUSSIAN, BILATERAL, ADAPTIVE, else the narrow-range filter.

struct Rule {
    // Key of the pixel, and the least that it may become: further back than the range it is not moved, which also keeps
    // keys of near surfaces positive.
    center: vec4<f32>,
    last: vec4<f32>,
    // In keys, > 0, and twice its inverse.
    range: vec4<f32>,
    steepness: vec4<f32>,
    // What lies behind the range counts as this deviation.
    clamped: vec4<f32>,
    // ADAPTIVE: 0 = bilateral, 1 = narrow-range.
    complexity: vec4<f32>,
}

// Weighted deviations of a pair, and the weights.
struct Pair {
    total: vec4<f32>,
    weight: vec4<f32>,
}

fn rule_at(camera: Camera, smoothing: Smoothing, center: vec4<f32>, distance: vec4<f32>, unfiltered: vec4<f32>, radius: vec4<f32>) -> Rule {
    let per_radius = radius * keys_per_distance(camera, center);
#ifdef GAUSSIAN
    // A mean never leaves the samples.
    let last = vec4(-1.6e38);
#else
    let last = keys_of(camera, distance + smoothing.range_radii * radius);
#endif
    // Just behind the surface as it was, not as earlier passes left it: else every pass would pull small things further.
    let clamped = keys_of(camera, unfiltered) - smoothing.clamp_radii * per_radius - center;
    let range = max(smoothing.range_radii * per_radius, vec4(1e-30));
    return Rule(center, last, range, 2.0 / range, clamped, vec4(0.0));
}

// Both tests of the narrow range are faded over its outer half: a sample that crosses a hard threshold from one row to the
// next would leave a streak.

// What a deviation counts as: itself, and further behind than the range `clamped`.
fn clamp_behind(rule: Rule, deviation: vec4<f32>) -> vec4<f32> {
    let e = max(deviation, -rule.range);
    return e + (rule.clamped - e) * saturate(-1.0 - rule.steepness * e);
}

// Truong and Yuksel 2018 (algorithms.md 3.1, 3.2): in front of the range neither sample counts, behind it just behind.
fn narrow_range(rule: Rule, after: vec4<f32>, before: vec4<f32>) -> Pair {
    let weight = saturate(2.0 - rule.steepness * max(after, before));
    let total = clamp_behind(rule, after) + clamp_behind(rule, before);
    return Pair(weight * total, 2.0 * weight);
}

// Gaussian of the deviation with a third of the range as its standard deviation (algorithms.md 4).
fn bilateral(rule: Rule, after: vec4<f32>, before: vec4<f32>) -> Pair {
    // In thirds of the range; at six of them the weight is 1.5e-8.
    let thirds = 1.5 * rule.steepness;
    let a = clamp(after * thirds, vec4(-6.0), vec4(6.0));
    let b = clamp(before * thirds, vec4(-6.0), vec4(6.0));
    let of_after = exp(-0.5 * a * a);
    let of_before = exp(-0.5 * b * b);
    return Pair((of_after * a + of_before * b) / thirds, of_after + of_before);
}

// All that is there.
fn gaussian(after: vec4<f32>, before: vec4<f32>) -> Pair {
    // Deviations from a gap are as large as the gap.
    let of_after = select(vec4(0.0), vec4(1.0), after > vec4(-1e38));
    let of_before = select(vec4(0.0), vec4(1.0), before > vec4(-1e38));
    let total = of_after * max(after, vec4(-1e38)) + of_before * max(before, vec4(-1e38));
    return Pair(total, of_after + of_before);
}

fn pair(rule: Rule, after: vec4<f32>, before: vec4<f32>) -> Pair {
#ifdef GAUSSIAN
    return gaussian(after, before);
#else ifdef BILATERAL
    return bilateral(rule, after, before);
#else ifdef ADAPTIVE
    let narrow = narrow_range(rule, after, before);
    let soft = bilateral(rule, after, before);
    return Pair(
        mix(soft.total, narrow.total, rule.complexity),
        mix(soft.weight, narrow.weight, rule.complexity),
    );
#else
    return narrow_range(rule, after, before);
#endif
}

// The smoothed key of a pixel whose pairs add up to `sum`.
fn smoothed_key(rule: Rule, sum: Pair) -> vec4<f32> {
    return max(rule.center + sum.total / (1.0 + sum.weight), rule.last);
}
