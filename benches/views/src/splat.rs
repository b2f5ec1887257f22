use glam::{Vec2, Vec3};

use crate::View;

impl View {
    /// Distance of the nearest sphere along the view axis for every pixel, row by row from the top left; `f32::MAX` where
    /// there is none.
    pub fn splat(&self) -> Vec<f32> {
        let camera = self.camera();
        let view_from_world = camera.view_from_world();
        let half_extent = camera.half_extent(self.size);
        let size_px = Vec2::new(self.size[0] as f32, self.size[1] as f32);
        let radius = self.space().radius as f32;
        let mut nearest = vec![f32::MAX; (self.size[0] * self.size[1]) as usize];
        for position in self.read().positions {
            let center = view_from_world.transform_point3(position.into());
            let front = -center.z - radius;
            if front < camera.near {
                continue;
            }
            let center_px =
                (center.truncate() / (-center.z * half_extent) * Vec2::new(0.5, -0.5) + 0.5) * size_px;
            // A sphere off the axis is seen as an ellipse; half as much again holds it in any of the views.
            let reach_px = 1.5 * radius * camera.px_per_world(self.size, front);
            let first = (center_px - reach_px).max(Vec2::ZERO).as_uvec2();
            let end = (center_px + reach_px + 1.0).min(size_px).max(Vec2::ZERO).as_uvec2();
            for y in first.y..end.y {
                for x in first.x..end.x {
                    let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / size_px;
                    let step =
                        ((at * Vec2::new(2.0, -2.0) + Vec2::new(-1.0, 1.0)) * half_extent).extend(-1.0);
                    if let Some(distance) = hit(step, center, radius) {
                        let pixel = &mut nearest[(y * self.size[0] + x) as usize];
                        *pixel = pixel.min(distance);
                    }
                }
            }
        }
        nearest
    }
}

/// Where the ray `distance * step` from the eye enters a sphere.
fn hit(step: Vec3, center: Vec3, radius: f32) -> Option<f32> {
    let (a, b) = (step.length_squared(), step.dot(center));
    // Off the centre by the component across the ray, which does not cancel far away.
    let across = (center - step * (b / a)).length_squared();
    let half_chord = (radius * radius - across).max(0.0).sqrt() / a.sqrt();
    (across < radius * radius).then_some(b / a - half_chord)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_meet_spheres_in_front() {
        let center = Vec3::new(0.0, 0.0, -5.0);
        assert_eq!(hit(Vec3::NEG_Z, center, 1.0), Some(4.0));
        assert_eq!(hit(Vec3::new(0.5, 0.0, -1.0), center, 1.0), None);
    }
}
