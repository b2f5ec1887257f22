use glam::Vec3;
use meniscus_core::UpAxis;

/// Right-handed directions on the ground for a given up axis: east x north = up. For z up they are x and y, for y up x
/// and -z, so that the front view looks along +y or -z, as is usual for such data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UpFrame {
    /// To the right in the front view, world, unit.
    pub east: Vec3,
    /// Away from the viewer in the front view, world, unit.
    pub north: Vec3,
    /// Against gravity, world, unit.
    pub up: Vec3,
}

impl UpFrame {
    /// The frame of `up`.
    pub fn new(up: UpAxis) -> Self {
        let (east, north) = match up {
            UpAxis::X => (Vec3::Y, Vec3::Z),
            UpAxis::Y => (Vec3::X, Vec3::NEG_Z),
            UpAxis::Z => (Vec3::X, Vec3::Y),
        };
        Self { east, north, up: up.vector() }
    }

    /// The world vector with these components.
    pub fn world(&self, east: f32, north: f32, up: f32) -> Vec3 {
        self.east * east + self.north * north + self.up * up
    }

    /// The world vector of one with these components: east, north, up.
    pub fn world_of(&self, components: Vec3) -> Vec3 {
        self.world(components.x, components.y, components.z)
    }

    /// Unit direction at `azimuth_rad` (from north, clockwise seen from above) and `elevation_rad` above the horizon.
    pub fn direction(&self, azimuth_rad: f32, elevation_rad: f32) -> Vec3 {
        let (sin_a, cos_a) = azimuth_rad.sin_cos();
        let (sin_e, cos_e) = elevation_rad.sin_cos();
        self.world(sin_a * cos_e, cos_a * cos_e, sin_e)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_right_handed_and_directions_are_units() {
        for up in [UpAxis::X, UpAxis::Y, UpAxis::Z] {
            let frame = UpFrame::new(up);
            assert_eq!(frame.east.cross(frame.north), frame.up);
            // 1e-6: f32 rounding of sines and cosines.
            assert!((frame.direction(0.7, 0.4).length() - 1.0).abs() < 1e-6);
            assert!(frame.direction(0.0, 0.0).distance(frame.north) < 1e-6);
        }
    }
}
