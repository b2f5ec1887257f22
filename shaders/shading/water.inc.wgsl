#define_import_path meniscus::water

#import meniscus::camera::{Camera, view_position, towards_eye}

// What every lighting model knows about the water surface in a pixel.

struct WaterPoint {
    position_view: vec3<f32>,
    // Unit, bent towards the eye where it would face away.
    normal_view: vec3<f32>,
    to_eye_view: vec3<f32>,
    distance: f32,
    n_v: f32,
}

// Smallest cosine between normal and view: below it, Fresnel reflectance saturates in a bright rim (algorithms.md 7).
const MIN_N_V: f32 = 0.03;

// The unit normal along `normal_view`, bent towards the eye where it would face away.
fn faced(normal_view: vec3<f32>, to_eye: vec3<f32>) -> vec3<f32> {
    // Normals that cancel say nothing: face the eye.
    let size = length(normal_view);
    let normal = select(to_eye, normal_view / max(size, 1e-3), size > 1e-3);
    let facing = dot(normal, to_eye);
    return select(normal, normalize(normal + (MIN_N_V - facing) * to_eye), facing < MIN_N_V);
}

// `normal_view` need not be of unit length.
fn water_point(camera: Camera, pixel: vec2<u32>, distance: f32, normal_view: vec3<f32>) -> WaterPoint {
    let position = view_position(camera, vec2<f32>(pixel) + 0.5, distance);
    let to_eye = towards_eye(camera, position);
    let normal = faced(normal_view, to_eye);
    return WaterPoint(position, normal, to_eye, distance, clamp(dot(normal, to_eye), MIN_N_V, 1.0));
}
