// What `meniscus::calm` reads: per block of pixels the normal of the plane that fits the surface around it best, by least squares
// with weights that fall off with distance (moving least squares, Lancaster & Salkauskas 1981) and leave out what lies on
// another surface.

#import meniscus::calm::{BLOCK_PX, NO_NORMAL}
#import meniscus::camera::{Camera, px_per_world, view_position}
#import meniscus::surface::{is_empty, pack_normal, unpack_normal}

struct Fit {
    // World units.
    spacing_world: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> fit: Fit;
@group(0) @binding(2) var distances: texture_2d<f32>;
@group(0) @binding(3) var normals: texture_2d<u32>;
@group(0) @binding(4) var blocks: texture_storage_2d<r32uint, write>;

// Samples lie on the 13 points of a diamond of a grid, so many spacings apart, with Gaussian weights of so many steps of the
// grid: what waves less than five spacings long do to refraction is lost with the noise.
const STEP_SPACINGS: f32 = 1.3;
const SIGMA_STEPS: f32 = 1.3;
const MOST_STEP_PX: f32 = 1e4;
// Fully on the surface is what deviates this much from the plane of the pixel's own normal, and not at all what deviates twice that.
const RANGE_SPACINGS: f32 = 0.5;
// Pulls the fit towards the pixel's own plane where few samples are left: a tenth of the second moment of all of them, steps
// squared.
const RIDGE: f32 = 1.2;

// Distance of the water in a pixel; negative where there is none, also outside of the picture.
fn water_at(pixel: vec2<i32>) -> f32 {
    let is_inside = all(pixel >= vec2(0)) && all(pixel < vec2<i32>(camera.size_px));
    let distance = textureLoad(distances, clamp(pixel, vec2(0), vec2<i32>(camera.size_px) - 1), 0).x;
    return select(-1.0, distance, is_inside && !is_empty(distance));
}

fn position_at(pixel: vec2<i32>, distance: f32) -> vec3<f32> {
    return view_position(camera, vec2<f32>(pixel) + 0.5, distance);
}

fn fitted_normal(pixel: vec2<i32>, distance: f32) -> vec3<f32> {
    let position = position_at(pixel, distance);
    let normal = unpack_normal(textureLoad(normals, pixel, 0).x);
    let across = normalize(cross(normal, select(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), abs(normal.x) > 0.7)));
    let along = cross(normal, across);
    let px = px_per_world(camera, distance);
    let step_px = i32(clamp(STEP_SPACINGS * fit.spacing_world * px, 1.0, MOST_STEP_PX));
    let step_world = f32(step_px) / px;
    let range = RANGE_SPACINGS * max(fit.spacing_world, 1e-6 * distance);

    // Moments of the samples' places (u, v) on the plane and heights above it, all in steps.
    var weight_sum = 0.0;
    var place_sum = vec2(0.0);
    var height_sum = 0.0;
    var place_squares = vec3(0.0);
    var place_heights = vec2(0.0);
    for (var y = -2; y <= 2; y++) {
        for (var x = abs(y) - 2; x <= 2 - abs(y); x++) {
            let at = pixel + step_px * vec2(x, y);
            let other = water_at(at);
            let away = (position_at(at, other) - position) / step_world;
            let height = dot(normal, away);
            let near = exp(-0.5 / (SIGMA_STEPS * SIGMA_STEPS) * f32(x * x + y * y));
            let same = clamp(2.0 - abs(height) * step_world / range, 0.0, 1.0);
            let weight = select(0.0, near * same, other > 0.0);
            // What does not count may lie anywhere, and its squares may overflow.
            let counted = select(vec3(0.0), away, weight > 0.0);
            let place = vec2(dot(across, counted), dot(along, counted));
            let rise = dot(normal, counted);
            weight_sum += weight;
            place_sum += weight * place;
            height_sum += weight * rise;
            place_squares += weight * vec3(place.x * place.x, place.x * place.y, place.y * place.y);
            place_heights += weight * rise * place;
        }
    }
    // The middle sample always counts.
    let mean = place_sum / weight_sum;
    let xx = place_squares.x - mean.x * place_sum.x + RIDGE;
    let xy = place_squares.y - mean.x * place_sum.y;
    let yy = place_squares.z - mean.y * place_sum.y + RIDGE;
    let products = place_heights - mean * height_sum;
    let slope = vec2(yy * products.x - xy * products.y, xx * products.y - xy * products.x) / (xx * yy - xy * xy);
    return normalize(normal - slope.x * across - slope.y * along);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= textureDimensions(blocks)) {
        return;
    }
    // The first pixel of the block's inner four that shows water.
    let inner = BLOCK_PX * vec2<i32>(id.xy) + BLOCK_PX / 2 - 1;
    var pixel = inner;
    var distance = -1.0;
    for (var k = 3; k >= 0; k--) {
        let candidate = inner + vec2(k & 1, k >> 1u);
        let found = water_at(candidate);
        if found > 0.0 {
            pixel = candidate;
            distance = found;
        }
    }
    var normal = NO_NORMAL;
    if distance > 0.0 {
        normal = fitted_normal(pixel, distance);
    }
    textureStore(blocks, id.xy, vec4(pack_normal(normal)));
}
