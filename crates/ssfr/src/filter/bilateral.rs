use meniscus_gpu::{Binding, CameraUniform, Gpu, Recorder};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::smoothing::{CLOSE_TAPS, Rule, Smoothing, Width};
use super::{FilterImages, HostSurface, Properties, SurfaceFilter};
use crate::{SsfrError, twin};

/// Parameters of the bilateral filter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BilateralParams {
    /// Standard deviation in projected particle spacings, all passes together, 0 to 10.
    pub sigma: f32,
    /// Passes over rows and columns, 1 to 16; their variances add up to that of `sigma`.
    pub iterations: u32,
    /// Depth range in drawn radii, 0.1 to 1000: three standard deviations of the weight by depth.
    pub threshold: f32,
}

impl Default for BilateralParams {
    fn default() -> Self {
        Self { sigma: 1.0, iterations: 2, threshold: 10.0 }
    }
}

impl BilateralParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`SsfrError::Parameter`] for the first number out of range.
    pub fn validate(&self) -> Result<(), SsfrError> {
        self.width().validate()
    }

    pub(crate) fn width(&self) -> Width {
        // Nothing is clamped.
        Width {
            sigma: self.sigma,
            iterations: self.iterations,
            range: self.threshold,
            clamp: 0.0,
            close_taps: CLOSE_TAPS,
        }
    }
}

/// Bilateral Gaussian (Tomasi and Manduchi 1998; `algorithms.md` 4): weights fall with the distance in the picture and with
/// the deviation in depth, here from the plane through the pixel, so that slopes do not count as edges.
pub struct Bilateral {
    params: BilateralParams,
    smoothing: Smoothing,
}

impl Bilateral {
    /// Name in the registry.
    pub const NAME: &'static str = "bilateral";

    /// Compiles the passes.
    ///
    /// # Errors
    /// A parameter out of range, or a shader that the driver does not take.
    pub fn new(gpu: &Gpu, params: BilateralParams) -> Result<Self, SsfrError> {
        params.validate()?;
        Ok(Self { params, smoothing: Smoothing::new(gpu, Rule::Bilateral)? })
    }
}

impl SurfaceFilter for Bilateral {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn record(&self, recorder: &mut Recorder, gpu: &Gpu, camera: &Binding, images: &FilterImages<'_>) {
        self.smoothing.record(recorder, gpu, camera, images, &self.params.width());
    }

    fn filter_on_cpu(&self, camera: &CameraUniform, surface: &HostSurface<'_>) -> Vec<f32> {
        twin::bilateral(&twin::HostView::new(camera), &self.params, surface)
    }

    fn properties(&self) -> Properties {
        Properties {
            nominal_sigma: Some(self.params.sigma),
            range_radii: Some(self.params.threshold),
            even_in_close_ups: true,
            ..Properties::exact_on_tilted_planes()
        }
    }
}
