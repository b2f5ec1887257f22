use bytemuck::{Pod, Zeroable};
use meniscus_gpu::role::{FilterStep, TextureRole};
use meniscus_gpu::{
    Binding, ComputePipeline, Definition, Gpu, HostField, HostStruct, PicturePipeline, Recorder, shader,
};

use super::{FilterImages, TAPS};
use crate::SsfrError;
use crate::params::check_range;
use crate::passes::{counted_pipeline, covered_pipeline};

/// Which pairs of mirrored samples count, and as what: `meniscus::rule` of `shaders/ssfr/rule.inc.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rule {
    NarrowRange,
    Bilateral,
    Gaussian,
    /// Between bilateral and narrow-range by the complexity of pixels in the second scratch buffer.
    Adaptive,
}

impl Rule {
    fn definitions(self) -> &'static [Definition] {
        match self {
            Self::NarrowRange => &[],
            Self::Bilateral => &[Definition { name: "BILATERAL", value: 1 }],
            Self::Gaussian => &[Definition { name: "GAUSSIAN", value: 1 }],
            Self::Adaptive => &[Definition { name: "ADAPTIVE", value: 1 }],
        }
    }
}

/// How wide a smoothing is, and what belongs to a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Width {
    /// Standard deviation of all passes together in projected spacings.
    pub sigma: f32,
    /// Passes over rows and columns.
    pub iterations: u32,
    /// Range in drawn radii.
    pub range: f32,
    /// How far behind what lies behind the range is taken to be, in drawn radii.
    pub clamp: f32,
    /// Taps to each side from which on they are spread out, up to four pixels apart, in all but the last iteration; for each spacing
    /// of sigma beyond the first as many again.
    pub close_taps: f32,
}

impl Width {
    /// Rows and columns in turn, the order swapped from one iteration to the next (`algorithms.md` 3.5).
    pub fn passes(&self) -> impl Iterator<Item = LinePass> {
        (0..).zip(shares(self.iterations, 0.5)).flat_map(|(i, share)| {
            let order = if i % 2 == 0 { [[1, 0], [0, 1]] } else { [[0, 1], [1, 0]] };
            let is_last = i + 1 >= self.iterations;
            let taps = if is_last { [MOST_LAST_TAPS; 2] } else { [self.close_taps, MOST_TAPS] };
            let [close_taps, most_taps] = taps.map(|taps| taps * (self.sigma * share.sqrt()).max(1.0));
            order.map(|direction| LinePass { direction, share, close_taps, most_taps, most_gap: 0 })
        })
    }

    /// As the clean-up sees the passes: the last one's pattern is what is left of them.
    pub fn clean_up(&self) -> LinePass {
        self.passes().last().map(|last| LinePass { direction: [0, 0], ..last }).unwrap_or_default()
    }

    /// The coarse passes that come before the clean-up in pictures of spacings of up to `spacing_px` pixels, which are `side_px` pixels
    /// wide or high at most: each takes away what repeats by four of its taps, and what repeats by two.
    pub fn coarse_clean_up(&self, spacing_px: f32, side_px: u32) -> impl Iterator<Item = LinePass> {
        let last = self.clean_up();
        let reach_px = REACH_PER_SIGMA * self.sigma * spacing_px * last.share.sqrt();
        // As `pattern_of` of `shaders/ssfr/smoothing.inc.wgsl`, but for rounding up to a power of two, which gaps are.
        let period = reach_px / (0.75 * last.most_taps);
        let gaps = (1..=6).map(|level| 4_i32.pow(level));
        let needed = gaps.filter(move |&gap| period > gap as f32 && gap.unsigned_abs() <= side_px / 4);
        let passes: Vec<_> = needed.map(|most_gap| LinePass { most_gap, ..last }).collect();
        passes.into_iter().rev()
    }

    /// How far apart the taps of `pass` are in pictures of spacings of mostly `typical_px`, up to `most_px` pixels.
    fn steps(&self, pass: &LinePass, typical_px: f32, most_px: f32) -> Steps {
        let reach_px = |spacing_px: f32| REACH_PER_SIGMA * self.sigma * spacing_px * pass.share.sqrt();
        // As `taps_of` of `shaders/ssfr/smoothing.inc.wgsl`: to this reach they are side by side, to twice that two pixels apart.
        let close_taps = pass.close_taps.min(pass.most_taps);
        if reach_px(most_px) <= close_taps {
            Steps::One
        } else if reach_px(typical_px) <= MOSTLY_SMALL * close_taps
            && reach_px(most_px) <= LARGEST * close_taps
        {
            Steps::Small
        } else {
            Steps::Any
        }
    }

    /// Checks the ranges, under the names that filters give these parameters.
    pub(super) fn validate(&self) -> Result<(), SsfrError> {
        check_range("sigma", self.sigma, 0.0..=10.0, "0 to 10")?;
        check_range("iterations", self.iterations as f32, 1.0..=16.0, "1 to 16")?;
        check_range("threshold", self.range, 0.1..=1000.0, "0.1 to 1000")?;
        check_range("clamp", self.clamp, 0.0..=10.0, "0 to 10")
    }
}

/// A pass along rows or columns.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct LinePass {
    /// Pixels per step: `[1, 0]` or `[0, 1]`.
    pub direction: [u32; 2],
    /// Fraction of the variance of all passes in this direction.
    pub share: f32,
    /// Taps to each side from which on they are spread out, up to four pixels apart.
    pub close_taps: f32,
    /// Taps to each side, at most.
    pub most_taps: f32,
    /// Of coarse passes of the clean-up: pixels from one tap to the next, at most.
    pub most_gap: i32,
}

/// Typical reach, in taps side by side, up to which few lines have taps more than two pixels apart, which would need a reach of two: what
/// is a quarter nearer to the eye.
const MOSTLY_SMALL: f32 = 1.6;

/// Largest reach, in taps side by side, that may be gone through pixel by pixel: a single drop before the eye may fill the picture.
const LARGEST: f32 = 8.0;

/// Pixels from one tap to the next, for which there are variants of the passes along rows and columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Steps {
    One,
    /// Mostly up to two.
    Small,
    Any,
}

impl Steps {
    const ALL: [Self; 3] = [Self::One, Self::Small, Self::Any];

    fn definitions(self) -> &'static [Definition] {
        match self {
            Self::One => &[Definition { name: "STEPS_OF_ONE", value: 1 }],
            Self::Small => &[Definition { name: "SMALL_STEPS", value: 1 }],
            Self::Any => &[],
        }
    }
}

/// [`Width::close_taps`] of filters that look at each tap by itself. They are at most 0.7 standard deviations apart, 1.4 of the last
/// iteration's, which leaves 4e-5 of what repeats by that. Streaks that the edges of other surfaces leave are as wide as taps are apart:
/// those of four pixels are for the clean-up.
pub(super) const CLOSE_TAPS: f32 = 8.0;
/// Most taps to each side in all but the last iteration.
pub(super) const MOST_TAPS: f32 = 24.0;
/// In the last iteration. What the others leave between taps that are far apart, it smooths out; what it leaves, only the clean-up
/// does, which reaches over four pixels.
const MOST_LAST_TAPS: f32 = 48.0;

/// `REACH * WIDENED` of `shaders/ssfr/smoothing.inc.wgsl`: where kernels end, in the standard deviations they have.
const REACH_PER_SIGMA: f32 = 2.5 / 0.8928;

/// `meniscus::smoothing::Smoothing` of `shaders/ssfr/smoothing.inc.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct SmoothingUniform {
    direction: [u32; 2],
    sigma_spacings: f32,
    spacing_per_radius: f32,
    share: f32,
    range_radii: f32,
    clamp_radii: f32,
    close_taps: f32,
    most_taps: f32,
    most_gap: i32,
}

impl HostStruct for SmoothingUniform {
    const WGSL_NAME: &'static str = "Smoothing";
    const FIELDS: &'static [HostField] = meniscus_gpu::host_fields!(SmoothingUniform {
        direction,
        sigma_spacings,
        spacing_per_radius,
        share,
        range_radii,
        clamp_radii,
        close_taps,
        most_taps,
        most_gap,
    });
}

impl SmoothingUniform {
    pub(super) fn new(width: &Width, spacing_per_radius: f32, pass: LinePass) -> Self {
        Self {
            direction: pass.direction,
            sigma_spacings: width.sigma,
            spacing_per_radius,
            share: pass.share,
            range_radii: width.range,
            clamp_radii: width.clamp,
            close_taps: pass.close_taps,
            most_taps: pass.most_taps,
            most_gap: pass.most_gap,
        }
    }
}

/// The passes that filters with a [`Rule`] share: keys, rows and columns in turn, a small square.
pub(super) struct Smoothing {
    rule: Rule,
    key: PicturePipeline,
    /// For each of [`Steps::ALL`].
    along: [ComputePipeline; 3],
    square: ComputePipeline,
    coarse_square: ComputePipeline,
}

impl Smoothing {
    pub(super) fn new(gpu: &Gpu, rule: Rule) -> Result<Self, SsfrError> {
        let definitions = rule.definitions();
        let coarse = [definitions, &[Definition { name: "COARSE", value: 1 }]].concat();
        Ok(Self {
            rule,
            key: key_pipeline(gpu, &[])?,
            along: Steps::ALL.map(|steps| {
                let definitions = [definitions, steps.definitions()].concat();
                counted_pipeline(gpu, shader!("ssfr/smooth_along"), &definitions, TAPS)
            }),
            square: counted_pipeline(gpu, shader!("ssfr/smooth_square"), definitions, TAPS),
            coarse_square: counted_pipeline(gpu, shader!("ssfr/smooth_square"), &coarse, TAPS),
        })
    }

    pub(super) fn record(
        &self,
        recorder: &mut Recorder,
        gpu: &Gpu,
        camera: &Binding,
        images: &FilterImages<'_>,
        width: &Width,
    ) {
        let lines = images.covered.dispatch_lines();
        let [mut next, mut other] = images.steps.map(|image| image.bind());
        record_keys(recorder, gpu, camera, images, &self.key, GAP);
        let common = |recorder: &mut Recorder, pass, source| {
            let uniform = SmoothingUniform::new(width, images.spacing_per_radius, pass);
            let mut bindings = vec![
                ("camera", camera.clone()),
                ("smoothing", recorder.uniform(&uniform)),
                ("front", images.front.bind()),
                ("source", source),
                ("tiles", images.covered.tiles()),
            ];
            if self.rule == Rule::Adaptive {
                bindings.push(("complexity", images.scratch[1].bind()));
            }
            bindings
        };
        let mut current = other.clone();
        let [typical_px, most_px] =
            [images.typical_radius_px, images.most_radius_px].map(|px| images.spacing_per_radius * px);
        let [width_px, height_px] = images.front.size();
        let coarse = width.coarse_clean_up(most_px, width_px.max(height_px));
        let along = |pass: &LinePass| &self.along[width.steps(pass, typical_px, most_px) as usize];
        let passes = width.passes().map(|pass| ("ssfr.smooth_along", along(&pass), pass));
        for (name, pipeline, pass) in
            passes.chain(coarse.map(|pass| ("ssfr.smooth_square", &self.coarse_square, pass)))
        {
            let mut bindings = common(recorder, pass, current);
            bindings.push(("smoothed", next.clone()));
            recorder.compute(gpu, name, pipeline, &bindings, lines);
            current = next.clone();
            std::mem::swap(&mut next, &mut other);
        }
        let mut bindings = common(recorder, width.clean_up(), current);
        bindings.push(("smoothed", images.target.bind()));
        recorder.compute(gpu, "ssfr.smooth_square", &self.square, &bindings, lines);
    }
}

/// `GAP` of `shaders/ssfr/key.inc.wgsl`.
pub(super) const GAP: f32 = -3.4e38;

/// The pass from distances to what smoothing works on, with these definitions.
pub(super) fn key_pipeline(gpu: &Gpu, definitions: &[Definition]) -> Result<PicturePipeline, SsfrError> {
    Ok(covered_pipeline(gpu, shader!("ssfr/smooth_key"), definitions, FilterStep::FORMAT)?)
}

/// Fills both steps with `gap`, and the second with what `key` makes of the distances of covered pixels; passes over all of these then
/// alternate between the steps, beginning at the second.
pub(super) fn record_keys(
    recorder: &mut Recorder,
    gpu: &Gpu,
    camera: &Binding,
    images: &FilterImages<'_>,
    key: &PicturePipeline,
    gap: f32,
) {
    let gaps = images.steps.map(|step| (step.view(), [gap.into(), 0.0, 0.0, 0.0]));
    recorder.clear_textures(gpu, "ssfr.clear", &gaps);
    let mut bindings = vec![("camera", camera.clone()), ("front", images.front.bind())];
    bindings.retain(|(name, _)| key.binds(name));
    let targets = [("key", images.steps[1].view())];
    recorder.picture(gpu, "ssfr.smooth_key", key, &bindings, &targets, Some(images.covered));
}

/// Fractions of a variance that `steps` steps have, each a little narrower than the one before, down to `last_width` of the
/// first's width. Wide ones sample every few pixels only; later ones smooth out what that leaves between the samples.
pub(super) fn shares(steps: u32, last_width: f32) -> impl Iterator<Item = f32> {
    let width = move |step: u32| 1.0 - (1.0 - last_width) * step as f32 / (steps.max(2) - 1) as f32;
    let total: f32 = (0..steps).map(|step| width(step).powi(2)).sum();
    (0..steps).map(move |step| width(step).powi(2) / total)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::passes::INCLUDES;

    #[test]
    fn the_steps_add_up_to_the_whole() {
        for steps in [1, 2, 16, 256] {
            let shares: Vec<f32> = shares(steps, 0.5).collect();
            assert_eq!(shares.len(), steps as usize);
            assert!((shares.iter().sum::<f32>() - 1.0).abs() < 1e-5);
            assert!(shares.is_sorted_by(|a, b| a > b));
        }
    }

    #[test]
    fn the_uniform_has_the_layout_of_its_shaders() {
        for shader in
            [shader!("ssfr/smooth_along"), shader!("ssfr/smooth_square"), shader!("ssfr/narrow_range_paper")]
        {
            SmoothingUniform::check_layout(&shader, INCLUDES).unwrap();
        }
    }
}
