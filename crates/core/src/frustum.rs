use glam::{Mat4, Vec2, Vec3};

use crate::Aabb;

/// What a camera can see: world space inside of five planes; there is no far one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum {
    /// Unit normals and offsets of left, right, bottom, top and near, pointing inwards: `dot(n, p) + d >= 0` inside.
    pub planes: [(Vec3, f32); 5],
}

impl Frustum {
    /// Of a camera with this rigid transform out of view space, tangents of its half angles (perspective) or half sizes in world units
    /// (parallel), and nearest distance.
    pub fn new(world_from_view: Mat4, half_extent: Vec2, is_orthographic: bool, near: f32) -> Self {
        let plane = |normal_view: Vec3, point_view: Vec3| {
            let n = world_from_view.transform_vector3(normal_view).normalize();
            (n, -n.dot(world_from_view.transform_point3(point_view)))
        };
        // A side of the picture, by the direction inwards.
        let side = |inwards: Vec2| {
            let half = half_extent.dot(inwards.abs());
            if is_orthographic {
                plane(inwards.extend(0.0), (-half * inwards).extend(0.0))
            } else {
                plane(inwards.extend(-half), Vec3::ZERO)
            }
        };
        let front = plane(Vec3::NEG_Z, Vec3::new(0.0, 0.0, -near));
        Self { planes: [side(Vec2::X), side(Vec2::NEG_X), side(Vec2::Y), side(Vec2::NEG_Y), front] }
    }

    /// Whether a sphere of this radius around any point of the box may reach into it. Never wrongly `false`.
    pub fn sees(&self, centers: &Aabb, radius_world: f32) -> bool {
        let (center, half) = (centers.center(), centers.extent() * 0.5);
        self.planes.iter().all(|&(normal, offset)| {
            let reach = normal.abs().dot(half) + radius_world;
            // A few ulps of the largest term, which the sum below may cancel.
            let slack = 4e-6 * (normal.abs().dot(center.abs()) + offset.abs() + reach);
            let outside = normal.dot(center) + offset < -reach - slack;
            // An overflow to NaN is not outside.
            !outside
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Camera, Projection};

    #[test]
    fn boxes_that_reach_into_it_are_seen_and_those_beside_it_are_not() {
        for projection in
            [Projection::Perspective { fovy_rad: 0.8 }, Projection::Orthographic { height_world: 2.0 }]
        {
            let camera = Camera {
                eye: Vec3::new(0.0, -5.0, 2.0),
                target: Vec3::ZERO,
                up: Vec3::Z,
                projection,
                near: 0.1,
            };
            let frustum = camera.frustum([160, 90]);
            let boxed = |center: Vec3, size: f32| Aabb { min: center - size, max: center + size };
            // In it, around the eye with all of it inside, and with every corner outside.
            for seen in
                [boxed(Vec3::ZERO, 0.1), boxed(Vec3::ZERO, 9.0), boxed(Vec3::new(0.0, 50.0, -20.0), 40.0)]
            {
                assert!(frustum.sees(&seen, 0.0), "{projection:?}: {seen:?}");
            }
            // Right, left, below, above and behind.
            for unseen in [
                Vec3::new(6.0, 0.0, 0.0),
                Vec3::new(-6.0, 0.0, 0.0),
                Vec3::new(0.0, 0.0, -6.0),
                Vec3::new(0.0, 0.0, 6.0),
                Vec3::new(0.0, -9.0, 3.6),
            ] {
                assert!(!frustum.sees(&boxed(unseen, 0.1), 0.0), "{projection:?}: {unseen}");
            }
        }
    }
}
