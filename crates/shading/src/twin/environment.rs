//! Twin of `meniscus::environment`.

use std::f32::consts::PI;

use glam::{Vec2, Vec3, Vec4};

use crate::environment::{BLURRED_LEVELS, EnvironmentSize};

fn environment_level(texels: &[[f32; 4]], size: [u32; 2], place: Vec2) -> Vec3 {
    let corner = place * Vec2::new(size[0] as f32, size[1] as f32) - 0.5;
    let base = corner.floor();
    let f = corner - base;
    let mut sum = Vec3::ZERO;
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let column = (base.x as i32 + dx).rem_euclid(size[0] as i32) as usize;
        let row = (base.y as i32 + dy).clamp(0, size[1] as i32 - 1) as usize;
        let along = |offset: i32, f: f32| if offset == 1 { f } else { 1.0 - f };
        sum +=
            along(dx, f.x) * along(dy, f.y) * Vec4::from(texels[row * size[0] as usize + column]).truncate();
    }
    sum
}

/// Radiance from the unit direction (east, north, up), seen in a mirror of this perceptual roughness.
pub(super) fn environment_radiance(
    size: &EnvironmentSize,
    texels: &[[f32; 4]],
    direction: Vec3,
    roughness: f32,
) -> Vec3 {
    let azimuth = direction.x.atan2(direction.y) / (2.0 * PI) + 0.5;
    let place = Vec2::new(azimuth, direction.z.clamp(-1.0, 1.0).acos() / PI);
    let level = roughness.clamp(0.0, 1.0) * BLURRED_LEVELS as f32;
    let below = (level as usize).min(BLURRED_LEVELS - 1);
    let [sharp, blurred] = [size.sharp, size.blurred].map(|[width, height]| (width * height) as usize);
    let blurred_level =
        |number: usize| environment_level(&texels[sharp + number * blurred..], size.blurred, place);
    let lower =
        if below > 0 { blurred_level(below - 1) } else { environment_level(texels, size.sharp, place) };
    lower.lerp(blurred_level(below), level - below as f32)
}
