use glam::{DVec3, Vec3};
use meniscus_gpu::role::NO_SURFACE;
use rayon::prelude::*;

use super::HostView;

/// Error, in radii, below which both sides count as the same surface.
const NOISE_RADII: f64 = 0.02;
/// Smallest cosine between normal and direction to the eye.
const GRAZING: f64 = 0.02;

/// Unit normals in view space (`algorithms.md` 7): per axis the one-sided differences of 1/d, weighted by how well their
/// side continues the surface; zero vector where there is no surface.
pub fn normal(view: &HostView, distance: &[f32], radius: &[f32]) -> Vec<Vec3> {
    let [width, height] = view.size_px;
    let key = |x: i64, y: i64| {
        let inside = x >= 0 && y >= 0 && x < width as i64 && y < height as i64;
        let d = inside.then(|| distance[y as usize * width + x as usize]).filter(|&d| d < NO_SURFACE)?;
        Some(view.key(d.into()))
    };
    (0..width * height)
        .into_par_iter()
        .map(|pixel| {
            let (x, y) = (pixel % width, pixel / width);
            if distance[pixel] >= NO_SURFACE {
                return Vec3::ZERO;
            }
            let d = f64::from(distance[pixel]);
            let center = view.key(d);
            let per_distance = if view.is_parallel { 1.0 } else { center * center };
            let noise = (NOISE_RADII * f64::from(radius[pixel])).max(4e-7 * d) * per_distance;
            let slope = |dx: i64, dy: i64| {
                let (x, y) = (x as i64, y as i64);
                let (mut total, mut weights) = (0.0, 0.0);
                for outward in [1, -1] {
                    let Some(near) = key(x + outward * dx, y + outward * dy) else { continue };
                    let difference = near - center;
                    let far = key(x + 2 * outward * dx, y + 2 * outward * dy);
                    let error = far.map_or(difference, |far| far - near - difference) / noise;
                    let weight = 1.0 / (1.0 + error.abs().min(1e7).powi(4));
                    total += weight * difference * outward as f64;
                    weights += weight;
                }
                if weights > 0.0 { total / weights } else { 0.0 }
            };
            // Tangent vectors by the neighbours' positions on the plane through this pixel; rows run downwards.
            let (origin, step) = view.pixel_ray(x, y);
            let here = origin + d * step;
            let along = |dx: i64, dy: i64| {
                // A small step, so that the extrapolated key stays positive; the plane is the same.
                let t = 1e-4;
                let (origin, step) = view
                    .ray(glam::DVec2::new(x as f64 + 0.5 + t * dx as f64, y as f64 + 0.5 + t * dy as f64));
                let moved = center + t * slope(dx, dy);
                let d = if view.is_parallel { -moved } else { 1.0 / moved };
                (origin + d * step - here) / t
            };
            let n = along(0, 1).cross(along(1, 0)).normalize();
            let to_eye = -step.normalize();
            let cosine = n.dot(to_eye);
            let n = if cosine < GRAZING { (n + (GRAZING - cosine) * to_eye).normalize() } else { n };
            n.as_vec3()
        })
        .collect()
}

/// Unit vector of octahedral bits as in `shaders/common/surface.inc.wgsl`.
pub fn unpack_normal(bits: u32) -> Vec3 {
    let part = |half: u16| (f64::from(half as i16) / 32767.0).max(-1.0);
    let (x, y) = (part(bits as u16), part((bits >> 16) as u16));
    let z = 1.0 - x.abs() - y.abs();
    let fold = (-z).max(0.0);
    DVec3::new(x - fold * 1f64.copysign(x), y - fold * 1f64.copysign(y), z).normalize().as_vec3()
}
