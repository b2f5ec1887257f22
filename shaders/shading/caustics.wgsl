// From the light that landed to how much brighter the scene is there than without waves. Particles say nothing about waves
// finer than themselves: what they seem to focus at that scale is their own shape, which a Gaussian of about their spacing
// takes out. It runs along the rows first, then (COLUMNS) along the columns.

#import meniscus::camera::Camera

struct Caustics {
    // 0: none, 1: all.
    strength: f32,
    // Of the Gaussian; pixels of the sun's picture.
    sigma_px: f32,
    pad_a: f32,
    pad_b: f32,
}

@group(0) @binding(0) var<uniform> sun_camera: Camera;
@group(0) @binding(1) var<uniform> parameters: Caustics;
#ifdef COLUMNS
@group(0) @binding(2) var<storage, read> rows: array<f32>;
@group(0) @binding(3) var<storage, read_write> caustics: array<f32>;
#else
@group(0) @binding(2) var<storage, read> landed: array<u32>;
@group(0) @binding(3) var<storage, read_write> rows: array<f32>;

const ONE: f32 = 4096.0;
#endif

// Brighter than this is noise of single particles.
const MOST: f32 = 3.9;
// Standard deviations that the Gaussian reaches.
const REACH: f32 = 2.5;

// What is `i` pixels along the line, or at its end.
fn value_at(at: vec2<i32>, i: i32, size: vec2<i32>) -> f32 {
#ifdef COLUMNS
    return rows[clamp(at.y + i, 0, size.y - 1) * size.x + at.x];
#else
    return f32(landed[at.y * size.x + clamp(at.x + i, 0, size.x - 1)]);
#endif
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = vec2<i32>(sun_camera.size_px);
    let at = vec2<i32>(id.xy);
    if any(at >= size) {
        return;
    }
    let reach = i32(ceil(REACH * parameters.sigma_px));
    // Each weight is the one before times a ratio, which is the one before times the first one squared: no power for every tap.
    var ratio = exp2(-0.72134752 / (parameters.sigma_px * parameters.sigma_px));
    let step = ratio * ratio;
    var weight = 1.0;
    var sum = value_at(at, 0, size);
    var weights = 1.0;
    for (var i = 1; i <= reach; i++) {
        weight *= ratio;
        ratio *= step;
        sum += weight * (value_at(at, i, size) + value_at(at, -i, size));
        weights += 2.0 * weight;
    }
    let pixel = at.y * size.x + at.x;
#ifdef COLUMNS
    caustics[pixel] = mix(1.0, min(sum / weights, MOST), parameters.strength);
#else
    rows[pixel] = sum / (weights * ONE);
#endif
}
