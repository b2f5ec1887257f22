use glam::DVec2;
use meniscus_gpu::role::NO_SURFACE;

use super::splat::sphere;
use super::{HostSet, HostView};
use crate::{NO_VALUE, ScaleUniform};

/// Radii over which a particle's value is spread out, and that it may lie in front of or behind the surface.
const REACH_RADII: f64 = 2.0;
const DEPTH_RADII: f64 = 3.0;
/// As of [`super::depth()`].
const POINT_HALF_PX: f64 = 0.71;

/// Mean place on the colour scale of the particles near the surface at `distance`, per pixel; `None` where there is none.
/// `values` has one value per particle of the set.
pub fn coloring(
    view: &HostView,
    set: &HostSet<'_>,
    values: &[f32],
    scale: &ScaleUniform,
    distance: &[f32],
) -> Vec<Option<f64>> {
    let [width, height] = view.size_px;
    let mut sums = vec![(0.0, 0.0); width * height];
    for range in set.ranges {
        let first = range.first as usize;
        for (index, &value) in values.iter().enumerate().skip(first).take(range.count as usize) {
            let Some(splat) = sphere(view, set, index, range.keep) else { continue };
            if value >= NO_VALUE {
                continue;
            }
            let value = f64::from(value);
            let x = if scale.is_log != 0 { value.max(f64::from(f32::MIN_POSITIVE)).ln() } else { value };
            let place = ((x - f64::from(scale.offset)) * f64::from(scale.factor)).clamp(0.0, 1.0);
            let reach =
                (REACH_RADII * splat.radius).min(splat.distance() - view.near_world).max(splat.radius);
            let wide = super::splat::Splat { radius: reach, ..splat };
            let ([columns, rows], half_px) = wide.footprint(view);
            let is_point = half_px < POINT_HALF_PX;
            let center = view.project_px(splat.center_view).floor();
            for y in rows[0]..rows[1] {
                for x in columns[0]..columns[1] {
                    let d = distance[y * width + x];
                    if d >= NO_SURFACE || is_point && center != DVec2::new(x as f64, y as f64) {
                        continue;
                    }
                    let e = (splat.distance() - f64::from(d)) / (DEPTH_RADII * splat.radius);
                    let (origin, step) = view.pixel_ray(x, y);
                    let offset = (origin + splat.distance() * step - splat.center_view).truncate();
                    let q = if is_point { 0.25 } else { offset.length_squared() / (reach * reach) };
                    if q < 1.0 && e.abs() < 1.0 {
                        let weight = ((1.0 - q) * (1.0 - e * e)).powi(2);
                        let sum: &mut (f64, f64) = &mut sums[y * width + x];
                        *sum = (sum.0 + weight, sum.1 + weight * place);
                    }
                }
            }
        }
    }
    sums.into_iter().map(|(weight, places)| (weight > 0.0).then(|| places / weight)).collect()
}
