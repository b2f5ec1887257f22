#define_import_path meniscus::rule
#import meniscus::camera::Camera
#import meniscus::key::{key_of, key_per_distance, is_gap}
#import meniscus::smoothing::Smoothing

// What two mirrored samples contribute to a pixel, given how far they deviate, in keys, from the plane through it. Which
// filter it is lies here alone: GAUSSIAN, BILATERAL, ADAPTIVE, else the narrow-range filter.

struct Rule {
    // Key of the pixel, and the least that it may become: further back than the range it is not moved, which also keeps
    // keys of near surfaces positive.
    center: f32,
    last: f32,
    // In keys, > 0.
    range: f32,
    // What lies behind the range counts as this deviation.
    clamped: f32,
    // ADAPTIVE: 0 = bilateral, 1 = narrow-range.
    complexity: f32,
}

// Weighted deviations of a pair, and the weights.
struct Pair {
    total: f32,
    weight: f32,
}

fn rule_at(camera: Camera, smoothing: Smoothing, center: f32, distance: f32, unfiltered: f32, radius: f32) -> Rule {
    let per_radius = radius * key_per_distance(camera, center);
#ifdef GAUSSIAN
    // A mean never leaves the samples.
    let last = -1.6e38;
#else
    let last = key_of(camera, distance + smoothing.range_radii * radius);
#endif
    // Just behind the surface as it was, not as earlier passes left it: else every pass would pull small things further.
    let clamped = key_of(camera, unfiltered) - smoothing.clamp_radii * per_radius - center;
    return Rule(center, last, max(smoothing.range_radii * per_radius, 1e-30), clamped, 0.0);
}

// Both tests of the narrow range are faded over its outer half: a sample that crosses a hard threshold from one row to the
// next would leave a streak.

// What a deviation counts as: itself, and further behind than the range `clamped`. `range` is > 0.
fn clamp_behind(deviation: f32, range: f32, clamped: f32) -> f32 {
    let e = max(deviation, -range);
    return e + (clamped - e) * clamp(-2.0 * e / range - 1.0, 0.0, 1.0);
}

// How far a pair counts whose nearer sample deviates by `deviation`: not at all in front of the range.
fn keep_in_front(deviation: f32, range: f32) -> f32 {
    return clamp(2.0 - 2.0 * deviation / range, 0.0, 1.0);
}

// Truong and Yuksel 2018 (algorithms.md 3.1, 3.2): in front of the range neither sample counts, behind it just behind.
fn narrow_range(rule: Rule, after: f32, before: f32) -> Pair {
    let weight = keep_in_front(max(after, before), rule.range);
    let total = clamp_behind(after, rule.range, rule.clamped) + clamp_behind(before, rule.range, rule.clamped);
    return Pair(weight * total, 2.0 * weight);
}

// Gaussian of the deviation with a third of the range as its standard deviation (algorithms.md 4).
fn bilateral(rule: Rule, after: f32, before: f32) -> Pair {
    // At twice the range the weight is 1.5e-8.
    let e = clamp(vec2(after, before), vec2(-2.0 * rule.range), vec2(2.0 * rule.range));
    let thirds = 3.0 * e / rule.range;
    let weight = exp(-0.5 * thirds * thirds);
    return Pair(dot(weight, e), weight.x + weight.y);
}

// All that is there.
fn gaussian(after: f32, before: f32) -> Pair {
    let e = vec2(after, before);
    // Deviations from a gap are as large as the gap.
    let weight = select(vec2(0.0), vec2(1.0), e > vec2(-1e38));
    return Pair(dot(weight, max(e, vec2(-1e38))), weight.x + weight.y);
}

fn pair(rule: Rule, after: f32, before: f32) -> Pair {
#ifdef GAUSSIAN
    return gaussian(after, before);
#else ifdef BILATERAL
    return bilateral(rule, after, before);
#else ifdef ADAPTIVE
    if rule.complexity <= 0.0 {
        return bilateral(rule, after, before);
    }
    let narrow = narrow_range(rule, after, before);
    if rule.complexity >= 1.0 {
        return narrow;
    }
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
fn smoothed_key(rule: Rule, sum: Pair) -> f32 {
    return max(rule.center + sum.total / (1.0 + sum.weight), rule.last);
}
