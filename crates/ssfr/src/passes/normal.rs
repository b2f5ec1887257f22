use meniscus_gpu::{Binding, ComputePipeline, Dispatch, Gpu, GpuError, Recorder, shader};

use super::pipeline;
use crate::SurfaceImages;

/// Normals of the smoothed surface.
pub(crate) struct NormalPass {
    normal: ComputePipeline,
}

impl NormalPass {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self { normal: pipeline(gpu, shader!("ssfr/normal"))? })
    }

    pub(crate) fn record(
        &self,
        recorder: &mut Recorder,
        gpu: &Gpu,
        camera: &Binding,
        images: &SurfaceImages,
    ) {
        let bindings = [
            ("camera", camera.clone()),
            ("distance", images.distance.bind()),
            ("radius", images.radius.bind()),
            ("normal", images.normal.bind()),
        ];
        recorder.compute(gpu, "ssfr.normal", &self.normal, &bindings, Dispatch::Pixels(images.size()));
    }
}
