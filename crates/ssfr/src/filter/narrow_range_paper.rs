use meniscus_gpu::role::NO_SURFACE;
use meniscus_gpu::{
    Binding, CameraUniform, ComputePipeline, Definition, Gpu, PicturePipeline, Recorder, shader,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::smoothing::{MOST_TAPS, SmoothingUniform, Width, key_pipeline, record_keys};
use super::{FilterImages, HostSurface, Properties, SurfaceFilter, TAPS};
use crate::passes::counted_pipeline;
use crate::{SsfrError, twin};

/// Parameters of the narrow-range filter as published.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct NarrowRangePaperParams {
    /// Standard deviation in projected particle spacings, all passes together, 0 to 10.
    pub sigma: f32,
    /// Passes over rows and columns, 1 to 16; their variances add up to that of `sigma`.
    pub iterations: u32,
    /// Depth range in drawn radii around the pixel, 0.1 to 1000; it widens outwards by what lies in it.
    pub threshold: f32,
    /// How far behind, in drawn radii, what lies behind the range is taken to be, 0 to 10.
    pub clamp: f32,
}

impl Default for NarrowRangePaperParams {
    fn default() -> Self {
        Self { sigma: 1.0, iterations: 2, threshold: 10.0, clamp: 1.0 }
    }
}

impl NarrowRangePaperParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`SsfrError::Parameter`] for the first number out of range.
    pub fn validate(&self) -> Result<(), SsfrError> {
        self.width().validate()
    }

    pub(crate) fn width(&self) -> Width {
        Width {
            sigma: self.sigma,
            iterations: self.iterations,
            range: self.threshold,
            clamp: self.clamp,
            // Each tap widens the range for the next one.
            close_taps: MOST_TAPS,
        }
    }
}

/// Narrow-range filter as published (Truong and Yuksel 2018; `algorithms.md` 3.1 to 3.3): measures differences of distance,
/// with a range that widens outwards. For comparison.
pub struct NarrowRangePaper {
    params: NarrowRangePaperParams,
    distance: PicturePipeline,
    along: ComputePipeline,
    square: ComputePipeline,
}

impl NarrowRangePaper {
    /// Name in the registry.
    pub const NAME: &'static str = "narrow-range-paper";

    /// Compiles the passes.
    ///
    /// # Errors
    /// A parameter out of range, or a shader that the driver does not take.
    pub fn new(gpu: &Gpu, params: NarrowRangePaperParams) -> Result<Self, SsfrError> {
        params.validate()?;
        let paper = Definition { name: "PAPER", value: 1 };
        let square = Definition { name: "SQUARE", value: 1 };
        Ok(Self {
            params,
            distance: key_pipeline(gpu, &[paper])?,
            along: counted_pipeline(gpu, shader!("ssfr/narrow_range_paper"), &[], TAPS),
            square: counted_pipeline(gpu, shader!("ssfr/narrow_range_paper"), &[square], TAPS),
        })
    }
}

impl SurfaceFilter for NarrowRangePaper {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn record(&self, recorder: &mut Recorder, gpu: &Gpu, camera: &Binding, images: &FilterImages<'_>) {
        let [mut next, mut other] = images.steps.map(|image| image.bind());
        record_keys(recorder, gpu, camera, images, &self.distance, NO_SURFACE);
        let mut record = |pipeline: &ComputePipeline, pass, source, smoothed| {
            let uniform = SmoothingUniform::new(&self.params.width(), images.spacing_per_radius, pass);
            let bindings = [
                ("camera", camera.clone()),
                ("smoothing", recorder.uniform(&uniform)),
                ("front", images.front.bind()),
                ("source", source),
                ("smoothed", smoothed),
                ("covered", images.covered.list(recorder, gpu)),
            ];
            let pixels = images.over_covered();
            recorder.compute(gpu, "ssfr.narrow_range_paper", pipeline, &bindings, pixels);
        };
        let mut current = other.clone();
        for pass in self.params.width().passes() {
            record(&self.along, pass, current, next.clone());
            current = next.clone();
            std::mem::swap(&mut next, &mut other);
        }
        record(&self.square, self.params.width().clean_up(), current, images.target.bind());
    }

    fn filter_on_cpu(&self, camera: &CameraUniform, surface: &HostSurface<'_>) -> Vec<f32> {
        twin::narrow_range_paper(&twin::HostView::new(camera), &self.params, surface)
    }

    fn properties(&self) -> Properties {
        Properties {
            // A plane's distances are affine in the pixel in parallel projection only. There the clamp beyond the range and
            // the samples left out in front of it are not: planes so steep that the range cannot follow from tap to tap.
            nominal_sigma: Some(self.params.sigma),
            range_radii: Some(self.params.threshold),
            even_in_close_ups: true,
            ..Properties::default()
        }
    }
}
