use glam::Vec3;
use meniscus_core::{Aabb, Camera, Projection, UpAxis};

use crate::{SceneError, UpFrame};

/// Vertical field of view of automatic cameras: a 50 mm lens on 24 x 36 mm film, which does not distort.
pub const FOVY_RAD: f32 = 0.47;
/// Room around the data in the picture.
const MARGIN: f32 = 1.1;

/// Views by name, relative to the up axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NamedView {
    /// Along north.
    Front,
    /// Against north.
    Back,
    /// From the left of the front view.
    Left,
    /// From the right of the front view.
    Right,
    /// From above, north up in the picture.
    Top,
    /// From the front, right and above, along the diagonal of a cube.
    Iso,
}

impl std::str::FromStr for NamedView {
    type Err = SceneError;

    fn from_str(name: &str) -> Result<Self, SceneError> {
        Ok(match name {
            "front" => Self::Front,
            "back" => Self::Back,
            "left" => Self::Left,
            "right" => Self::Right,
            "top" => Self::Top,
            "iso" => Self::Iso,
            _ => return Err(SceneError::UnknownView { found: name.to_owned() }),
        })
    }
}

impl NamedView {
    /// The camera of this view for a picture of `size` pixels that holds all points of `outline` (world).
    pub fn camera(self, outline: &[Vec3], up: UpAxis, size: [u32; 2]) -> Camera {
        let frame = UpFrame::new(up);
        // A little from above, so that the floor is seen and the horizon lies above the water.
        let level = |east: f32, north: f32| frame.world(east, north, -0.12);
        let (direction, picture_up) = match self {
            Self::Front => (level(0.0, 1.0), frame.up),
            Self::Back => (level(0.0, -1.0), frame.up),
            Self::Left => (level(1.0, 0.0), frame.up),
            Self::Right => (level(-1.0, 0.0), frame.up),
            Self::Top => (-frame.up, frame.north),
            Self::Iso => (frame.world(-1.0, 1.0, -1.0), frame.up),
        };
        Camera::fit(&drawable(outline), direction, picture_up, FOVY_RAD, size, MARGIN)
    }
}

/// Three-quarter view from slightly above, with the longer side of the data across the picture, or from near one end of what is
/// long and narrow, that holds all points of `outline` (world). They should outline the data of the whole series, e.g. of its
/// first, middle and last frame, so that the camera can stay still.
pub fn automatic_camera(outline: &[Vec3], up: UpAxis, size: [u32; 2]) -> Camera {
    let bounds = bounds_of(outline);
    let (across, away) = facing(bounds, up);
    let along = |axis: Vec3| bounds.extent().dot(axis.abs()).max(f32::MIN_POSITIVE);
    let [width, depth, height] = [across, away, up.vector()].map(along);
    // Two-dimensional data is looked at face to face, anything with some depth, for its width or its height, from the corner.
    let corner = (depth / (0.1 * width)).max(depth / (0.3 * height)).min(1.0);
    // Across the picture, a flume would be a thread in it; seen along its length, the near end is large and all of it is there.
    let length = width / depth.max(height);
    let (sin, cos) = (0.52 * corner * ((length - 4.0) / 8.0).clamp(0.0, 1.0)).sin_cos();
    let (from_front, from_side) = (0.82 * cos - 0.46 * sin, 0.82 * sin + 0.46 * cos);
    let direction = away * from_front - across * from_side * corner - up.vector() * (0.1 + 0.34 * corner);
    Camera::fit(&drawable(outline), direction, up.vector(), FOVY_RAD, size, MARGIN)
}

/// A camera that looks down in parallel, moved back along its axis until all its rays begin above its target: below the ground
/// nothing is seen of the ground. The picture stays the same otherwise. Other cameras are left as they are, and those whose
/// picture is so high that the particles would be lost in the rounding of their distance.
#[must_use]
pub fn above_ground(camera: Camera, up: UpAxis) -> Camera {
    let Projection::Orthographic { height_world } = camera.projection else { return camera };
    let descent = -camera.forward().dot(up.vector());
    // The rays of a level view would have to begin at the horizon.
    if descent < 0.01 {
        return camera;
    }
    let lowest_under_eye = 0.5 * height_world * (1.0 - descent * descent).max(0.0).sqrt();
    let distance = camera.eye.distance(camera.target);
    let needed = lowest_under_eye / descent;
    // Half a step of f32 is then 3e-5 of the old distance, a particle of a large set some 1e-3.
    if !(distance..=1000.0 * distance).contains(&needed) {
        return camera;
    }
    Camera { eye: camera.target - camera.forward() * needed, ..camera }
}

/// Ground directions `(across, away)` of the automatic view: across the picture and away from the viewer.
pub(crate) fn facing(bounds: Aabb, up: UpAxis) -> (Vec3, Vec3) {
    let frame = UpFrame::new(up);
    let extent = bounds.extent();
    let (east, north) = (extent.dot(frame.east.abs()), extent.dot(frame.north.abs()));
    // Only a clear difference turns the view, so that nearly square data keeps the usual front.
    if north > 1.3 * east { (frame.north, -frame.east) } else { (frame.east, frame.north) }
}

fn bounds_of(points: &[Vec3]) -> Aabb {
    points.iter().fold(Aabb::EMPTY, |bounds, &p| bounds.with_point(p))
}

/// `points`, or where they are so close together that they define no view, the corners of a box around them that is a few
/// rounding steps of `f32` wide.
fn drawable(points: &[Vec3]) -> Vec<Vec3> {
    let bounds = bounds_of(points);
    if bounds.is_empty() || !bounds.extent().is_finite() {
        return Vec::new();
    }
    let least = (1e-5 * bounds.center().length()).max(1e-12);
    if bounds.extent().max_element() > least {
        points.to_vec()
    } else {
        bounds.inflated(least).corners().to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [1280, 720];

    #[test]
    fn automatic_and_named_cameras_hold_the_data_for_every_up_axis() {
        let bounds = Aabb { min: Vec3::new(-1.0, 0.0, 2.0), max: Vec3::new(3.0, 1.0, 8.0) };
        for up in [UpAxis::X, UpAxis::Y, UpAxis::Z] {
            let views =
                ["front", "back", "left", "right", "top", "iso"].map(|v| v.parse::<NamedView>().unwrap());
            let named = views.map(|v| v.camera(&bounds.corners(), up, SIZE));
            for camera in named.into_iter().chain([automatic_camera(&bounds.corners(), up, SIZE)]) {
                camera.validate().unwrap();
                for (n, d) in camera.frustum(SIZE).planes {
                    assert!(bounds.corners().iter().all(|&c| n.dot(c) + d >= 0.0), "{up:?} {camera:?}");
                }
            }
            assert!(
                automatic_camera(&bounds.corners(), up, SIZE).forward().dot(up.vector()) < -0.2,
                "from above"
            );
        }
    }

    #[test]
    fn parallel_views_from_above_begin_above_the_ground() {
        let bounds = Aabb { min: Vec3::new(-1.0, 0.0, 2.0), max: Vec3::new(3.0, 1.0, 8.0) };
        for up in [UpAxis::X, UpAxis::Y, UpAxis::Z] {
            let views = ["front", "left", "top", "iso"].map(|v| v.parse::<NamedView>().unwrap());
            let cameras = views.map(|view| view.camera(&bounds.corners(), up, SIZE));
            for (camera, height_world) in cameras.into_iter().flat_map(|c| [(c, 0.1), (c, 10.0), (c, 90.0)]) {
                let projection = Projection::Orthographic { height_world };
                let moved = above_ground(Camera { projection, ..camera }, up);
                moved.validate().unwrap();
                // Looking straight down, nothing but rounding is left of it.
                let upright = up.vector() - moved.forward() * moved.forward().dot(up.vector());
                let picture_up = if upright.length() > 1e-3 { upright.normalize() } else { moved.up };
                let lowest = moved.eye - 0.5 * height_world * picture_up;
                // Rounding of coordinates that are hundreds of units large.
                assert!((lowest - moved.target).dot(up.vector()) > -1e-3, "{up:?} {height_world}");
                assert!((moved.forward() - camera.forward()).length() < 1e-5, "the same direction");
                let aside = (moved.eye - camera.eye).cross(camera.forward());
                assert!(aside.length() < 1e-3, "along the axis");
                assert_eq!(above_ground(camera, up), camera, "perspective");
                let huge = Camera { projection: Projection::Orthographic { height_world: 1e30 }, ..camera };
                assert_eq!(above_ground(huge, up), huge);
            }
        }
    }

    #[test]
    fn named_views_look_where_their_names_say() {
        let corners = Aabb { min: Vec3::splat(-1.0), max: Vec3::ONE }.corners();
        for up in [UpAxis::X, UpAxis::Y, UpAxis::Z] {
            let frame = UpFrame::new(up);
            for (name, direction) in [
                ("front", frame.north),
                ("back", -frame.north),
                // From the left one looks to the right.
                ("left", frame.east),
                ("right", -frame.east),
                ("top", -frame.up),
                ("iso", (frame.north - frame.east - frame.up).normalize()),
            ] {
                let camera = name.parse::<NamedView>().unwrap().camera(&corners, up, SIZE);
                // Level views look down by 7 degrees, whose cosine is 0.993.
                assert!(camera.forward().dot(direction) > 0.99, "{name}, {up:?} up: {}", camera.forward());
            }
        }
    }

    #[test]
    fn a_sheet_is_looked_at_face_to_face() {
        let sheet = Aabb { min: Vec3::ZERO, max: Vec3::new(4.0, 2.0, 0.0) };
        assert!(automatic_camera(&sheet.corners(), UpAxis::Y, SIZE).forward().z.abs() > 0.99);
        let block = Aabb { min: Vec3::ZERO, max: Vec3::new(4.0, 2.0, 3.0) };
        assert!(automatic_camera(&block.corners(), UpAxis::Y, SIZE).forward().z.abs() < 0.9);
    }

    /// As deep as it is high, a fiftieth of its length: no sheet, although it is as thin beside its length as one.
    #[test]
    fn a_flume_is_looked_at_along_its_length() {
        for (length, direction) in [(50.0, Vec3::X), (4.0, Vec3::Z)] {
            let flume = Aabb { min: Vec3::ZERO, max: Vec3::new(length, 1.0, 1.0) };
            let camera = automatic_camera(&flume.corners(), UpAxis::Y, SIZE);
            let forward = camera.forward().abs();
            assert!(forward.dot(direction) > 0.7, "{length}: {forward}");
            for (n, d) in camera.frustum(SIZE).planes {
                assert!(flume.corners().iter().all(|&c| n.dot(c) + d >= 0.0), "{length}: {camera:?}");
            }
        }
    }

    #[test]
    fn the_long_side_lies_across_the_picture() {
        let long_north = Aabb { min: Vec3::ZERO, max: Vec3::new(1.0, 4.0, 1.0) };
        let forward = automatic_camera(&long_north.corners(), UpAxis::Z, SIZE).forward();
        assert!(forward.x.abs() > forward.y.abs(), "{forward}");
    }

    #[test]
    fn degenerate_data_still_gives_a_camera() {
        let flat = [Vec3::ZERO, Vec3::X, Vec3::Z];
        for outline in [&[Vec3::splat(5e5)][..], &flat, &[], &[Vec3::NAN]] {
            automatic_camera(outline, UpAxis::Y, [1, 1]).validate().unwrap();
            NamedView::Top.camera(outline, UpAxis::Z, SIZE).validate().unwrap();
        }
        assert!("side".parse::<NamedView>().unwrap_err().to_string().contains("front, back"));
    }
}
