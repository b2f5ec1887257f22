//! What lenses make a picture.

use meniscus_core::{Camera, Short};
use meniscus_scene::Lens;

use crate::failure::Failure;

/// Refuses a lens from whose rim nothing is seen as it is from its middle.
pub fn check(lens: &Lens, camera: &Camera) -> Result<(), Failure> {
    let focus = lens.focus_world.unwrap_or_else(|| camera.eye.distance(camera.target));
    if camera.is_orthographic() || lens.aperture_world <= focus {
        return Ok(());
    }
    Err(Failure::Usage(format!(
        "--aperture {}: wider than the distance in focus, {}; give a hundredth of that, or set --focus",
        Short(f64::from(lens.aperture_world)),
        Short(f64::from(focus))
    )))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use meniscus_core::Projection;

    use super::*;

    #[test]
    fn a_lens_wider_than_the_distance_in_focus_is_refused() {
        let camera = Camera {
            eye: Vec3::ZERO,
            target: Vec3::X * 4.0,
            up: Vec3::Z,
            projection: Projection::Perspective { fovy_rad: 0.5 },
            near: 0.01,
        };
        let message = |aperture_world, focus_world, camera: &Camera| {
            check(&Lens { aperture_world, focus_world }, camera).err().map(|failure| failure.to_string())
        };
        assert_eq!(message(0.1, None, &camera), None);
        assert_eq!(message(5.0, Some(8.0), &camera), None);
        let refused = message(1e9, None, &camera).unwrap_or_default();
        assert!(refused.starts_with("--aperture 1e9: wider than the distance in focus, 4;"), "{refused}");
        assert!(message(5.0, None, &camera).is_some());
        let parallel = Camera { projection: Projection::Orthographic { height_world: 1.0 }, ..camera };
        assert_eq!(message(1e9, None, &parallel), None, "it has no lens");
    }
}
