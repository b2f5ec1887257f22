//! A camera as chunks see it.

use glam::{Mat4, Vec2, Vec3};
use meniscus_core::{Aabb, Camera, Frustum};
use meniscus_gpu::role::Occludee;

/// How far the source's peripheral fall-off goes, and where it stops (\[T\] equation 3.1).
const FALL_OFF: f32 = 0.7;
const FALL_OFF_FLOOR: f32 = 0.3;

pub(crate) struct View {
    camera: Camera,
    size_px: [u32; 2],
    view_from_world: Mat4,
    forward: Vec3,
    frustum: Frustum,
    /// Of the camera, for every chunk: it takes a tangent.
    half_extent: Vec2,
    px_per_world_at_one: f32,
}

/// The part of the picture that a group of particles can show in.
pub(crate) struct Silhouette {
    /// Distance that none of them comes nearer than.
    pub(crate) front: f32,
    /// First and last tile, column and row.
    pub(crate) first_tile: [u32; 2],
    pub(crate) last_tile: [u32; 2],
}

impl View {
    /// The camera must be valid and the picture not empty.
    pub(crate) fn new(camera: &Camera, size_px: [u32; 2]) -> Self {
        Self {
            camera: *camera,
            size_px,
            view_from_world: camera.view_from_world(),
            forward: camera.forward(),
            frustum: camera.frustum(size_px),
            half_extent: camera.half_extent(size_px),
            px_per_world_at_one: camera.px_per_world(size_px, 1.0),
        }
    }

    /// Whether a sphere of this radius around any point of the box may reach into the frustum. Never wrongly `false`.
    pub(crate) fn sees(&self, centers: &Aabb, radius_world: f32) -> bool {
        self.frustum.sees(centers, radius_world)
    }

    /// Distance of the box's nearest point along the view axis, world units; negative behind the eye.
    pub(crate) fn nearest(&self, bounds: &Aabb) -> f32 {
        let reach = self.forward.abs().dot(bounds.extent() * 0.5);
        self.forward.dot(bounds.center() - self.camera.eye) - reach
    }

    /// Where spheres of this radius around points of the box can show, `None` where one of them reaches before the near
    /// plane. Never too small.
    pub(crate) fn silhouette(&self, centers: &Aabb, radius_world: f32) -> Option<Silhouette> {
        // A cube holds the sphere, so that the inflated box holds all spheres; in front of the eye its projection is inside
        // that of its corners.
        let corners = centers
            .inflated(radius_world)
            .corners()
            .map(|corner| self.view_from_world.transform_point3(corner));
        // As many ulps of the largest term as the transforms here and in the shader may be off.
        let scale = centers.center().abs().max_element() + self.camera.eye.abs().max_element();
        let slack = 8e-6 * (scale + centers.extent().length());
        let front = corners.iter().map(|corner| -corner.z).fold(f32::INFINITY, f32::min) - slack;
        if front.is_nan() || front <= self.camera.near {
            return None;
        }
        let half = self.half_extent;
        let size = Vec2::new(self.size_px[0] as f32, self.size_px[1] as f32);
        let to_px = |corner: &Vec3| {
            let distance = if self.camera.is_orthographic() { 1.0 } else { -corner.z };
            (corner.truncate() / (half * distance) * Vec2::new(0.5, -0.5) + 0.5) * size
        };
        let first = corners.iter().map(to_px).fold(Vec2::INFINITY, Vec2::min);
        let last = corners.iter().map(to_px).fold(Vec2::NEG_INFINITY, Vec2::max);
        // Two pixels around, for the splats that are drawn as a point, and what rounding may move. The casts saturate.
        let margin = 2.0 + slack * self.px_per_world(front);
        let tile = |px: Vec2| (px.clamp(Vec2::ZERO, size - 1.0) / Occludee::TILE_PX as f32).as_uvec2().into();
        Some(Silhouette { front, first_tile: tile(first - margin), last_tile: tile(last + margin) })
    }

    /// Unit view direction, world.
    pub(crate) fn forward(&self) -> Vec3 {
        self.forward
    }

    /// Direction from a point towards the eye, unit length.
    pub(crate) fn towards_eye(&self, point: Vec3) -> Vec3 {
        if self.camera.is_orthographic() {
            -self.forward
        } else {
            (self.camera.eye - point).normalize_or_zero()
        }
    }

    /// Pixels per world unit at this view distance, or at the near plane where that is farther.
    pub(crate) fn px_per_world(&self, distance: f32) -> f32 {
        let distance = if self.camera.is_orthographic() { 1.0 } else { distance.max(self.camera.near) };
        self.px_per_world_at_one / distance
    }

    /// Diameter in pixels of a sphere at this view distance, or at the near plane where that is farther.
    pub(crate) fn diameter_px(&self, radius_world: f32, distance: f32) -> f32 {
        2.0 * radius_world * self.px_per_world(distance)
    }

    /// Half size in pixels that the outline of a sphere does not exceed whose centre is at least so far away, wherever it is in the
    /// picture; infinite where it may reach the eye. Towards the corners outlines are stretched (`algorithms.md` 1.2).
    pub(crate) fn most_half_px(&self, radius_world: f32, distance: f32) -> f32 {
        let half_px = 0.5 * self.diameter_px(radius_world, distance);
        if self.camera.is_orthographic() {
            return half_px;
        }
        let relative = radius_world / distance;
        if !(relative > 0.0 && relative < 1.0) {
            return if radius_world > 0.0 { f32::INFINITY } else { 0.0 };
        }
        // Of those in view, centres lie a radius outside at most.
        let corner = self.half_extent + relative;
        half_px * (1.0 + corner.length_squared()).sqrt() / (1.0 - relative * relative)
    }

    /// View distance of a point, at least the near distance; world units.
    pub(crate) fn distance(&self, point: Vec3) -> f32 {
        (-self.view_from_world.transform_point3(point).z).max(self.camera.near)
    }

    /// The source's peripheral fall-off `max(1 - 0.7 d_c/d_max, 0.3)` of a point: 1 at the picture's centre, 0.3 in its
    /// corners and beyond.
    pub(crate) fn fall_off(&self, point: Vec3) -> f32 {
        let from_center = self.view_from_world.transform_point3(point).truncate().length();
        let scale = if self.camera.is_orthographic() { 1.0 } else { self.distance(point) };
        let to_corner = self.half_extent.length() * scale;
        (1.0 - FALL_OFF * from_center / to_corner).max(FALL_OFF_FLOOR)
    }
}

#[cfg(test)]
mod tests {
    use meniscus_core::Projection;

    use super::*;

    #[test]
    fn the_fall_off_is_one_in_the_centre_and_three_tenths_in_the_corners() {
        for projection in
            [Projection::Perspective { fovy_rad: 1.0 }, Projection::Orthographic { height_world: 6.0 }]
        {
            let camera =
                Camera { eye: Vec3::Z * 5.0, target: Vec3::ZERO, up: Vec3::Y, projection, near: 0.1 };
            let size = [640, 480];
            let view = View::new(&camera, size);
            let scale = if camera.is_orthographic() { 1.0 } else { 5.0 };
            let corner = (camera.half_extent(size) * scale).extend(0.0);
            for (point, expected) in
                [(Vec3::ZERO, 1.0), (corner, 0.3), (corner * 0.5, 0.65), (corner * 3.0, 0.3)]
            {
                // 1e-6: f32 rounding of numbers of size one.
                assert!((view.fall_off(point) - expected).abs() < 1e-6, "{point}");
            }
            assert!((view.distance(Vec3::ZERO) - 5.0).abs() < 1e-6);
        }
    }

    #[test]
    fn no_outline_is_larger_than_the_bound() {
        let size = [640, 480];
        let camera = Camera {
            eye: Vec3::ZERO,
            target: -Vec3::Z,
            up: Vec3::Y,
            projection: Projection::Perspective { fovy_rad: 1.5 },
            near: 0.01,
        };
        let view = View::new(&camera, size);
        let px_per_plane = size[1] as f32 / (2.0 * camera.half_extent(size).y);
        for radius in [0.001, 0.1, 0.5, 0.9] {
            let bound = view.most_half_px(radius, 1.0);
            let mut largest: f32 = 0.0;
            for (x, d) in [-1.0, -0.5, 0.0, 1.0].into_iter().flat_map(|x| [(x, 1.0), (x, 1.5), (x, 40.0)]) {
                // Half of what lies between the tangents of the rays that touch the sphere, `algorithms.md` 1.2.
                let x = x * (camera.half_extent(size).x * d + radius);
                let half = radius * (x * x + d * d - radius * radius).sqrt() / (d * d - radius * radius);
                largest = largest.max(half * px_per_plane);
            }
            assert!(largest <= bound && bound < 2.0 * largest, "{radius}: {largest} of {bound} px");
        }
        for (radius, distance, bound) in
            [(1.0, 0.5, f32::INFINITY), (1.0, -3.0, f32::INFINITY), (0.0, -3.0, 0.0)]
        {
            assert_eq!(view.most_half_px(radius, distance), bound, "{radius} {distance}");
        }
    }

    #[test]
    fn a_silhouette_holds_all_spheres_of_its_box() {
        let (radius, size) = (0.3, [640u32, 480]);
        for projection in
            [Projection::Perspective { fovy_rad: 1.0 }, Projection::Orthographic { height_world: 6.0 }]
        {
            let camera = Camera {
                eye: Vec3::new(4.0, -3.0, 2.0),
                target: Vec3::ZERO,
                up: Vec3::Z,
                projection,
                near: 0.01,
            };
            let view = View::new(&camera, size);
            let half = camera.half_extent(size);
            for center in [Vec3::ZERO, Vec3::new(0.7, 0.4, -0.5), Vec3::new(-0.6, 1.0, 0.3)] {
                let bounds = Aabb { min: center - 0.2, max: center + 0.1 };
                let found = view.silhouette(&bounds, radius).expect("in front of the eye");
                for corner in bounds.corners() {
                    for direction in 0..400 {
                        // Even over the sphere (Fibonacci).
                        let z = 1.0 - (direction as f32 + 0.5) / 200.0;
                        let angle = direction as f32 * 2.399_963;
                        let outward =
                            (Vec3::new(angle.cos(), angle.sin(), 0.0) * (1.0 - z * z).sqrt()).with_z(z);
                        let seen = view.view_from_world.transform_point3(corner + radius * outward);
                        assert!(found.front <= -seen.z, "{} in front of {}", -seen.z, found.front);
                        let distance = if camera.is_orthographic() { 1.0 } else { -seen.z };
                        let plane = seen.truncate() / (half * distance);
                        let px = (plane * Vec2::new(0.5, -0.5) + 0.5) * Vec2::new(640.0, 480.0);
                        let tile = (px / Occludee::TILE_PX as f32).floor();
                        for axis in 0..2 {
                            let range = found.first_tile[axis] as f32..=found.last_tile[axis] as f32;
                            assert!(range.contains(&tile[axis]), "{tile} not in {range:?}");
                        }
                    }
                }
            }
        }
    }
}
