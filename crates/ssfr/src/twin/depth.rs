use meniscus_gpu::role::NO_SURFACE;
use rayon::prelude::*;

use super::splat::splats;
use super::{HostSet, HostView};

/// What [`depth`] makes.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthImages {
    /// Distance of the nearest splat along the view axis; [`NO_SURFACE`] = none.
    pub distance: Vec<f32>,
    /// Its radius, of an ellipsoid that of the sphere in its place; 0 = none.
    pub radius: Vec<f32>,
}

/// Half size in pixels below which a splat is drawn as the one pixel that holds its centre: half a pixel's diagonal.
const POINT_HALF_PX: f64 = 0.71;

/// Nearest splat per pixel in front of `scene_distance` (as long as the picture; MAX = sky). The largest radius wins among
/// splats that are equally near, within a thousandth of the radius.
pub fn depth(view: &HostView, sets: &[HostSet<'_>], scene_distance: &[f32]) -> DepthImages {
    let [width, height] = view.size_px;
    let splats = splats(view, sets);
    let mut distance = vec![NO_SURFACE; width * height];
    let mut radius = vec![0.0f32; width * height];
    let rows = distance.par_chunks_mut(width).zip(radius.par_chunks_mut(width)).enumerate();
    rows.for_each(|(y, (distance, radius))| {
        let mut nearest = vec![f64::INFINITY; width];
        let visit = |record: &mut dyn FnMut(usize, f64, f64)| {
            for splat in &splats {
                let ([columns, rows], half_px) = splat.footprint(view);
                if y < rows[0] || y >= rows[1] {
                    continue;
                }
                if half_px < POINT_HALF_PX {
                    let center = view.project_px(splat.center_view).floor();
                    let inside = center.x >= 0.0 && center.x < width as f64;
                    if inside && center.y == y as f64 {
                        let ray = view.pixel_ray(center.x as usize, y);
                        if let Some((enter, ..)) = splat.chord(ray, f64::INFINITY) {
                            // A ray that passes by may come closest before the sphere's front.
                            record(center.x as usize, enter.max(splat.front()), splat.radius);
                        }
                    }
                    continue;
                }
                for x in columns[0]..columns[1] {
                    if let Some((enter, ..)) = splat.chord(view.pixel_ray(x, y), 0.0) {
                        record(x, enter, splat.radius);
                    }
                }
            }
        };
        visit(&mut |x, enter, _| {
            if enter < f64::from(scene_distance[y * width + x]) {
                nearest[x] = nearest[x].min(enter);
            }
        });
        visit(&mut |x, enter, r| {
            if enter <= nearest[x] + 1e-3 * r {
                radius[x] = radius[x].max(r as f32);
            }
        });
        for (x, &found) in nearest.iter().enumerate() {
            if found.is_finite() {
                distance[x] = found as f32;
            } else {
                radius[x] = 0.0;
            }
        }
    });
    DepthImages { distance, radius }
}
