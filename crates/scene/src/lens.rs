use std::f32::consts::TAU;

use glam::Vec2;
use meniscus_core::{Camera, Projection};

/// What a camera looks through, for pictures that are the mean of several. Every one of them is drawn from elsewhere on the lens,
/// and a part of a pixel aside: what lies off the distance in focus blurs, and edges are smooth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lens {
    /// Diameter, world units; 0 for a pinhole, which has everything in focus.
    pub aperture_world: f32,
    /// Distance in focus along the view axis, world units; `None` for that of the camera's target.
    pub focus_world: Option<f32>,
}

impl Lens {
    /// The camera of picture `index` of those that make up one of `size_px` pixels. `camera` has to be valid
    /// ([`Camera::validate`]). A parallel camera has no lens; it only moves by parts of a pixel.
    pub fn camera(&self, camera: &Camera, index: u32, size_px: [u32; 2]) -> Camera {
        let [u, v, x, y] = place(index);
        let aside = Vec2::new(x, y) - 0.5;
        let forward = (camera.target - camera.eye).normalize_or_zero();
        let right = forward.cross(camera.up).normalize_or_zero();
        let up = right.cross(forward);
        let rows = size_px[1].max(1) as f32;
        match camera.projection {
            Projection::Orthographic { height_world } => {
                let offset = (right * aside.x + up * aside.y) * (height_world / rows);
                Camera { eye: camera.eye + offset, target: camera.target + offset, ..*camera }
            }
            Projection::Perspective { fovy_rad } => {
                let target_world = camera.eye.distance(camera.target);
                let focus = self.focus_world.unwrap_or(target_world);
                let on_lens = 0.5 * self.aperture_world * v.sqrt() * Vec2::from_angle(TAU * u);
                let eye = camera.eye + right * on_lens.x + up * on_lens.y;
                // All look at the same point in focus, but for the part of a pixel, there.
                let pixel = 2.0 * focus * (0.5 * fovy_rad).tan() / rows;
                let aim = camera.eye + forward * focus + (right * aside.x + up * aside.y) * pixel;
                Camera { eye, target: aim, ..*camera }
            }
        }
    }
}

/// A point of the unit cube in four dimensions, evenly spread whatever the number of points: the additive recurrence of Roberts
/// (2018), "The Unreasonable Effectiveness of Quasirandom Sequences".
fn place(index: u32) -> [f32; 4] {
    /// The real root of x^5 = x + 1.
    const ROOT: f64 = 1.167_303_978_261_418_7;
    let step = |k: i32| (0.5 + f64::from(index) * ROOT.powi(-k)).fract() as f32;
    [step(1), step(2), step(3), step(4)]
}

#[cfg(test)]
mod tests {
    use glam::{Vec3, Vec4};

    use super::*;

    const COUNT: u32 = 64;
    const SIZE: [u32; 2] = [320, 200];

    fn cameras(projection: Projection, lens: Lens) -> Vec<Camera> {
        let camera = Camera {
            eye: Vec3::new(1.0, 2.0, 10.0),
            target: Vec3::new(1.0, 2.0, 2.0),
            up: Vec3::Y,
            projection,
            near: 0.1,
        };
        (0..COUNT).map(|i| lens.camera(&camera, i, SIZE)).collect()
    }

    /// Where `point` is in the pictures, in pixels from their middle: mean, and root mean square distance from it.
    fn spread(cameras: &[Camera], point: Vec3) -> (Vec2, f32) {
        let px = |camera: &Camera| {
            let view = camera.view_from_world() * Vec4::new(point.x, point.y, point.z, 1.0);
            let (half, depth) = match camera.projection {
                Projection::Perspective { fovy_rad } => ((0.5 * fovy_rad).tan(), -view.z),
                Projection::Orthographic { height_world } => (0.5 * height_world, 1.0),
            };
            Vec2::new(view.x, view.y) / depth / half * 0.5 * SIZE[1] as f32
        };
        let mean = cameras.iter().map(px).sum::<Vec2>() / cameras.len() as f32;
        let square = cameras.iter().map(|c| px(c).distance_squared(mean)).sum::<f32>() / cameras.len() as f32;
        (mean, square.sqrt())
    }

    /// Root mean square distance from the middle of a pixel to its points.
    const PIXEL: f32 = 0.408;

    #[test]
    fn without_a_lens_pictures_are_parts_of_a_pixel_aside() {
        for projection in
            [Projection::Perspective { fovy_rad: 0.6 }, Projection::Orthographic { height_world: 4.0 }]
        {
            let cameras = cameras(projection, Lens::default());
            for point in [Vec3::new(1.0, 2.0, 2.0), Vec3::new(1.5, 1.5, 5.0)] {
                let (_, spread) = spread(&cameras, point);
                // 64 points of a pixel are not all of it; off the middle, a turned camera moves them a little more.
                assert!((spread / PIXEL - 1.0).abs() < 0.05, "{spread}");
            }
            let (mean, _) = spread(&cameras, Vec3::new(1.0, 2.0, 2.0));
            assert!(mean.length() < 0.05, "pictures stay where they were: {mean}");
        }
    }

    #[test]
    fn what_is_out_of_focus_is_a_disc_as_wide_as_optics_say() {
        let fovy_rad = 0.6_f32;
        let lens = Lens { aperture_world: 0.4, focus_world: Some(6.0) };
        let cameras = cameras(Projection::Perspective { fovy_rad }, lens);
        let px_per_tangent = 0.5 * SIZE[1] as f32 / (0.5 * fovy_rad).tan();
        for distance in [3.0_f32, 6.0, 12.0] {
            let (mean, spread) = spread(&cameras, Vec3::new(1.0, 2.0, 10.0 - distance));
            // Radius of the circle of confusion: half the aperture times the difference of the reciprocal distances. A disc's root
            // mean square radius is its radius over the root of two; the pixel adds to it.
            let radius = 0.5 * lens.aperture_world * (1.0 / distance - 1.0_f32 / 6.0).abs() * px_per_tangent;
            let expected = (0.5 * radius * radius + PIXEL * PIXEL).sqrt();
            assert!((spread / expected - 1.0).abs() < 0.05, "{distance}: {spread}, not {expected}");
            assert!(mean.length() < 0.1 + 0.05 * radius, "{distance}: {mean}");
        }
    }
}
