// Narrow-range filter along one direction, slope-compensated (algorithms.md 3.7, 3.2). Works on keys: deviations from the
// plane through the pixel are then plain differences, and what is tested and averaged.
#import meniscus::tally::count
#import meniscus::covered::{CoveredPixels, unpack_pixel}
#import meniscus::camera::Camera
#import meniscus::key::{distance_of, key_of, key_per_distance, smaller_step}
#import meniscus::narrow_range::{NarrowRange, sigmas, clamp_behind, keep_in_front, WIDENED, REACH, MAX_TAPS, LEAST_SIGMA_PX}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> narrow: NarrowRange;
@group(0) @binding(2) var<storage, read> radius: array<f32>;
// Distances before any pass; keys before and after this one.
@group(0) @binding(3) var<storage, read> unfiltered: array<f32>;
@group(0) @binding(4) var<storage, read> source: array<f32>;
@group(0) @binding(5) var<storage, read_write> smoothed: array<f32>;
@group(0) @binding(6) var<storage, read> covered: CoveredPixels;

// Distance of the taps that give the slope, in standard deviations: far enough apart to see the surface behind the bumps.
const SLOPE_SIGMAS: f32 = 0.75;

// Gives the number of samples read besides the pixel's own.
fn smooth_pixel(id: vec2<u32>) -> u32 {
    let width = i32(camera.size_px.x);
    let pixel = i32(id.y) * width + i32(id.x);
    let center = source[pixel];
    smoothed[pixel] = center;
    let d = distance_of(camera, center);
    let r = radius[pixel];
    let sigma_px = sigmas(camera, narrow, d, r).pass_px * WIDENED;
    if sigma_px < LEAST_SIGMA_PX {
        return 0u;
    }
    var read = 0u;
    let is_row = narrow.direction.x == 1u;
    let place = i32(select(id.y, id.x, is_row));
    let room = min(place, i32(select(camera.size_px.y, camera.size_px.x, is_row)) - 1 - place);
    let stride = select(width, 1, is_row);

    let baseline = min(max(i32(round(SLOPE_SIGMAS * sigma_px)), 1), room);
    var slope = 0.0;
    if baseline > 0 {
        slope = smaller_step(source[pixel + baseline * stride], center, source[pixel - baseline * stride]) / f32(baseline);
        read += 2u;
    }
    let per_radius = r * key_per_distance(camera, center);
    let range = max(narrow.range_radii * per_radius, 1e-30);
    // Just behind the surface as it was, not as earlier passes left it: else every pass would pull small things further.
    let clamped = key_of(camera, unfiltered[pixel]) - narrow.clamp_radii * per_radius - center;
    let reach_px = REACH * sigma_px;
    let step = max(1, i32(ceil(reach_px / MAX_TAPS)));
    let taps = i32(ceil(reach_px / f32(step)));
    let falloff = -0.5 / (sigma_px * sigma_px);
    var total = 0.0;
    var weights = 1.0;
    for (var k = 1; k <= taps; k++) {
        let offset = k * step;
        // Only whole pairs count, also at the picture's border.
        if offset > room {
            break;
        }
        read += 2u;
        let rise = slope * f32(offset);
        let after = source[pixel + offset * stride] - center - rise;
        let before = source[pixel - offset * stride] - center + rise;
        let weight = exp(falloff * f32(offset * offset)) * keep_in_front(max(after, before), range);
        total += weight * (clamp_behind(after, range, clamped) + clamp_behind(before, range, clamped));
        weights += 2.0 * weight;
    }
    // Never further back than the range, which also keeps keys of near surfaces positive.
    let last = key_of(camera, d + narrow.range_radii * r);
    smoothed[pixel] = max(center + total / weights, last);
    return read;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    var taps = 0u;
    for (var i = id.x; i < covered.count; i += groups.x * 64u) {
        taps += smooth_pixel(unpack_pixel(covered.packed[i]));
    }
    count(taps);
}
