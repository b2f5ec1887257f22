use super::image::{Source, Values};
use super::{LEAST_SIGMA_PX, REACH, WIDENED, odd_weight, step_of, taps};
use crate::filter::{BilateralParams, GaussianParams, HostSurface, LinePass, NarrowRangeParams, Rule, Width};
use crate::twin::HostView;

/// Narrow-range filter over `surface`, slope-compensated (`algorithms.md` 3.7).
pub fn narrow_range(view: &HostView, params: &NarrowRangeParams, surface: &HostSurface<'_>) -> Vec<f32> {
    smooth(&Source { view, surface }, &params.width(), Rule::NarrowRange, |_| 1.0)
}

/// Bilateral Gaussian over `surface`, slope-compensated (`algorithms.md` 4, 3.7).
pub fn bilateral(view: &HostView, params: &BilateralParams, surface: &HostSurface<'_>) -> Vec<f32> {
    smooth(&Source { view, surface }, &params.width(), Rule::Bilateral, |_| 0.0)
}

/// Gaussian over what `surface` has.
pub fn gaussian(view: &HostView, params: &GaussianParams, surface: &HostSurface<'_>) -> Vec<f32> {
    smooth(&Source { view, surface }, &params.width(), Rule::Gaussian, |_| 0.0)
}

/// All passes of a filter of pairs. Where `rule` is adaptive, `complexity` of a pixel is 0 for the bilateral rule, 1 for the
/// narrow-range rule, and between them for both.
pub(super) fn smooth(
    source: &Source<'_>,
    width: &Width,
    rule: Rule,
    complexity: impl Fn(usize) -> f64 + Sync,
) -> Vec<f32> {
    let pass = Pass { source, width, rule, complexity: &complexity };
    let mut keys = source.keys();
    for line in width.passes() {
        keys = source.each(&keys, |pixel, center| pass.along(&keys, pixel, center, line));
    }
    // As many as a picture of this size may take: where the pattern is finer they leave pixels alone.
    let [width_px, height_px] = source.view.size_px;
    let side_px = width_px.max(height_px) as u32;
    let coarse = width.coarse_clean_up(f32::INFINITY, side_px).map(|pass| pass.most_gap.into());
    for most_gap in coarse.chain([1]) {
        keys = source.each(&keys, |pixel, center| pass.square(&keys, pixel, center, most_gap));
    }
    source.image(keys.iter().map(|key| key.map(|key| source.distance(key))))
}

/// Standard deviations in pixels of all passes along one direction together and of the clean-up: variances add up.
pub(super) fn sigmas(source: &Source<'_>, width: &Width, pixel: usize, distance: f64) -> (f64, f64) {
    let total = source.spacings_px(width.sigma, pixel, distance);
    let square = (0.5 * total).min(1.0);
    ((total * total - square * square).sqrt(), square)
}

/// Half of the square of the clean-up: the other half are the mirror images.
fn half_square() -> impl Iterator<Item = [i64; 2]> {
    [[1, 0], [2, 0]].into_iter().chain((1..=2).flat_map(|y| (-2..=2).map(move |x| [x, y])))
}

struct Pass<'a> {
    source: &'a Source<'a>,
    width: &'a Width,
    rule: Rule,
    complexity: &'a (dyn Fn(usize) -> f64 + Sync),
}

impl Pass<'_> {
    fn along(&self, keys: &Values, pixel: usize, center: f64, pass: LinePass) -> f64 {
        let distance = self.source.distance(center);
        let lines = sigmas(self.source, self.width, pixel, distance).0;
        let sigma = lines * f64::from(pass.share).sqrt() * WIDENED;
        if sigma < LEAST_SIGMA_PX {
            return center;
        }
        let towards = |offset: i64| pass.direction.map(|d| i64::from(d) * offset);
        // Far enough apart to see the surface behind the bumps.
        let wanted = (0.75 * sigma).round_ties_even().max(1.0) as i64;
        let room = self.source.room(pixel, pass.direction[1] as usize);
        let baseline = wanted.min(room);
        let slope = self.slope(keys, pixel, center, towards(baseline)) / baseline.max(1) as f64;
        let pairs =
            taps(pass, sigma, room).map(|(offset, weight)| (towards(offset), offset as f64 * slope, weight));
        self.moved(keys, pixel, center, pairs)
    }

    /// The clean-up with taps at most so far apart.
    fn square(&self, keys: &Values, pixel: usize, center: f64, most_gap: i64) -> f64 {
        let (lines, sigma) = sigmas(self.source, self.width, pixel, self.source.distance(center));
        let last = self.width.clean_up();
        let reach = REACH * WIDENED * lines * f64::from(last.share).sqrt();
        let most = f64::from(last.most_taps);
        let period = step_of(reach, 0.75 * most) as i64;
        let room = self.source.room(pixel, 0).min(self.source.room(pixel, 1));
        let gap = (period / 4).max(1).min(most_gap).min(room / 2);
        let is_last = most_gap == 1;
        if sigma < LEAST_SIGMA_PX || gap < 1 || (!is_last && period <= most_gap) {
            return center;
        }
        let gaps = 1.0 - odd_weight(reach, most);
        let slope = [[gap, 0], [0, gap]].map(|offset| self.slope(keys, pixel, center, offset));
        let pairs = half_square().map(|offset| {
            let rise = offset[0] as f64 * slope[0] + offset[1] as f64 * slope[1];
            let weights = offset.map(|o| {
                let gaussian = (-0.5 * (o * o) as f64 / (sigma * sigma)).exp();
                let even = if o.abs() == 2 { 0.5 } else { 1.0 };
                gaussian + (even - gaussian) * gaps
            });
            (offset.map(|o| gap * o), rise, weights[0] * weights[1])
        });
        self.moved(keys, pixel, center, pairs)
    }

    /// Step of the key towards `offset`: of both sides the smaller where they agree in sign, the only one at a gap. A plain
    /// Gaussian has none.
    fn slope(&self, keys: &Values, pixel: usize, center: f64, offset: [i64; 2]) -> f64 {
        let Some(pair) = self.source.pair(pixel, offset) else { return 0.0 };
        match pair.map(|i| keys[i]) {
            _ if self.rule == Rule::Gaussian => 0.0,
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

    /// The key moved by the weighted mean of the deviations from the plane through the pixel, over `pairs` of offset, rise of
    /// the plane and weight; the pixel itself weighs 1 and deviates by 0. Thresholds are to first order in key per distance.
    /// Never further back than the range.
    fn moved(
        &self,
        keys: &Values,
        pixel: usize,
        center: f64,
        pairs: impl Iterator<Item = ([i64; 2], f64, f64)>,
    ) -> f64 {
        let surface = self.source.surface;
        let per_radius = self.source.radius(pixel) * self.source.key_per_distance(center);
        let range = (f64::from(self.width.range) * per_radius).max(1e-30);
        let unfiltered = self.source.view.key(surface.distance[pixel].into());
        let clamped = unfiltered - f64::from(self.width.clamp) * per_radius - center;
        let complexity = (self.complexity)(pixel);
        let (mut total, mut weights) = (0.0, 1.0);
        for (offset, rise, weight) in pairs {
            let Some([after, before]) = self.source.pair(pixel, offset) else { break };
            let deviations =
                [(after, rise), (before, -rise)].map(|(i, rise)| keys[i].map(|key| key - center - rise));
            let [narrow, soft] = [narrow_pair(deviations, range, clamped), bilateral_pair(deviations, range)];
            let (added, weighs) = match self.rule {
                Rule::NarrowRange => narrow,
                Rule::Bilateral => soft,
                Rule::Gaussian => {
                    let there = deviations.into_iter().flatten();
                    (there.clone().sum(), there.count() as f64)
                }
                Rule::Adaptive => {
                    (soft.0 + complexity * (narrow.0 - soft.0), soft.1 + complexity * (narrow.1 - soft.1))
                }
            };
            total += weight * added;
            weights += weight * weighs;
        }
        let key = center + total / weights;
        if self.rule == Rule::Gaussian {
            return key;
        }
        let last = self.source.distance(center) + f64::from(self.width.range) * self.source.radius(pixel);
        key.max(self.source.view.key(last))
    }
}

/// What is in front of the range is left out together with its mirror image (3.2), what is behind counts as just behind the
/// surface as it was before all passes, so that they do not add up and pull small things away (3.6 no. 6). Both tests fade
/// over the outer half of the range. Sum of weighted deviations, and of weights.
fn narrow_pair(deviations: [Option<f64>; 2], range: f64, clamped: f64) -> (f64, f64) {
    let errors = deviations.map(|e| e.unwrap_or(f64::NEG_INFINITY));
    let weight = (2.0 - 2.0 * errors[0].max(errors[1]) / range).clamp(0.0, 1.0);
    let clamp = |e: f64| {
        let e = e.max(-range);
        e + (clamped - e) * (-2.0 * e / range - 1.0).clamp(0.0, 1.0)
    };
    (weight * errors.map(clamp).iter().sum::<f64>(), 2.0 * weight)
}

/// `exp(-e^2 / 2 s^2)` with `s` a third of the range (4).
fn bilateral_pair(deviations: [Option<f64>; 2], range: f64) -> (f64, f64) {
    let weight = |e: f64| (-0.5 * (3.0 * e / range).powi(2)).exp();
    let there = || deviations.into_iter().flatten();
    (there().map(|e| weight(e) * e).sum(), there().map(weight).sum())
}
