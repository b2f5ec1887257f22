use meniscus_gpu::{Binding, CameraUniform, Gpu, Recorder};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::smoothing::{CLOSE_TAPS, Rule, Smoothing, Width};
use super::{FilterImages, HostSurface, Properties, SurfaceFilter};
use crate::{SsfrError, twin};

/// Parameters of the narrow-range filter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct NarrowRangeParams {
    /// Standard deviation in projected particle spacings, all passes together, 0 to 10. Below 0.5 the bumps of the
    /// particles survive, above 2 detail is lost.
    pub sigma: f32,
    /// Passes over rows and columns, 1 to 16; their variances add up to that of `sigma`.
    pub iterations: u32,
    /// Depth range in drawn radii, 0.1 to 1000: what is further in front or behind is another surface. Fades over the outer
    /// half of the range.
    pub threshold: f32,
    /// How far behind, in drawn radii, what lies beyond the range is taken to be, 0 to 10: rounds silhouettes.
    pub clamp: f32,
}

impl Default for NarrowRangeParams {
    fn default() -> Self {
        Self { sigma: 1.0, iterations: 2, threshold: 8.0, clamp: 1.0 }
    }
}

impl NarrowRangeParams {
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
            close_taps: CLOSE_TAPS,
        }
    }
}

/// Narrow-range filter (Truong and Yuksel 2018): smooths a surface without mixing it with others in front or behind.
/// Measures deviations from the plane through the pixel, and is exact on tilted planes (`algorithms.md` 3.7).
pub struct NarrowRange {
    params: NarrowRangeParams,
    smoothing: Smoothing,
}

impl NarrowRange {
    /// Name in the registry.
    pub const NAME: &'static str = "narrow-range";

    /// Compiles the passes.
    ///
    /// # Errors
    /// A parameter out of range, or a shader that the driver does not take.
    pub fn new(gpu: &Gpu, params: NarrowRangeParams) -> Result<Self, SsfrError> {
        params.validate()?;
        Ok(Self { params, smoothing: Smoothing::new(gpu, Rule::NarrowRange)? })
    }
}

impl SurfaceFilter for NarrowRange {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn record(&self, recorder: &mut Recorder, gpu: &Gpu, camera: &Binding, images: &FilterImages<'_>) {
        self.smoothing.record(recorder, gpu, camera, images, &self.params.width());
    }

    fn filter_on_cpu(&self, camera: &CameraUniform, surface: &HostSurface<'_>) -> Vec<f32> {
        twin::narrow_range(&twin::HostView::new(camera), &self.params, surface)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_out_of_range_are_named() {
        assert!(NarrowRangeParams::default().validate().is_ok());
        let params = NarrowRangeParams { iterations: 0, ..Default::default() };
        assert!(params.validate().unwrap_err().to_string().contains("iterations is 0"));
    }
}
