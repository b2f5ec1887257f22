use glam::camera::rh::view::look_at_mat4;
use glam::{Mat4, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use crate::{Aabb, Frustum};

/// How view space is mapped to the picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Projection {
    /// Pinhole; vertical field of view in radians, in (0, pi).
    Perspective {
        /// Vertical field of view, radians.
        fovy_rad: f32,
    },
    /// Parallel; full height of the picture in world units, > 0.
    Orthographic {
        /// Full picture height, world units.
        height_world: f32,
    },
}

/// A camera in world space (file coordinates minus the series' origin).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Eye position, world.
    pub eye: Vec3,
    /// Point looked at, world.
    pub target: Vec3,
    /// Direction that points up in the picture; need not be perpendicular to the view axis.
    pub up: Vec3,
    /// Perspective or parallel.
    pub projection: Projection,
    /// Nearest distance drawn, world units, > 0. Particles right in front of the eye break screen-space smoothing.
    pub near: f32,
}

/// Why a camera cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// A number is NaN or infinite.
    #[error("camera {0} is not finite; give finite numbers")]
    NotFinite(&'static str),
    /// Eye and target coincide.
    #[error(
        "camera eye and target are the same point, or too near to each other to be told apart; move one of them"
    )]
    NoDirection,
    /// Up is zero or along the view axis.
    #[error("camera up vector {0:?} is zero or parallel to the view direction; give another --camera up")]
    BadUp([f32; 3]),
    /// Field of view or height out of range.
    #[error("camera {name} is {found}, expected {expected}")]
    OutOfRange {
        /// Which parameter.
        name: &'static str,
        /// The value found.
        found: f32,
        /// What is allowed.
        expected: &'static str,
    },
}

impl Camera {
    /// Checks that the camera defines a picture.
    ///
    /// # Errors
    /// [`CameraError`] names the first offending part.
    pub fn validate(&self) -> Result<(), CameraError> {
        for (name, v) in [("eye", self.eye), ("target", self.target), ("up", self.up)] {
            if !v.is_finite() {
                return Err(CameraError::NotFinite(name));
            }
        }
        let forward = self.target - self.eye;
        if forward.length_squared() == 0.0 {
            return Err(CameraError::NoDirection);
        }
        if !forward.length_squared().is_finite() {
            return Err(CameraError::OutOfRange {
                name: "distance from eye to target",
                found: forward.as_dvec3().length() as f32,
                expected: "less than 1e19",
            });
        }
        let side = forward.normalize().cross(self.up.normalize_or_zero());
        // 1e-4: the sine of 0.006 degrees, below which the f32 cross product is mostly rounding.
        if !side.is_finite() || side.length() < 1e-4 {
            return Err(CameraError::BadUp(self.up.to_array()));
        }
        match self.projection {
            Projection::Perspective { fovy_rad } if !(fovy_rad > 1e-3 && fovy_rad < 3.1) => {
                Err(CameraError::OutOfRange {
                    name: "vertical field of view (radians)",
                    found: fovy_rad,
                    expected: "between 0.001 and 3.1 (0.06 to 177 degrees)",
                })
            }
            Projection::Orthographic { height_world }
                if !(height_world > 0.0 && height_world.is_finite()) =>
            {
                Err(CameraError::OutOfRange {
                    name: "orthographic height",
                    found: height_world,
                    expected: "a positive length",
                })
            }
            _ if !(self.near > 0.0 && self.near.is_finite()) => Err(CameraError::OutOfRange {
                name: "near distance",
                found: self.near,
                expected: "a positive length",
            }),
            _ => Ok(()),
        }
    }

    /// Unit view direction, world.
    pub fn forward(&self) -> Vec3 {
        (self.target - self.eye).normalize()
    }

    /// Rigid transform from world to view space (right-handed, camera looks along -z).
    pub fn view_from_world(&self) -> Mat4 {
        look_at_mat4(self.eye, self.target, self.up)
    }

    /// Half width and half height of the picture: at distance 1 for perspective (tangents), at any distance for
    /// parallel projection (world units). `size` is `[width, height]` in pixels.
    pub fn half_extent(&self, size: [u32; 2]) -> Vec2 {
        let aspect = size[0] as f32 / size[1] as f32;
        let half_height = match self.projection {
            Projection::Perspective { fovy_rad } => (fovy_rad * 0.5).tan(),
            Projection::Orthographic { height_world } => height_world * 0.5,
        };
        Vec2::new(half_height * aspect, half_height)
    }

    /// Pixels per world unit at view distance `distance` (`ppu` of `algorithms.md` 0).
    pub fn px_per_world(&self, size: [u32; 2], distance: f32) -> f32 {
        let at_one = size[1] as f32 / (2.0 * self.half_extent(size).y);
        match self.projection {
            Projection::Perspective { .. } => at_one / distance,
            Projection::Orthographic { .. } => at_one,
        }
    }

    /// Whether the projection is parallel.
    pub fn is_orthographic(&self) -> bool {
        matches!(self.projection, Projection::Orthographic { .. })
    }

    /// What it can see in a picture of `size` pixels.
    pub fn frustum(&self, size: [u32; 2]) -> Frustum {
        let world_from_view = self.view_from_world().inverse();
        Frustum::new(world_from_view, self.half_extent(size), self.is_orthographic(), self.near)
    }

    /// The nearest perspective camera that looks along `direction` (world, towards the scene) and has all of `points` (world)
    /// in a picture of `size` pixels, centred in the direction that leaves room; `margin` 1.0 touches the border, 1.1 leaves
    /// ten percent. Without points it looks at the origin.
    pub fn fit(
        points: &[Vec3],
        direction: Vec3,
        up: Vec3,
        fovy_rad: f32,
        size: [u32; 2],
        margin: f32,
    ) -> Self {
        let direction = direction.normalize();
        let bounds = points.iter().fold(Aabb::EMPTY, |bounds, &p| bounds.with_point(p));
        let (middle, reach) = match bounds.extent().length() {
            _ if bounds.is_empty() => (Vec3::ZERO, 1.0),
            0.0 => (bounds.center(), 1.0),
            diagonal => (bounds.center(), diagonal),
        };
        let mut camera = Self {
            eye: middle - direction * reach,
            target: middle,
            up,
            projection: Projection::Perspective { fovy_rad },
            near: reach * 1e-3,
        };
        // In coordinates (right, up, forward) around `middle`, a point (a, b, c) is inside for an eye (x, y, z) when
        // |a - x| <= half.x (c - z) and |b - y| <= half.y (c - z). Per axis that is x >= left + half z and x <= right - half z
        // with left = max(a - half c) and right = min(a + half c): z can grow to (right - left) / (2 half), in both axes.
        let half = camera.half_extent(size) / margin;
        let view = look_at_mat4(middle - direction, middle, up);
        let (mut low, mut high) = (Vec2::NEG_INFINITY, Vec2::INFINITY);
        for &point in points {
            let v = view.transform_point3(point);
            let forward = -v.z - 1.0;
            low = low.max(v.truncate() - half * forward);
            high = high.min(v.truncate() + half * forward);
        }
        if !(low.is_finite() && high.is_finite()) {
            return camera;
        }
        // A single point fits at any distance; stay a fifth of the data away from what is nearest.
        let forward = ((high - low) / (2.0 * half)).min_element().min(-reach * 0.2);
        let center = (low + high) * 0.5;
        let axes = view.inverse();
        let side = axes.transform_vector3(Vec3::new(center.x, center.y, 0.0));
        camera.eye = middle + side + direction * forward;
        camera.target = middle + side;
        camera
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(projection: Projection) -> Camera {
        Camera { eye: Vec3::new(3.0, 2.0, 5.0), target: Vec3::ZERO, up: Vec3::Y, projection, near: 0.1 }
    }

    /// A mirrored world would look just as good.
    #[test]
    fn right_is_right_and_up_is_up() {
        for (eye, up, right) in
            [(Vec3::Z, Vec3::Y, Vec3::X), (Vec3::NEG_Y, Vec3::Z, Vec3::X), (Vec3::X, Vec3::Y, Vec3::NEG_Z)]
        {
            let camera = Camera { eye: eye * 5.0, up, ..camera(Projection::Perspective { fovy_rad: 1.0 }) };
            let view = camera.view_from_world();
            // 1e-6: f32 rounding of unit vectors.
            for (world, expected) in [(right, Vec3::X), (up, Vec3::Y), (eye, Vec3::Z)] {
                assert!(view.transform_vector3(world).distance(expected) < 1e-6, "{world} from {eye}");
            }
        }
    }

    #[test]
    fn points_on_the_picture_border_lie_on_the_frustum_planes() {
        let size = [640, 480];
        for projection in
            [Projection::Perspective { fovy_rad: 1.0 }, Projection::Orthographic { height_world: 4.0 }]
        {
            let camera = camera(projection);
            let half = camera.half_extent(size);
            let distance = 3.0;
            let scale = if camera.is_orthographic() { 1.0 } else { distance };
            let left = Vec3::new(-half.x * scale, 0.0, -distance);
            let world = camera.view_from_world().inverse().transform_point3(left);
            let planes = camera.frustum(size).planes;
            // 1e-5: f32 rounding of coordinates of size 5.
            assert!((planes[0].0.dot(world) + planes[0].1).abs() < 1e-5);
            for (n, d) in &planes[1..] {
                assert!(n.dot(world) + d > 0.1);
            }
        }
    }

    #[test]
    fn fit_puts_every_corner_inside_and_one_on_the_margin() {
        let wide = Aabb { min: Vec3::new(-1.0, 0.0, -3.0), max: Vec3::new(2.0, 1.0, 4.0) };
        let tall = Aabb { min: Vec3::new(-1.0, 0.0, -1.0), max: Vec3::new(1.0, 9.0, 1.0) };
        check_fit(wide, 0);
        check_fit(tall, 1);
    }

    /// `tight`: the axis of the picture, 0 across and 1 up, in which the box touches both margins.
    fn check_fit(bounds: Aabb, tight: usize) {
        let size = [1280, 720];
        let camera = Camera::fit(&bounds.corners(), Vec3::new(-1.0, -0.5, -1.0), Vec3::Y, 0.8, size, 1.1);
        camera.validate().unwrap();
        let half = camera.half_extent(size);
        let view = camera.view_from_world();
        let projected = bounds.corners().map(|corner| {
            let v = view.transform_point3(corner);
            v.truncate() / -v.z / half
        });
        let low = projected.iter().copied().reduce(Vec2::min).unwrap();
        let high = projected.iter().copied().reduce(Vec2::max).unwrap();
        // 1e-4: f32 rounding of sums of a few terms of size 5.
        let limit = 1.0 / 1.1;
        assert!(low.min_element() > -limit - 1e-4 && high.max_element() < limit + 1e-4, "{low} {high}");
        // The tighter axis touches both margins, the other is centred as far as perspective allows.
        assert!((low[tight] + limit).abs() < 1e-4 && (high[tight] - limit).abs() < 1e-4, "{low} {high}");
        assert!((low + high).abs().max_element() < 0.2, "{low} {high}");
    }

    #[test]
    fn fit_takes_anything() {
        for points in [&[][..], &[Vec3::ONE], &[Vec3::ZERO, Vec3::Z * 1e6], &[Vec3::NAN]] {
            Camera::fit(points, Vec3::NEG_Y + Vec3::X, Vec3::Z, 0.5, [640, 480], 1.1).validate().unwrap();
        }
    }

    #[test]
    fn unusable_cameras_are_refused() {
        let good = camera(Projection::Perspective { fovy_rad: 1.0 });
        assert_eq!(good.validate(), Ok(()));
        let bad = |change: fn(&mut Camera)| {
            let mut c = good;
            change(&mut c);
            c.validate().unwrap_err()
        };
        assert!(matches!(bad(|c| c.eye.x = f32::NAN), CameraError::NotFinite("eye")));
        assert!(matches!(bad(|c| c.target = c.eye), CameraError::NoDirection));
        let far = bad(|c| c.eye.x = 1e20);
        assert!(
            matches!(far, CameraError::OutOfRange { found, .. } if (found / 1e20 - 1.0).abs() < 1e-6),
            "{far}"
        );
        assert!(matches!(bad(|c| c.up = c.target - c.eye), CameraError::BadUp(_)));
        assert!(matches!(bad(|c| c.near = 0.0), CameraError::OutOfRange { .. }));
        assert!(matches!(
            bad(|c| c.projection = Projection::Perspective { fovy_rad: 4.0 }),
            CameraError::OutOfRange { .. }
        ));
    }
}
