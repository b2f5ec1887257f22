//! `meniscus::camera` and `meniscus::surface` for twins.

use glam::{Mat4, Vec2, Vec3};
use meniscus_gpu::CameraUniform;

/// Picture point in pixels of a view-space position in front of the camera.
pub(super) fn project_px(camera: &CameraUniform, position_view: Vec3) -> Vec2 {
    let scale = if camera.orthographic != 0 { 1.0 } else { -position_view.z };
    let ndc = position_view.truncate() / (Vec2::from(camera.half_extent) * scale);
    (ndc * Vec2::new(0.5, -0.5) + 0.5) * size(camera)
}

/// View-space position of the point at `distance` seen at `point_px`.
pub(super) fn view_position(camera: &CameraUniform, point_px: Vec2, distance: f32) -> Vec3 {
    let ndc = point_px / size(camera) * Vec2::new(2.0, -2.0) + Vec2::new(-1.0, 1.0);
    let offset = ndc * Vec2::from(camera.half_extent);
    if camera.orthographic != 0 { offset.extend(-distance) } else { (offset * distance).extend(-distance) }
}

/// Unit direction from the point towards the eye, view space.
pub(super) fn towards_eye(camera: &CameraUniform, position_view: Vec3) -> Vec3 {
    if camera.orthographic != 0 { Vec3::Z } else { -position_view.normalize() }
}

/// Pixels per world unit at `distance`.
pub(super) fn px_per_world(camera: &CameraUniform, distance: f32) -> f32 {
    camera.px_per_world_at_one / if camera.orthographic != 0 { 1.0 } else { distance }
}

/// World direction of a view-space direction.
pub(super) fn to_world(camera: &CameraUniform, direction_view: Vec3) -> Vec3 {
    Mat4::from_cols_array_2d(&camera.world_from_view).transform_vector3(direction_view)
}

/// World position of a view-space position.
pub(super) fn point_to_world(camera: &CameraUniform, position_view: Vec3) -> Vec3 {
    Mat4::from_cols_array_2d(&camera.world_from_view).transform_point3(position_view)
}

/// Unit vector from its octahedral map.
pub(super) fn unpack_normal(bits: u32) -> Vec3 {
    let snorm = |half: u32| (half as u16 as i16 as f32 / 32767.0).max(-1.0);
    let p = Vec2::new(snorm(bits), snorm(bits >> 16));
    let z = 1.0 - p.x.abs() - p.y.abs();
    let fold = (-z).max(0.0);
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    Vec3::new(p.x - fold * sign(p.x), p.y - fold * sign(p.y), z).normalize()
}

/// The sentinel of `meniscus::surface`.
pub(super) fn is_empty(distance: f32) -> bool {
    distance >= 1.7e38
}

fn size(camera: &CameraUniform) -> Vec2 {
    Vec2::new(camera.size_px[0] as f32, camera.size_px[1] as f32)
}
