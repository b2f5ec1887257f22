// One step of the flow of a surface by its mean curvature (van der Laan et al. 2009; algorithms.md 5), on keys. Moves along
// the normal with the speed of the curvature, explicit in time. With LAST from keys to distances.
//
// With p, q the slopes of the surface along both axes (depth per width) and lengths in pixels,
//   dk/dt = 1/2 [(1 + q^2) k_xx + (1 + p^2) k_yy - 2 p q k_xy] / (1 + p^2 + q^2).
// On a plane it is the heat equation: a step of duration t widens a bump's variance by t. Differences are taken over h pixels.
// The symbol of the step is then at most 4 t / h^2 (with s = sin(a/2), c = cos(a/2) along each axis, the mixed term is at
// most that of s c, and A s^2 (1 + c^2) <= A), so that it is stable up to t = h^2 / 2 and changes no mode's sign up to
// h^2 / 4. That is where h is put: a wide filter in few steps takes differences further apart, not longer steps.
#import meniscus::tally::count
#import meniscus::covered::{CoveredPixels, unpack_pixel}
#import meniscus::camera::Camera
#import meniscus::key::{distance_of, is_gap, key_per_distance}
#import meniscus::smoothing::sigma_in_px

struct CurvatureFlow {
    // Standard deviation of the whole flow in spacings; the fraction of its square that is this step's.
    sigma_spacings: f32,
    share: f32,
    spacing_per_radius: f32,
    // What bends more than this within a difference is beside the edge of a surface; radii.
    range_radii: f32,
}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> flow: CurvatureFlow;
// Its y: radii.
@group(0) @binding(2) var front: texture_2d<f32>;
@group(0) @binding(3) var source: texture_2d<f32>;
@group(0) @binding(4) var smoothed: texture_storage_2d<r32float, write>;
@group(0) @binding(5) var<storage, read> covered: CoveredPixels;

// Below this nothing moves by more than rounding.
const LEAST_VARIANCE_PX: f32 = 1e-4;

// Slopes count up to 45 degrees: on steeper ones, and on the cliffs between particles that hide each other at grazing angles,
// the flow would come to a standstill (for which public code speeds it up on slopes without a bound, algorithms.md 5).
const MOST_SLOPE: f32 = 1.0;

// Differences along an axis.
struct Axis {
    // Pixels to each side, at least 1; 0 = across an edge at any width, where nothing flows.
    reach: f32,
    // First and second derivative, keys per pixel and per pixel squared.
    first: f32,
    second: f32,
    least: f32,
    greatest: f32,
    read: u32,
}

fn key_at(pixel: vec2<i32>) -> f32 {
    return textureLoad(source, pixel, 0).x;
}

// Takes differences as wide as `wanted`, or by halves narrower until they do not span an edge. Between whole pixels samples
// are interpolated, so that no ring shows where another pixel is reached.
fn axis_at(pixel: vec2<i32>, stride: vec2<i32>, center: f32, wanted: f32, range: f32) -> Axis {
    var read = 0u;
    var reach = wanted;
    while reach >= 1.0 {
        let inner = i32(reach);
        let part = fract(reach);
        // Not beyond the border where nothing is taken from there.
        let outer = inner + select(0, 1, part > 0.0);
        let near = vec2(key_at(pixel + inner * stride), key_at(pixel - inner * stride));
        let far = vec2(key_at(pixel + outer * stride), key_at(pixel - outer * stride));
        read += 4u;
        if !is_gap(min(min(near.x, near.y), min(far.x, far.y))) {
            let sides = mix(near, far, part);
            let bend = (sides.x - center) - (center - sides.y);
            // Neither may lie across an edge.
            let most = max(abs((near.x - center) - (center - near.y)), abs((far.x - center) - (center - far.y)));
            if most < range {
                // Fades over the outer half of the range, so that no streak shows where it ends.
                let kept = min(2.0 - 2.0 * most / range, 1.0);
                let squared = mix(f32(inner * inner), f32(outer * outer), part);
                let first = 0.5 * (sides.x - sides.y) / reach;
                let least = min(sides.x, sides.y);
                return Axis(reach, first, kept * bend / squared, least, max(sides.x, sides.y), read);
            }
        }
        reach = select(0.5 * reach, 1.0, reach > 1.0 && reach < 2.0);
    }
    return Axis(0.0, 0.0, 0.0, center, center, read);
}

// A key that has flowed.
struct Flowed {
    key: f32,
    // Samples read besides the pixel's own.
    taps: u32,
}

fn flow_pixel(id: vec2<u32>) -> Flowed {
    let pixel = vec2<i32>(id);
    let center = key_at(pixel);
    let d = distance_of(camera, center);
    let r = textureLoad(front, pixel, 0).y;
    let sigma_px = sigma_in_px(camera, flow.sigma_spacings * flow.spacing_per_radius, d, r);
    let wished = flow.share * sigma_px * sigma_px;
    if wished < LEAST_VARIANCE_PX {
        return Flowed(center, 0u);
    }
    let range = max(flow.range_radii * r * key_per_distance(camera, center), 1e-30);
    let wanted = max(2.0 * sqrt(wished), 1.0);
    let room = vec2<f32>(min(id, camera.size_px - 1u - id));
    let x = axis_at(pixel, vec2(1, 0), center, min(wanted, room.x), range);
    let y = axis_at(pixel, vec2(0, 1), center, min(wanted, room.y), range);
    var read = x.read + y.read;
    var least = min(min(x.least, y.least), center);
    var greatest = max(max(x.greatest, y.greatest), center);

    var variance = wished;
    if x.reach > 0.0 {
        variance = min(variance, 0.25 * x.reach * x.reach);
    }
    if y.reach > 0.0 {
        variance = min(variance, 0.25 * y.reach * y.reach);
    }
    var mixed = 0.0;
    if x.reach > 0.0 && y.reach > 0.0 {
        let fall = vec2<i32>(vec2(x.reach, y.reach));
        let rise = fall * vec2(1, -1);
        let falling = vec2(key_at(pixel + fall), key_at(pixel - fall));
        let rising = vec2(key_at(pixel - rise), key_at(pixel + rise));
        read += 4u;
        if !is_gap(min(min(falling.x, falling.y), min(rising.x, rising.y))) {
            let twist = (falling.x - rising.x) + (falling.y - rising.y);
            if abs(twist) < range {
                let kept = min(2.0 - 2.0 * abs(twist) / range, 1.0);
                mixed = kept * 0.25 * twist / f32(fall.x * fall.y);
            }
        }
    }
    // Depth per width: keys per pixel, over keys per depth, times pixels per width.
    let per_key = camera.px_per_world_at_one / select(center, 1.0, camera.orthographic != 0u);
    let steep = per_key * vec2(x.first, y.first);
    let limited = steep / max(length(steep) / MOST_SLOPE, 1.0);
    let p = limited.x;
    let q = limited.y;
    let bending = (1.0 + q * q) * x.second + (1.0 + p * p) * y.second - 2.0 * p * q * mixed;
    let moved = center + 0.5 * variance * bending / (1.0 + p * p + q * q);
    // A flow makes no new extremes; the mixed difference alone could.
    return Flowed(clamp(moved, least, greatest), read);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    var taps = 0u;
    let end = covered.count;
    for (var i = id.x; i < end; i += groups.x * 64u) {
        let pixel = unpack_pixel(covered.packed[i]);
        let found = flow_pixel(pixel);
#ifdef LAST
        textureStore(smoothed, pixel, vec4(distance_of(camera, found.key)));
#else
        textureStore(smoothed, pixel, vec4(found.key));
#endif
        taps += found.taps;
    }
    count(taps);
}
