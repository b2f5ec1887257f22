use meniscus_gpu::role::NO_SURFACE;
use rayon::prelude::*;

use super::HostView;
use crate::filter::{HostSurface, NarrowRangeParams, NarrowRangeVariant, directions};

/// Half-width of the Gaussian in its standard deviations, which are widened so that what is left has the nominal one.
const REACH: f64 = 2.5;
const WIDENED: f64 = 1.0 / 0.954;
const MAX_TAPS: f64 = 24.0;
const LEAST_SIGMA_PX: f64 = 0.3;

/// Narrow-range filter over `surface`, all passes (`algorithms.md` 3).
pub fn narrow_range(view: &HostView, params: &NarrowRangeParams, surface: &HostSurface<'_>) -> Vec<f32> {
    let filter = Filter { view, params, surface };
    let is_paper = params.variant == NarrowRangeVariant::Paper;
    let mut values: Vec<Option<f64>> = surface
        .distance
        .iter()
        .map(|&d| (d < NO_SURFACE).then(|| if is_paper { d.into() } else { view.key(d.into()) }))
        .collect();
    for direction in directions(params.iterations) {
        values = filter.each(&values, |filter, values, pixel| {
            if is_paper {
                filter.paper_along(values, pixel, direction)
            } else {
                filter.compensated_along(values, pixel, direction)
            }
        });
    }
    values = filter.each(&values, |filter, values, pixel| {
        if is_paper { filter.paper_square(values, pixel) } else { filter.compensated_square(values, pixel) }
    });
    values
        .iter()
        .map(|value| value.map_or(NO_SURFACE, |v| if is_paper { v } else { filter.distance(v) } as f32))
        .collect()
}

struct Filter<'a> {
    view: &'a HostView,
    params: &'a NarrowRangeParams,
    surface: &'a HostSurface<'a>,
}

impl Filter<'_> {
    fn each(
        &self,
        values: &[Option<f64>],
        pass: impl Fn(&Self, &[Option<f64>], usize) -> f64 + Sync,
    ) -> Vec<Option<f64>> {
        (0..values.len()).into_par_iter().map(|i| values[i].map(|_| pass(self, values, i))).collect()
    }

    fn distance(&self, key: f64) -> f64 {
        // The map of distances to keys is its own inverse.
        self.view.key(key)
    }

    fn radius(&self, pixel: usize) -> f64 {
        self.surface.radius[pixel].into()
    }

    /// Standard deviations in pixels of a pass along one direction and of the clean-up.
    fn sigmas(&self, pixel: usize, distance: f64) -> (f64, f64) {
        let spacing = self.radius(pixel) * f64::from(self.surface.spacing_per_radius);
        let total = f64::from(self.params.sigma) * spacing * self.view.px_per_world(distance);
        let clean = (0.5 * total).min(1.0);
        (((total * total - clean * clean) / f64::from(self.params.iterations)).sqrt(), clean)
    }

    /// The pixel `offset` away, if it and its mirror image lie in the picture.
    fn pair(&self, pixel: usize, offset: [i64; 2]) -> Option<[usize; 2]> {
        let width = self.view.size_px[0] as i64;
        let at = [pixel as i64 % width, pixel as i64 / width];
        let fits = |axis: usize| {
            let reach = offset[axis].abs();
            at[axis] >= reach && at[axis] + reach < self.view.size_px[axis] as i64
        };
        let step = offset[1] * width + offset[0];
        (fits(0) && fits(1)).then(|| [step, -step].map(|step| (pixel as i64 + step) as usize))
    }

    /// Offsets along a direction and their weights, outwards.
    fn taps(sigma_px: f64) -> impl Iterator<Item = (i64, f64)> {
        let reach = REACH * sigma_px;
        let step = (reach / MAX_TAPS).ceil().max(1.0);
        (1..=(reach / step).ceil() as usize).map(move |k| {
            let offset = k as f64 * step;
            (offset as i64, (-0.5 * (offset / sigma_px).powi(2)).exp())
        })
    }

    fn compensated_along(&self, keys: &[Option<f64>], pixel: usize, direction: [u32; 2]) -> f64 {
        let center = keys[pixel].expect("only pixels with a surface are filtered");
        let sigma = self.sigmas(pixel, self.distance(center)).0 * WIDENED;
        if sigma < LEAST_SIGMA_PX {
            return center;
        }
        let towards = |offset: i64| direction.map(|d| i64::from(d) * offset);
        let wanted = (0.75 * sigma).round_ties_even().max(1.0) as i64;
        let baseline = (1..=wanted).rev().find(|&b| self.pair(pixel, towards(b)).is_some());
        let slope = baseline.map_or(0.0, |b| self.slope(keys, pixel, towards(b)) / b as f64);
        let pairs =
            Self::taps(sigma).map(|(offset, weight)| (towards(offset), offset as f64 * slope, weight));
        self.compensated(keys, pixel, pairs)
    }

    fn compensated_square(&self, keys: &[Option<f64>], pixel: usize) -> f64 {
        let center = keys[pixel].expect("only pixels with a surface are filtered");
        let sigma = self.sigmas(pixel, self.distance(center)).1;
        if sigma < LEAST_SIGMA_PX || self.pair(pixel, [2, 2]).is_none() {
            return center;
        }
        let slope = [self.slope(keys, pixel, [1, 0]), self.slope(keys, pixel, [0, 1])];
        let half = [[1, 0], [2, 0]].into_iter().chain((1..=2).flat_map(|y| (-2..=2).map(move |x| [x, y])));
        let pairs = half.map(|offset: [i64; 2]| {
            let squared = (offset[0] * offset[0] + offset[1] * offset[1]) as f64;
            let rise = offset[0] as f64 * slope[0] + offset[1] as f64 * slope[1];
            (offset, rise, (-0.5 * squared / (sigma * sigma)).exp())
        });
        self.compensated(keys, pixel, pairs)
    }

    /// Step of the key towards `offset`: of both sides the smaller where they agree in sign, the only one at a gap.
    fn slope(&self, keys: &[Option<f64>], pixel: usize, offset: [i64; 2]) -> f64 {
        let Some(pair) = self.pair(pixel, offset) else { return 0.0 };
        let center = keys[pixel].unwrap_or_default();
        match pair.map(|i| keys[i]) {
            [None, None] => 0.0,
            [Some(after), None] => after - center,
            [None, Some(before)] => center - before,
            [Some(after), Some(before)] => {
                let (forward, backward) = (after - center, center - before);
                if forward * backward <= 0.0 {
                    0.0
                } else if forward.abs() < backward.abs() {
                    forward
                } else {
                    backward
                }
            }
        }
    }

    /// Mean deviation from the plane through the pixel (3.7). Thresholds are to first order in key per distance. What is in
    /// front of the range is left out together with its mirror image (3.2), what is behind counts as just behind the
    /// surface as it was before all passes, so that they do not add up and pull small things away (3.6 no. 6).
    fn compensated(
        &self,
        keys: &[Option<f64>],
        pixel: usize,
        pairs: impl Iterator<Item = ([i64; 2], f64, f64)>,
    ) -> f64 {
        let center = keys[pixel].unwrap_or_default();
        let per_distance = if self.view.is_parallel { 1.0 } else { center * center };
        let per_radius = self.radius(pixel) * per_distance;
        let range = (f64::from(self.params.threshold) * per_radius).max(1e-30);
        let before_all = self.view.key(self.surface.distance[pixel].into());
        let clamped = before_all - f64::from(self.params.clamp) * per_radius - center;
        let (mut total, mut weights) = (0.0, 1.0);
        for (offset, rise, weight) in pairs {
            let Some([after, before]) = self.pair(pixel, offset) else { break };
            let deviation =
                |i: usize, rise: f64| keys[i].map_or(f64::NEG_INFINITY, |key| key - center - rise);
            let errors = [deviation(after, rise), deviation(before, -rise)];
            // Both tests of the range fade over its outer half.
            let weight = weight * (2.0 - 2.0 * errors[0].max(errors[1]) / range).clamp(0.0, 1.0);
            let clamp = |e: f64| {
                let e = e.max(-range);
                e + (clamped - e) * (-2.0 * e / range - 1.0).clamp(0.0, 1.0)
            };
            total += weight * errors.map(clamp).iter().sum::<f64>();
            weights += 2.0 * weight;
        }
        let last = self.distance(center) + f64::from(self.params.threshold) * self.radius(pixel);
        (center + total / weights).max(self.view.key(last))
    }

    fn paper_along(&self, distances: &[Option<f64>], pixel: usize, direction: [u32; 2]) -> f64 {
        let center = distances[pixel].expect("only pixels with a surface are filtered");
        let sigma = self.sigmas(pixel, center).0 * WIDENED;
        if sigma < LEAST_SIGMA_PX {
            return center;
        }
        let delta = f64::from(self.params.threshold) * self.radius(pixel);
        let clamped = center + f64::from(self.params.clamp) * self.radius(pixel);
        // One range per direction, widened outwards by what was accepted (3.3).
        let mut ranges = [[center - delta, center + delta]; 2];
        let (mut total, mut weights) = (center, 1.0);
        for (offset, weight) in Self::taps(sigma) {
            let Some(pair) = self.pair(pixel, direction.map(|d| i64::from(d) * offset)) else { break };
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

    fn paper_square(&self, distances: &[Option<f64>], pixel: usize) -> f64 {
        let center = distances[pixel].expect("only pixels with a surface are filtered");
        let sigma = self.sigmas(pixel, center).1;
        if sigma < LEAST_SIGMA_PX {
            return center;
        }
        let delta = f64::from(self.params.threshold) * self.radius(pixel);
        let clamped = center + f64::from(self.params.clamp) * self.radius(pixel);
        let mut range = [center - delta, center + delta];
        let (mut total, mut weights) = (center, 1.0);
        for ring in 1..=2i64 {
            let mut widened = range;
            let half = (0..2 * ring).map(|i| [ring, ring - i]).flat_map(|[x, y]| [[x, y], [-y, x]]);
            for offset in half {
                let Some(pair) = self.pair(pixel, offset) else { continue };
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
