//! The filters, after their formulas.

mod adaptive;
mod curvature_flow;
mod image;
mod narrow_range_paper;
mod smoothing;

use crate::filter::LinePass;

pub use adaptive::adaptive;
pub use curvature_flow::curvature_flow;
pub use image::none;
pub use narrow_range_paper::narrow_range_paper;
pub use smoothing::{bilateral, gaussian, narrow_range};

/// Widest smoothing in pixels, and below which a Gaussian is left out: its nearest neighbours weigh less than half a percent.
const MOST_SIGMA_PX: f64 = 1e5;
const LEAST_SIGMA_PX: f64 = 0.3;
/// Where the kernels end, in standard deviations of their Gaussian, which are widened so that what is left has the nominal one.
const REACH: f64 = 2.5;
const WIDENED: f64 = 1.0 / 0.8928;

/// Pixels from one tap to the next of a kernel that reaches so far.
fn step_of(reach_px: f64, most: f64) -> f64 {
    (reach_px / most).log2().ceil().max(0.0).exp2()
}

/// Weight of every other tap of a kernel that takes so many to each side, beginning with the first.
fn odd_weight(taps: f64, most: f64) -> f64 {
    let fading = ((2.0 * taps - most) / most).clamp(0.0, 1.0);
    1.0 - fading * fading * (3.0 - 2.0 * fading)
}

/// Offsets in pixels of the taps of a kernel to one side and their weights relative to the middle, outwards: a Gaussian less
/// its value where it ends, at the latest at the picture's border, `room` pixels away. Continuous in `sigma_px`: every other
/// tap fades before the steps double.
fn taps(pass: LinePass, sigma_px: f64, room: i64) -> impl Iterator<Item = (i64, f64)> + use<> {
    let [close, most] = [pass.close_taps, pass.most_taps].map(f64::from);
    let reach = (REACH * sigma_px).min(room as f64 + 1.0);
    // Up to four pixels apart before there are as many as there may be.
    let step = step_of(reach, close).min(4.0).max(step_of(reach, most));
    let most = if step < 4.0 { close } else { most };
    let end = reach / step;
    let odd = odd_weight(end, most);
    let gaussian = move |offset: f64| (-0.5 * (offset / sigma_px).powi(2)).exp();
    (1..=end as i64).map(move |k| {
        let offset = k as f64 * step;
        let weight = ((gaussian(offset) - gaussian(reach)) / (1.0 - gaussian(reach))).max(0.0);
        (offset as i64, if k % 2 == 1 { odd * weight } else { weight })
    })
}
