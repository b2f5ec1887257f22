// Fits a plane to the surface around every pixel and takes its distance in the middle: local linear regression (Cleveland,
// J. Am. Stat. Assoc. 74, 1979) with planes as in Imai et al. 2016. What is fitted is the key of a distance, a number that
// is affine in the pixel on every plane: planes stay what they are, at any tilt, at silhouettes and at the picture's border.
#import meniscus::tally::count
#import meniscus::camera::{Camera, px_per_world}
#import meniscus::key::{distance_of, is_gap, key_of, key_per_distance}
#import meniscus::surface::NO_SURFACE

struct PlaneFit {
    // Standard deviation of the window of this pass, in drawn radii.
    sigma_radii: f32,
    // What is further in front or behind is another surface, in drawn radii.
    range_radii: f32,
}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> plane_fit: PlaneFit;
// Its y: radii.
@group(0) @binding(2) var front: texture_2d<f32>;
// Its x: distances before and after this pass.
@group(0) @binding(3) var source: texture_2d<f32>;
@group(0) @binding(4) var smoothed: texture_storage_2d<r32float, write>;

// Taps to each side; a wider window is sampled in larger steps, powers of two. Every other tap fades before they double, so
// that no ring shows where they do.
const MAX_TAPS: f32 = 8.0;
// Reach of a biweight disc per standard deviation along an axis: sqrt(8).
const REACH_PER_SIGMA: f32 = 2.828427;
// Where the window is little more than a line there is no plane to fit, and the pixel stays (1 = a full window, 0.13 = the
// quarter of one in a corner).
const TOO_THIN: f32 = 0.02;
const THICK_ENOUGH: f32 = 0.1;

// Smooth, and zero from 1 on, so that nothing jumps as pixels enter and leave the window.
fn biweight(squared: f32) -> f32 {
    let rest = max(1.0 - squared, 0.0);
    return rest * rest;
}

struct Fit {
    distance: f32,
    // Samples read.
    taps: u32,
}

fn fit(at: vec2<i32>, distance: f32, radius_world: f32) -> Fit {
    let size = vec2<i32>(camera.size_px);
    let center = key_of(camera, distance);
    let range = plane_fit.range_radii * radius_world * key_per_distance(camera, center);
    let reach_px = REACH_PER_SIGMA * plane_fit.sigma_radii * radius_world * px_per_world(camera, distance);
    // The nearest neighbours would weigh nothing; or the radius is none.
    if !(reach_px > 1.0 && reach_px < 1e9) {
        return Fit(distance, 0u);
    }
    var step = 1.0;
    while reach_px > MAX_TAPS * step {
        step *= 2.0;
    }
    let taps = i32(reach_px / step);
    let odd = 1.0 - smoothstep(0.5 * MAX_TAPS, MAX_TAPS, reach_px / step);
    var read = 0u;

    // Weighted moments of place (in reaches) and key (in ranges): of 1, x, y; of xx, xy, yy; of z, xz, yz.
    var first = vec3(0.0);
    var second = vec3(0.0);
    var keys = vec3(0.0);
    for (var j = -taps; j <= taps; j++) {
        for (var i = -taps; i <= taps; i++) {
            let offset = vec2(i, j) * i32(step);
            let tap = at + offset;
            let p = vec2<f32>(offset) / reach_px;
            if any(tap < vec2(0)) || any(tap >= size) || dot(p, p) >= 1.0 {
                continue;
            }
            let key = key_of(camera, textureLoad(source, tap, 0).x);
            read += 1u;
            if is_gap(key) {
                continue;
            }
            let z = (key - center) / range;
            let fade = select(1.0, odd, (i & 1) == 1) * select(1.0, odd, (j & 1) == 1);
            let weight = fade * biweight(dot(p, p)) * biweight(z * z);
            first += weight * vec3(1.0, p);
            second += weight * vec3(p.x * p.x, p.x * p.y, p.y * p.y);
            keys += weight * z * vec3(1.0, p);
        }
    }
    // The plane's value in the middle by Cramer's rule: cofactors of the first row of the normal equations.
    let cofactors = vec3(
        second.x * second.z - second.y * second.y,
        second.y * first.z - first.y * second.z,
        first.y * second.y - second.x * first.z,
    );
    let determinant = dot(first, cofactors);
    let spread = 0.5 * (second.x + second.z);
    let full = first.x * spread * spread;
    if determinant <= TOO_THIN * full {
        return Fit(distance, read);
    }
    let height = clamp(dot(keys, cofactors) / determinant, -1.0, 1.0);
    let trust = smoothstep(TOO_THIN, THICK_ENOUGH, determinant / full);
    // Never further back than the range, which keeps keys of near surfaces positive.
    let last = key_of(camera, distance + plane_fit.range_radii * radius_world);
    return Fit(distance_of(camera, max(center + trust * height * range, last)), read);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= camera.size_px) {
        return;
    }
    let distance = textureLoad(source, id.xy, 0).x;
    if is_gap(key_of(camera, distance)) {
        textureStore(smoothed, id.xy, vec4(NO_SURFACE));
        return;
    }
    let fitted = fit(vec2<i32>(id.xy), distance, textureLoad(front, id.xy, 0).y);
    textureStore(smoothed, id.xy, vec4(fitted.distance));
    count(fitted.taps);
}
