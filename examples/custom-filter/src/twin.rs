//! The filter on the CPU in double precision: what its passes are tested against.

use glam::{DMat3, DVec3};
use meniscus_gpu::CameraUniform;
use meniscus_gpu::role::NO_SURFACE;
use meniscus_ssfr::filter::HostSurface;
use meniscus_ssfr::twin::HostView;

use crate::PlaneFitParams;

/// Taps to each side at most.
const MAX_TAPS: f64 = 8.0;

/// All passes over `surface` for pictures of `camera`.
pub fn plane_fit(camera: &CameraUniform, params: &PlaneFitParams, surface: &HostSurface<'_>) -> Vec<f32> {
    let view = HostView::new(camera);
    let mut current = surface.distance.to_vec();
    for sigma_radii in params.pass_sigmas_radii(surface.spacing_per_radius) {
        let pass = Pass {
            is_parallel: camera.orthographic != 0,
            sigma_radii: sigma_radii.into(),
            range_radii: params.range.into(),
            view,
        };
        current = (0..current.len()).map(|pixel| pass.fit(&current, surface.radius, pixel)).collect();
    }
    current
}

struct Pass {
    view: HostView,
    is_parallel: bool,
    sigma_radii: f64,
    range_radii: f64,
}

impl Pass {
    /// A number that is affine in the pixel on every plane and greater for what is nearer (`algorithms.md` 3.7).
    fn key(&self, distance: f64) -> f64 {
        if self.is_parallel { -distance } else { 1.0 / distance }
    }

    /// The smoothed distance of `pixel`: minimises `sum w_i (a + b x_i + c y_i - z_i)^2` over the window, with biweights of
    /// place and key, and takes the plane's value `a` at the pixel itself.
    fn fit(&self, source: &[f32], radius: &[f32], pixel: usize) -> f32 {
        if !is_surface(source[pixel]) {
            return NO_SURFACE;
        }
        let (distance, radius) = (f64::from(source[pixel]), f64::from(radius[pixel]));
        let [width, height] = self.view.size_px.map(|side| side as i64);
        let (x, y) = (pixel as i64 % width, pixel as i64 / width);
        let center = self.key(distance);
        let key_per_distance = if self.is_parallel { 1.0 } else { center * center };
        let range = self.range_radii * radius * key_per_distance;
        let reach_px = 8.0_f64.sqrt() * self.sigma_radii * radius * self.view.px_per_world(distance);
        if !(reach_px > 1.0 && reach_px < 1e9) {
            return source[pixel];
        }
        let step = (reach_px / MAX_TAPS).log2().ceil().max(0.0).exp2();
        let taps = (reach_px / step) as i64;
        let fading = (reach_px / step / (0.5 * MAX_TAPS) - 1.0).clamp(0.0, 1.0);
        let odd = 1.0 - fading * fading * (3.0 - 2.0 * fading);

        let (mut normal_equations, mut right_hand_side) = (DMat3::ZERO, DVec3::ZERO);
        for j in -taps..=taps {
            for i in -taps..=taps {
                let [dx, dy] = [i, j].map(|k| k as f64 * step);
                let (at_x, at_y) = (x + dx as i64, y + dy as i64);
                if !(0..width).contains(&at_x) || !(0..height).contains(&at_y) {
                    continue;
                }
                let tap = source[(at_y * width + at_x) as usize];
                if !is_surface(tap) {
                    continue;
                }
                let basis = DVec3::new(1.0, dx / reach_px, dy / reach_px);
                let z = (self.key(tap.into()) - center) / range;
                let fade = [i, j].map(|k| if k % 2 == 0 { 1.0 } else { odd });
                let weight =
                    fade[0] * fade[1] * biweight(basis.y * basis.y + basis.z * basis.z) * biweight(z * z);
                normal_equations += DMat3::from_cols(basis, basis.y * basis, basis.z * basis) * weight;
                right_hand_side += weight * z * basis;
            }
        }
        let [total, xx, yy] = [0, 1, 2].map(|i| normal_equations.col(i)[i]);
        let full = total * (0.5 * (xx + yy)).powi(2);
        let thickness = if full > 0.0 { normal_equations.determinant() / full } else { 0.0 };
        if thickness <= 0.02 {
            return source[pixel];
        }
        let height = (normal_equations.inverse() * right_hand_side).x.clamp(-1.0, 1.0);
        let ramp = ((thickness - 0.02) / 0.08).clamp(0.0, 1.0);
        let trust = ramp * ramp * (3.0 - 2.0 * ramp);
        let last = self.key(distance + self.range_radii * radius);
        let key = (center + trust * height * range).max(last);
        (if self.is_parallel { -key } else { 1.0 / key }) as f32
    }
}

/// Whatever is no distance is no surface.
fn is_surface(distance: f32) -> bool {
    distance > 0.0 && distance < 1.7e38
}

/// Tukey's biweight of a squared deviation.
fn biweight(squared: f64) -> f64 {
    (1.0 - squared).max(0.0).powi(2)
}
