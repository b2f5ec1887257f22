#define_import_path meniscus::four
#import meniscus::camera::Camera
#import meniscus::key::{is_surface, key_of, distance_of, key_per_distance, smaller_step}

// `meniscus::key` of four pixels at a time, and what neighbours along a line of the picture share.

// The four are at these places of a line.
const PLACES: vec4<i32> = vec4(0, 1, 2, 3);

fn keys_of(camera: Camera, distance: vec4<f32>) -> vec4<f32> {
    return vec4(
        key_of(camera, distance.x),
        key_of(camera, distance.y),
        key_of(camera, distance.z),
        key_of(camera, distance.w),
    );
}

fn distances_of(camera: Camera, key: vec4<f32>) -> vec4<f32> {
    return vec4(
        distance_of(camera, key.x),
        distance_of(camera, key.y),
        distance_of(camera, key.z),
        distance_of(camera, key.w),
    );
}

fn keys_per_distance(camera: Camera, key: vec4<f32>) -> vec4<f32> {
    return vec4(
        key_per_distance(camera, key.x),
        key_per_distance(camera, key.y),
        key_per_distance(camera, key.z),
        key_per_distance(camera, key.w),
    );
}

fn smaller_steps(after: vec4<f32>, center: vec4<f32>, before: vec4<f32>) -> vec4<f32> {
    return vec4(
        smaller_step(after.x, center.x, before.x),
        smaller_step(after.y, center.y, before.y),
        smaller_step(after.z, center.z, before.z),
        smaller_step(after.w, center.w, before.w),
    );
}

// Distances and radii of four pixels of `front`; no radius where there is no surface.
struct Fronts {
    distance: vec4<f32>,
    radius: vec4<f32>,
}

fn fronts_at(front: texture_2d<f32>, first: vec2<i32>, stride: vec2<i32>) -> Fronts {
    let a = textureLoad(front, first, 0);
    let b = textureLoad(front, first + stride, 0);
    let c = textureLoad(front, first + 2 * stride, 0);
    let d = textureLoad(front, first + 3 * stride, 0);
    let distance = vec4(a.x, b.x, c.x, d.x);
    let shows = vec4(is_surface(a.x), is_surface(b.x), is_surface(c.x), is_surface(d.x));
    return Fronts(distance, select(vec4(0.0), vec4(a.y, b.y, c.y, d.y), shows));
}

// The first texels of four pixels, each as far along the line of `stride` from `first` as `places` says.
fn loads_at(image: texture_2d<f32>, first: vec2<i32>, stride: vec2<i32>, places: vec4<i32>) -> vec4<f32> {
    return vec4(
        textureLoad(image, first + places.x * stride, 0).x,
        textureLoad(image, first + places.y * stride, 0).x,
        textureLoad(image, first + places.z * stride, 0).x,
        textureLoad(image, first + places.w * stride, 0).x,
    );
}
