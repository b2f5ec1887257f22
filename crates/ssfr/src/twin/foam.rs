use glam::Vec3;
use meniscus_gpu::role::{FoamDrop, NO_SURFACE};

use super::HostView;
use super::splat::Splat;
use crate::FoamUniform;

const MIN_RADIUS_PX: f64 = 1.5;
const MAX_DEPTH_SPACINGS: f64 = 64.0;

/// Optical depth of `drops` per pixel: in front of the surface at `distance`, in it, behind it, and behind it times the depth
/// in spacings. Nothing is drawn behind `scene_distance`.
pub fn foam(
    view: &HostView,
    foam: &FoamUniform,
    drops: &[FoamDrop],
    distance: &[f32],
    scene_distance: &[f32],
) -> Vec<[f64; 4]> {
    let [width, height] = view.size_px;
    let mut layers = vec![[0.0; 4]; width * height];
    let spacing = f64::from(foam.spacing_world);
    for drop in &drops[..foam.count as usize] {
        let center_view = view.view_from_world.transform_point3(Vec3::from(drop.center_world).as_dvec3());
        let along = -center_view.z;
        let radius = spacing * f64::from(foam.widening) * f64::from(drop.radius_spacings());
        let drawn = radius.max(MIN_RADIUS_PX / view.px_per_world(along.max(view.near_world)));
        if radius <= 0.0 || along - radius < view.near_world {
            continue;
        }
        // As much light is taken, whatever the size that is drawn.
        let depth = f64::from(foam.amount) * f64::from(drop.optical_depth()) * (radius / drawn).powi(2);
        let ([columns, rows], _) =
            Splat { center_view, radius: drawn, volume: 0.0, axes: None }.footprint(view);
        for y in rows[0]..rows[1] {
            for x in columns[0]..columns[1] {
                let (origin, step) = view.pixel_ray(x, y);
                let offset = (origin + along * step - center_view).truncate();
                let inside = 1.0 - offset.length_squared() / (drawn * drawn);
                let index = y * width + x;
                if inside <= 0.0 || along >= f64::from(scene_distance[index]) {
                    continue;
                }
                let amount = depth * inside * inside;
                let behind = if distance[index] >= NO_SURFACE {
                    f64::NEG_INFINITY
                } else {
                    (along - f64::from(distance[index])) / spacing
                };
                let front_share = (-behind - 0.5).clamp(0.0, 1.0);
                let behind_share = (behind - 0.5).clamp(0.0, 1.0);
                let [front, surface, back, weighted] = &mut layers[index];
                *front += amount * front_share;
                *surface += amount * (1.0 - front_share - behind_share);
                *back += amount * behind_share;
                *weighted += amount * behind_share * behind.clamp(0.0, MAX_DEPTH_SPACINGS);
            }
        }
    }
    layers
}
