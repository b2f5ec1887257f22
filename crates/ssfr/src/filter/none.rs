use meniscus_gpu::{Binding, CameraUniform, ComputePipeline, Gpu, GpuError, Recorder, shader};

use super::{FilterImages, HostSurface, Properties, SurfaceFilter};
use crate::passes::pipeline;
use crate::twin;

/// Leaves the surface as it is: every particle shows.
pub struct NoFilter {
    copy: ComputePipeline,
}

impl NoFilter {
    /// Name in the registry.
    pub const NAME: &'static str = "none";

    /// Compiles the copy.
    ///
    /// # Errors
    /// [`GpuError::Shader`] when the driver does not take it.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self { copy: pipeline(gpu, shader!("ssfr/copy")) })
    }
}

impl SurfaceFilter for NoFilter {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn record(&self, recorder: &mut Recorder, gpu: &Gpu, _: &Binding, images: &FilterImages<'_>) {
        let bindings = [
            ("front", images.front.bind()),
            ("distance", images.target.bind()),
            ("covered", images.covered.list(recorder, gpu)),
        ];
        recorder.compute(gpu, "ssfr.copy", &self.copy, &bindings, images.over_covered());
    }

    fn filter_on_cpu(&self, _: &CameraUniform, surface: &HostSurface<'_>) -> Vec<f32> {
        twin::none(surface)
    }

    fn properties(&self) -> Properties {
        Properties {
            exact_up_to_silhouettes: true,
            nominal_sigma: Some(0.0),
            range_radii: Some(0.0),
            ..Properties::exact_on_tilted_planes()
        }
    }
}
