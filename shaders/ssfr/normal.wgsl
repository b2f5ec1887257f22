// View-space normals from distances (algorithms.md 7). Along each axis the difference is taken on the side on which the
// surface continues: where extrapolation from two pixels predicts this one best.
#ifdef HARDWARE
#import meniscus::covered::{CoveredPixels, unpack_pixel}
#else
#import meniscus::picture::corner
#endif
#import meniscus::camera::{Camera, view_ray}
#import meniscus::key::{key_of, is_gap, key_per_distance, GAP}
#import meniscus::surface::pack_normal

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var distance: texture_2d<f32>;
// Its y: radii.
@group(0) @binding(2) var front: texture_2d<f32>;

// Error, in radii, below which both sides count as the same surface and are averaged.
const NOISE_RADII: f32 = 0.02;
// Smallest cosine between normal and direction to the eye.
const GRAZING: f32 = 0.02;

fn key_at(pixel: vec2<i32>, is_inside: bool) -> f32 {
    if !is_inside {
        return GAP;
    }
    return key_of(camera, textureLoad(distance, pixel, 0).x);
}

struct Side {
    difference: f32,
    weight: f32,
}

// Difference towards a neighbour `near` with its own neighbour `far` behind it; `outward` is +1 or -1.
fn side(center: f32, near: f32, far: f32, outward: f32, noise: f32) -> Side {
    if is_gap(near) {
        return Side(0.0, 0.0);
    }
    let difference = near - center;
    let error = select((far - near) - difference, difference, is_gap(far)) / noise;
    // Cut where the fourth power would overflow.
    let fourth = pow(min(abs(error), 1e7), 4.0);
    return Side(outward * difference, 1.0 / (1.0 + fourth));
}

fn slope(center: f32, at: i32, last: i32, pixel: vec2<i32>, stride: vec2<i32>, noise: f32) -> f32 {
    let after = side(center, key_at(pixel + stride, at < last), key_at(pixel + 2 * stride, at + 1 < last), 1.0, noise);
    let before = side(center, key_at(pixel - stride, at > 0), key_at(pixel - 2 * stride, at > 1), -1.0, noise);
    let weight = after.weight + before.weight;
    if weight <= 0.0 {
        return 0.0;
    }
    return (after.difference * after.weight + before.difference * before.weight) / weight;
}

// Packed.
fn normal_at(id: vec2<u32>) -> u32 {
    let pixel = vec2<i32>(id);
    let d = textureLoad(distance, pixel, 0).x;
    let is_parallel = camera.orthographic != 0u;
    let center = key_of(camera, d);
    let noise = max(NOISE_RADII * textureLoad(front, pixel, 0).y, 4e-7 * d) * key_per_distance(camera, center);
    let last = vec2<i32>(camera.size_px) - 1;
    let per_px = vec2(
        slope(center, pixel.x, last.x, pixel, vec2(1, 0), noise),
        slope(center, pixel.y, last.y, pixel, vec2(0, 1), noise),
    );
    // Key per plane coordinate: tangents (perspective) or world units.
    let gradient = per_px / (2.0 * camera.half_extent / vec2<f32>(camera.size_px)) * vec2(1.0, -1.0);
    let ray = view_ray(camera, vec2<f32>(id) + 0.5);
    // The plane n.x = c seen along the ray d (s, -1) has 1/d = (n.xy . s - n.z) / c, hence n.xy/c is the gradient of 1/d.
    // In parallel projection n.xy . o - n.z d = c, so that -n.xy/n.z is the gradient of -d.
    var n = vec3(gradient, dot(gradient, ray.step.xy) - center);
    if is_parallel {
        n = vec3(gradient, -1.0);
    }
    n = -normalize(n);
    let to_eye = -normalize(ray.step);
    let cosine = dot(n, to_eye);
    if cosine < GRAZING {
        n = normalize(n + (GRAZING - cosine) * to_eye);
    }
    return pack_normal(n);
}

#ifdef HARDWARE
@group(0) @binding(3) var<storage, read> covered: CoveredPixels;
@group(0) @binding(4) var normal: texture_storage_2d<r32uint, write>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let end = covered.count;
    for (var i = id.x; i < end; i += groups.x * 64u) {
        let pixel = unpack_pixel(covered.packed[i]);
        textureStore(normal, pixel, vec4(normal_at(pixel)));
    }
}
#else
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return corner(index);
}

@fragment
fn fragment(@builtin(position) at_px: vec4<f32>) -> @location(0) u32 {
    return normal_at(vec2<u32>(at_px.xy));
}
#endif
