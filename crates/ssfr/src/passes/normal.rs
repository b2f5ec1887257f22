use meniscus_gpu::role::{TextureRole, ViewNormal};
use meniscus_gpu::{Binding, Gpu, GpuError, PicturePipeline, Recorder, shader};

use super::covered_pipeline;
use crate::SurfaceImages;

/// Normals of the smoothed surface.
pub(crate) struct NormalPass {
    normal: PicturePipeline,
}

impl NormalPass {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self { normal: covered_pipeline(gpu, shader!("ssfr/normal"), &[], ViewNormal::FORMAT)? })
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
            ("front", images.front.bind()),
        ];
        let targets = [("normal", images.normal.view())];
        recorder.picture(gpu, "ssfr.normal", &self.normal, &bindings, &targets, Some(&images.covered));
    }
}
