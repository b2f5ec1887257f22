use meniscus_gpu::{Binding, ComputePipeline, Gpu, Recorder, covered, shader};

use super::pipeline;
use crate::SurfaceImages;

/// Normals of the smoothed surface.
pub(crate) struct NormalPass {
    normal: ComputePipeline,
}

impl NormalPass {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        Self { normal: pipeline(gpu, shader!("ssfr/normal")) }
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
            ("normal", images.normal.bind()),
            ("covered", images.covered.bind()),
        ];
        recorder.compute(gpu, "ssfr.normal", &self.normal, &bindings, covered::dispatch(images.size()));
    }
}
