use meniscus_gpu::{Binding, CameraUniform, Gpu, Recorder};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::smoothing::{CLOSE_TAPS, Rule, Smoothing, Width};
use super::{FilterImages, HostSurface, Properties, SurfaceFilter};
use crate::{SsfrError, twin};

/// Parameters of the plain Gaussian.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GaussianParams {
    /// Standard deviation in projected particle spacings, 0 to 10.
    pub sigma: f32,
}

impl Default for GaussianParams {
    fn default() -> Self {
        Self { sigma: 1.0 }
    }
}

impl GaussianParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`SsfrError::Parameter`] for the first number out of range.
    pub fn validate(&self) -> Result<(), SsfrError> {
        self.width().validate()
    }

    pub(crate) fn width(&self) -> Width {
        // One after the other are one, and the narrower of two smooths what a wide one leaves between its taps. No range.
        Width { sigma: self.sigma, iterations: 2, range: 1.0, clamp: 0.0, close_taps: CLOSE_TAPS }
    }
}

/// Plain Gaussian over what is covered: mixes surfaces in front and behind. For comparison.
pub struct Gaussian {
    params: GaussianParams,
    smoothing: Smoothing,
}

impl Gaussian {
    /// Name in the registry.
    pub const NAME: &'static str = "gaussian";

    /// Compiles the passes.
    ///
    /// # Errors
    /// A parameter out of range, or a shader that the driver does not take.
    pub fn new(gpu: &Gpu, params: GaussianParams) -> Result<Self, SsfrError> {
        params.validate()?;
        Ok(Self { params, smoothing: Smoothing::new(gpu, Rule::Gaussian)? })
    }
}

impl SurfaceFilter for Gaussian {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn record(&self, recorder: &mut Recorder, gpu: &Gpu, camera: &Binding, images: &FilterImages<'_>) {
        self.smoothing.record(recorder, gpu, camera, images, &self.params.width());
    }

    fn filter_on_cpu(&self, camera: &CameraUniform, surface: &HostSurface<'_>) -> Vec<f32> {
        twin::gaussian(&twin::HostView::new(camera), &self.params, surface)
    }

    fn properties(&self) -> Properties {
        Properties {
            nominal_sigma: Some(self.params.sigma),
            even_in_close_ups: true,
            ..Properties::exact_on_tilted_planes()
        }
    }
}
