use glam::DVec2;

use super::image::{Source, Values};
use crate::filter::{CurvatureFlowParams, HostSurface};
use crate::twin::HostView;

/// Flow of `surface` by its mean curvature (van der Laan et al. 2009; `algorithms.md` 5), with its speed along the normal:
/// steps of `k += t / 2 ((1 + q^2) k_xx + (1 + p^2) k_yy - 2 p q k_xy) / (1 + p^2 + q^2)` on keys, where `p` and `q` are the
/// slopes along both axes. The published form does so for distances, which planes are not affine in.
pub fn curvature_flow(view: &HostView, params: &CurvatureFlowParams, surface: &HostSurface<'_>) -> Vec<f32> {
    let source = Source { view, surface };
    let mut keys = source.keys();
    for share in params.shares() {
        let step = Step { source: &source, params, share: share.into() };
        keys = source.each(&keys, |pixel, center| step.flow(&keys, pixel, center));
    }
    source.image(keys.iter().map(|key| key.map(|key| source.distance(key))))
}

struct Step<'a> {
    source: &'a Source<'a>,
    params: &'a CurvatureFlowParams,
    /// Fraction of the flow's duration.
    share: f64,
}

/// Central differences along an axis over `reach` pixels, at least 1; 0 = across an edge at any width.
#[derive(Default)]
struct Axis {
    reach: f64,
    first: f64,
    second: f64,
    samples: Vec<f64>,
}

impl Step<'_> {
    fn flow(&self, keys: &Values, pixel: usize, center: f64) -> f64 {
        let sigma = self.source.spacings_px(self.params.sigma, pixel, self.source.distance(center));
        let wished = self.share * sigma * sigma;
        if wished < 1e-4 {
            return center;
        }
        let per_radius = self.source.radius(pixel) * self.source.key_per_distance(center);
        let range = (f64::from(self.params.threshold) * per_radius).max(1e-30);
        // No mode changes its sign in a step of at most a quarter of the square of the differences' width.
        let wanted = (2.0 * wished.sqrt()).max(1.0);
        let [x, y] = [[1, 0], [0, 1]].map(|axis| self.axis(keys, pixel, center, axis, wanted, range));
        let stable = |axis: &Axis| if axis.reach > 0.0 { 0.25 * axis.reach.powi(2) } else { f64::MAX };
        let duration = wished.min(stable(&x)).min(stable(&y));

        let [across, down] = [&x, &y].map(|axis| axis.reach as i64);
        let corner = |dx: i64, dy: i64| keys[self.source.pair(pixel, [dx * across, dy * down])?[0]];
        let mixed = match [corner(1, 1), corner(-1, 1), corner(1, -1), corner(-1, -1)] {
            [Some(pp), Some(mp), Some(pm), Some(mm)] if across > 0 && down > 0 => {
                let twist = pp + mm - pm - mp;
                fade(twist, range) * twist / (4 * across * down) as f64
            }
            _ => 0.0,
        };
        let per_key =
            self.source.view.px_per_world(1.0) / if self.source.view.is_parallel { 1.0 } else { center };
        // Slopes count up to 45 degrees, else the flow would come to a standstill on steeper ones.
        let steep = DVec2::new(x.first, y.first) * per_key;
        let DVec2 { x: p, y: q } = steep / steep.length().max(1.0);
        let bending = (1.0 + q * q) * x.second + (1.0 + p * p) * y.second - 2.0 * p * q * mixed;
        let moved = center + 0.5 * duration * bending / (1.0 + p * p + q * q);
        // A flow makes no new extremes.
        let around = || x.samples.iter().chain(&y.samples).copied();
        moved.clamp(around().fold(center, f64::min), around().fold(center, f64::max))
    }

    /// Takes differences as wide as `wanted`, or by halves narrower until they do not span an edge; linear between pixels.
    fn axis(
        &self,
        keys: &Values,
        pixel: usize,
        center: f64,
        axis: [i64; 2],
        wanted: f64,
        range: f64,
    ) -> Axis {
        let mut reach = wanted.min(self.source.room(pixel, axis[1] as usize) as f64);
        while reach >= 1.0 {
            let part = reach.fract();
            let ends = [reach.floor(), reach.ceil()];
            let samples = ends.map(|end| {
                let pair = self.source.pair(pixel, axis.map(|a| a * end as i64)).expect("there is room");
                pair.map(|i| keys[i])
            });
            if let [[Some(a), Some(b)], [Some(c), Some(d)]] = samples {
                let [after, before] = [a + part * (c - a), b + part * (d - b)];
                // Neither pair may lie across an edge.
                let most = (a + b - 2.0 * center).abs().max((c + d - 2.0 * center).abs());
                if most < range {
                    let squared = ends[0].powi(2) + part * (ends[1].powi(2) - ends[0].powi(2));
                    return Axis {
                        reach,
                        first: (after - before) / (2.0 * reach),
                        second: fade(most, range) * (after + before - 2.0 * center) / squared,
                        samples: vec![after, before],
                    };
                }
            }
            reach = if reach > 1.0 && reach < 2.0 { 1.0 } else { 0.5 * reach };
        }
        Axis::default()
    }
}

/// 1 in the inner half of the range, 0 from its end on.
fn fade(bend: f64, range: f64) -> f64 {
    (2.0 - 2.0 * bend.abs() / range).clamp(0.0, 1.0)
}
