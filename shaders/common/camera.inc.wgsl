#define_import_path meniscus::camera

// View space: right-handed, x right, y up, the camera looks along -z. A distance is -z, never the length of the ray.

struct Camera {
    view_from_world: mat4x4<f32>,
    world_from_view: mat4x4<f32>,
    // Tangents of the half angles (perspective) or half sizes in world units (parallel).
    half_extent: vec2<f32>,
    size_px: vec2<u32>,
    orthographic: u32,
    near_world: f32,
    px_per_world_at_one: f32,
    pad: f32,
}

// A view ray parametrised by distance: position(d) = origin + d * step, with step.z = -1.
struct ViewRay {
    origin: vec3<f32>,
    step: vec3<f32>,
}

// Ray through a point of the picture in pixels: (0, 0) is the top left corner, pixel centres lie at +0.5.
fn view_ray(camera: Camera, point_px: vec2<f32>) -> ViewRay {
    let ndc = point_px / vec2<f32>(camera.size_px) * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    let offset = ndc * camera.half_extent;
    if camera.orthographic != 0u {
        return ViewRay(vec3(offset, 0.0), vec3(0.0, 0.0, -1.0));
    }
    return ViewRay(vec3(0.0), vec3(offset, -1.0));
}

// View-space position of the point at `distance` seen at `point_px`.
fn view_position(camera: Camera, point_px: vec2<f32>, distance: f32) -> vec3<f32> {
    let ray = view_ray(camera, point_px);
    return ray.origin + distance * ray.step;
}

// Picture point in pixels of a view-space position in front of the camera.
fn project_px(camera: Camera, position_view: vec3<f32>) -> vec2<f32> {
    let scale = select(-position_view.z, 1.0, camera.orthographic != 0u);
    let ndc = position_view.xy / (camera.half_extent * scale);
    return (ndc * vec2(0.5, -0.5) + 0.5) * vec2<f32>(camera.size_px);
}

// Pixels per world unit at `distance`.
fn px_per_world(camera: Camera, distance: f32) -> f32 {
    return camera.px_per_world_at_one / select(distance, 1.0, camera.orthographic != 0u);
}

// Direction from the point towards the eye, unit length, view space.
fn towards_eye(camera: Camera, position_view: vec3<f32>) -> vec3<f32> {
    return select(-normalize(position_view), vec3(0.0, 0.0, 1.0), camera.orthographic != 0u);
}
