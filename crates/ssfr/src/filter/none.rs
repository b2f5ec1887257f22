use meniscus_gpu::{Binding, CameraUniform, ComputePipeline, Dispatch, Gpu, GpuError, Recorder, shader};

use super::{FilterImages, HostSurface, SurfaceFilter};
use crate::passes::pipeline;

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
        Ok(Self { copy: pipeline(gpu, shader!("ssfr/copy"))? })
    }
}

impl SurfaceFilter for NoFilter {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn record(&self, recorder: &mut Recorder, gpu: &Gpu, camera: &Binding, images: &FilterImages<'_>) {
        let bindings = [
            ("camera", camera.clone()),
            ("source", images.source.bind()),
            ("destination", images.target.bind()),
        ];
        recorder.compute(gpu, "ssfr.copy", &self.copy, &bindings, Dispatch::Pixels(images.source.size()));
    }

    fn filter_on_cpu(&self, _: &CameraUniform, surface: &HostSurface<'_>) -> Vec<f32> {
        surface.distance.to_vec()
    }
}
