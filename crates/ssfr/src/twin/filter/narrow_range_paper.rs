use super::image::{Source, Values};
use super::smoothing::sigmas;
use super::{LEAST_SIGMA_PX, WIDENED, taps};
use crate::filter::{HostSurface, LinePass, NarrowRangePaperParams, Width};
use crate::twin::HostView;

/// Narrow-range filter over `surface` as published (Truong and Yuksel 2018; `algorithms.md` 3.1 to 3.3).
pub fn narrow_range_paper(
    view: &HostView,
    params: &NarrowRangePaperParams,
    surface: &HostSurface<'_>,
) -> Vec<f32> {
    let source = Source { view, surface };
    let pass = Pass { source: &source, width: params.width() };
    let mut distances = source.distances();
    for line in pass.width.passes() {
        distances = source.each(&distances, |pixel, center| pass.along(&distances, pixel, center, line));
    }
    let distances = source.each(&distances, |pixel, center| pass.square(&distances, pixel, center));
    source.image(distances.into_iter())
}

struct Pass<'a> {
    source: &'a Source<'a>,
    width: Width,
}

impl Pass<'_> {
    fn along(&self, distances: &Values, pixel: usize, center: f64, pass: LinePass) -> f64 {
        let lines = sigmas(self.source, &self.width, pixel, center).0;
        let sigma = lines * f64::from(pass.share).sqrt() * WIDENED;
        if sigma < LEAST_SIGMA_PX {
            return center;
        }
        let delta = f64::from(self.width.range) * self.source.radius(pixel);
        let clamped = center + f64::from(self.width.clamp) * self.source.radius(pixel);
        // One range per direction, widened outwards by what was accepted (3.3).
        let mut ranges = [[center - delta, center + delta]; 2];
        let (mut total, mut weights) = (center, 1.0);
        for (offset, weight) in taps(pass, sigma, self.source.room(pixel, pass.direction[1] as usize)) {
            let Some(pair) = self.source.pair(pixel, pass.direction.map(|d| i64::from(d) * offset)) else {
                break;
            };
            let pair = pair.map(|i| distances[i].unwrap_or(f64::INFINITY));
            if (0..2).any(|side| pair[side] < ranges[side][0]) {
                continue;
            }
            for side in 0..2 {
                let [low, high] = ranges[side];
                let is_same = pair[side] <= high;
                if is_same {
                    ranges[side] = [low.min(pair[side] - delta), high.max(pair[side] + delta)];
                }
                total += weight * if is_same { pair[side] } else { clamped };
            }
            weights += 2.0 * weight;
        }
        total / weights
    }

    fn square(&self, distances: &Values, pixel: usize, center: f64) -> f64 {
        let sigma = sigmas(self.source, &self.width, pixel, center).1;
        if sigma < LEAST_SIGMA_PX {
            return center;
        }
        let delta = f64::from(self.width.range) * self.source.radius(pixel);
        let clamped = center + f64::from(self.width.clamp) * self.source.radius(pixel);
        let mut range = [center - delta, center + delta];
        let (mut total, mut weights) = (center, 1.0);
        for ring in 1..=2i64 {
            let mut widened = range;
            let half = (0..2 * ring).map(|i| [ring, ring - i]).flat_map(|[x, y]| [[x, y], [-y, x]]);
            for offset in half {
                let Some(pair) = self.source.pair(pixel, offset) else { continue };
                let pair = pair.map(|i| distances[i].unwrap_or(f64::INFINITY));
                if pair.iter().any(|&d| d < range[0]) {
                    continue;
                }
                let squared = (offset[0] * offset[0] + offset[1] * offset[1]) as f64;
                let weight = (-0.5 * squared / (sigma * sigma)).exp();
                for d in pair {
                    let is_same = d <= range[1];
                    if is_same {
                        widened = [widened[0].min(d - delta), widened[1].max(d + delta)];
                    }
                    total += weight * if is_same { d } else { clamped };
                }
                weights += 2.0 * weight;
            }
            range = widened;
        }
        total / weights
    }
}
