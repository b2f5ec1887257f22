use glam::DVec2;
use meniscus_gpu::role::NO_SURFACE;
use rayon::prelude::*;

use super::splat::{Splat, spheres};
use super::{HostSet, HostView};

/// Sum of column densities per block of `scale` x `scale` pixels, as length along the ray up to the farthest opaque
/// distance in the block (`algorithms.md` 2.2): chord times `V / (4/3 pi R^3)`. Splats with half sizes below
/// `profile_half_px` blocks are shared out between the four nearest blocks.
pub fn thickness_sum(
    view: &HostView,
    sets: &[HostSet<'_>],
    scene_distance: &[f32],
    (scale, profile_half_px): (usize, f64),
) -> Vec<f64> {
    let blocks = view.reduced(scale);
    let [width, height] = blocks.size_px;
    let splats = spheres(view, sets);
    let mut sum = vec![0.0; width * height];
    sum.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        let limit: Vec<f64> = (0..width).map(|x| farthest(view, scene_distance, scale, x, y)).collect();
        for splat in &splats {
            let ([columns, rows], half_px) = splat.footprint(view);
            // Shared-out volume may land a block further than the sphere reaches.
            if (y + 2) * scale <= rows[0] || y >= rows[1] / scale + 2 {
                continue;
            }
            if half_px / (scale as f64) < profile_half_px {
                share_out(view, splat, scale, y, &limit, row);
                continue;
            }
            let density = splat.volume / (4.0 / 3.0 * std::f64::consts::PI * splat.radius.powi(3));
            for x in columns[0] / scale..(columns[1].div_ceil(scale)).min(width) {
                let ray = view.ray(view.block_center(scale, x, y));
                if let Some((enter, leave, stretch)) = splat.chord(ray, 0.0) {
                    row[x] += (leave.min(limit[x]) - enter).max(0.0) * stretch * density;
                }
            }
        }
    });
    sum
}

/// Volume of a small splat over the cross-section of the four nearest blocks, bilinearly.
fn share_out(view: &HostView, splat: &Splat, scale: usize, y: usize, limit: &[f64], row: &mut [f64]) {
    let center = view.project_px(splat.center_view) / scale as f64 - DVec2::splat(0.5);
    let weight_y = 1.0 - (center.y - y as f64).abs();
    if weight_y <= 0.0 {
        return;
    }
    let d = splat.distance();
    let stretch = if view.is_parallel { 1.0 } else { splat.center_view.length() / d };
    let length = splat.volume * stretch / (view.pixel_area(d) * (scale * scale) as f64);
    for column in [center.x.floor(), center.x.floor() + 1.0] {
        if column < 0.0 || column >= row.len() as f64 {
            continue;
        }
        let x = column as usize;
        // Volume of the part of the sphere in front of the plane at the limit: a segment of relative height f.
        let f = ((limit[x] - d + splat.radius) / (2.0 * splat.radius)).clamp(0.0, 1.0);
        row[x] += length * weight_y * (1.0 - (center.x - column).abs()) * f * f * (3.0 - 2.0 * f);
    }
}

fn farthest(view: &HostView, scene_distance: &[f32], scale: usize, x: usize, y: usize) -> f64 {
    block(view, scale, x, y).map(|pixel| f64::from(scene_distance[pixel])).fold(0.0, f64::max)
}

fn block(view: &HostView, scale: usize, x: usize, y: usize) -> impl Iterator<Item = usize> + use<> {
    let [width, height] = view.size_px;
    let columns = x * scale..((x + 1) * scale).min(width);
    (y * scale..((y + 1) * scale).min(height))
        .flat_map(move |row| columns.clone().map(move |column| row * width + column))
}

/// Smoothed thickness at full size: a Gaussian of `sigma_spacings` projected spacings over the sums of [`thickness_sum`],
/// normalised by what is covered (`algorithms.md` 2.5), then joint bilinear upsampling between blocks that show the same
/// surface. 0 where there is no surface.
pub fn thickness_smooth(
    view: &HostView,
    sum: &[f64],
    (distance, radius): (&[f32], &[f32]),
    scene_distance: &[f32],
    scale: usize,
    (sigma_spacings, spacing_per_radius): (f64, f64),
) -> Vec<f32> {
    let blocks = view.reduced(scale);
    let [width, height] = blocks.size_px;
    let guides: Vec<Guide> = (0..width * height)
        .map(|i| {
            let pixels = || block(view, scale, i % width, i / width);
            let nearest = pixels().map(|p| distance[p]).fold(NO_SURFACE, f32::min);
            let fluid = pixels().filter(|&p| distance[p] < NO_SURFACE).count();
            let open = pixels().filter(|&p| distance[p] < NO_SURFACE || scene_distance[p] > nearest).count();
            let widest = pixels().map(|p| radius[p]).fold(0.0, f32::max);
            let spacing_px = f64::from(widest) * spacing_per_radius / scale as f64;
            Guide {
                nearest: nearest.into(),
                covered: fluid as f64 / open.max(1) as f64,
                sigma: sigma_spacings * spacing_px * view.px_per_world(nearest.into()),
            }
        })
        .collect();
    let start: Vec<[f64; 2]> = sum.iter().zip(&guides).map(|(&t, guide)| [t, guide.covered]).collect();
    let smooth = |values: &[[f64; 2]], axis, kernel| smooth(values, &guides, [width, height], axis, kernel);
    let smoothed = [0, 1]
        .into_iter()
        .fold(start, |values, axis| smooth(&smooth(&values, axis, Kernel::Gaussian), axis, Kernel::Tent));
    (0..view.size_px[0] * view.size_px[1])
        .into_par_iter()
        .map(|pixel| {
            let (x, y) = (pixel % view.size_px[0], pixel / view.size_px[0]);
            if distance[pixel] >= NO_SURFACE {
                return 0.0;
            }
            let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) / scale as f64 - 0.5;
            let (mut total, mut weights) = (0.0, 0.0);
            for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
                let corner = at.floor() + DVec2::new(dx, dy);
                let bilinear = (1.0 - (at.x - corner.x).abs()) * (1.0 - (at.y - corner.y).abs());
                let i = (corner.y.clamp(0.0, height as f64 - 1.0) as usize) * width
                    + corner.x.clamp(0.0, width as f64 - 1.0) as usize;
                if guides[i].covered > 0.0 {
                    let e =
                        (guides[i].nearest - f64::from(distance[pixel])) / (4.0 * f64::from(radius[pixel]));
                    let weight = bilinear * (1.0 / (1.0 + e * e) + 1e-4);
                    total += weight * smoothed[i][0] / smoothed[i][1];
                    weights += weight;
                }
            }
            (total / weights) as f32
        })
        .collect()
}

struct Guide {
    nearest: f64,
    covered: f64,
    /// Blocks; 0 = no surface.
    sigma: f64,
}

#[derive(Clone, Copy)]
enum Kernel {
    Gaussian,
    /// The mean over the distance of the Gaussian's taps, twice.
    Tent,
}

/// Taps of the Gaussian to a side up to which there is one for each block.
const MAX_TAPS: f64 = 24.0;

fn smooth(
    values: &[[f64; 2]],
    guides: &[Guide],
    size: [usize; 2],
    axis: usize,
    kernel: Kernel,
) -> Vec<[f64; 2]> {
    let stride = [1, size[0]];
    (0..values.len())
        .into_par_iter()
        .map(|i| {
            let at = [i % size[0], i / size[0]];
            // Blocks beside the surface are smoothed like the surface.
            let beside = (0..2).flat_map(|a| {
                let before = (at[a] > 0).then(|| guides[i - stride[a]].sigma);
                let after = (at[a] + 1 < size[a]).then(|| guides[i + stride[a]].sigma);
                [before, after].into_iter().flatten()
            });
            let own = guides[i].sigma;
            let sigma = if own > 0.0 { own } else { beside.fold(0.0, f64::max) };
            let mut total = values[i];
            if sigma > 0.0 {
                let reach = 2.5 * sigma;
                let step = (reach / MAX_TAPS).ceil().max(1.0);
                let offsets = match kernel {
                    Kernel::Gaussian => {
                        (1..=(reach / step).ceil() as usize).map(|k| k * step as usize).collect()
                    }
                    Kernel::Tent => (1..step as usize).collect::<Vec<_>>(),
                };
                let share = match kernel {
                    Kernel::Gaussian => step,
                    Kernel::Tent => 1.0 / step,
                };
                for offset in offsets {
                    let weight = match kernel {
                        Kernel::Gaussian => (-0.5 * (offset as f64 / sigma).powi(2)).exp(),
                        Kernel::Tent => 1.0 - offset as f64 / step,
                    };
                    let mut add = |j: usize| (0..2).for_each(|c| total[c] += weight * values[j][c]);
                    if at[axis] >= offset {
                        add(i - offset * stride[axis]);
                    }
                    if at[axis] + offset < size[axis] {
                        add(i + offset * stride[axis]);
                    }
                }
                total = total.map(|t| share * t);
            }
            total
        })
        .collect()
}
