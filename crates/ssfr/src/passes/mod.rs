//! The passes of the stage; each has the name of its shader.

mod normal;
mod surface;
mod thickness;

use meniscus_gpu::{ComputePipeline, ComputePipelineDescriptor, Definition, Gpu, GpuError, Shader, shader};

pub(crate) use normal::NormalPass;
pub(crate) use surface::SurfacePasses;
pub(crate) use thickness::ThicknessPasses;

/// What the passes of this stage import besides the common includes.
pub(crate) const INCLUDES: &[Shader] = &[
    shader!(include "ssfr/splat"),
    shader!(include "ssfr/thickness"),
    shader!(include "ssfr/key"),
    shader!(include "ssfr/narrow_range"),
];

pub(crate) fn pipeline(gpu: &Gpu, shader: Shader) -> Result<ComputePipeline, GpuError> {
    pipeline_with(gpu, shader, &[])
}

pub(crate) fn pipeline_with(
    gpu: &Gpu,
    shader: Shader,
    definitions: &[Definition],
) -> Result<ComputePipeline, GpuError> {
    gpu.compute_pipeline(&ComputePipelineDescriptor { shader, includes: INCLUDES, definitions })
}
