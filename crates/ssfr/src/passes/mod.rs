//! The passes of the stage; each has the name of its shader.

mod coloring;
mod foam;
mod normal;
mod occlusion;
mod pages;
mod shape;
mod surface;
mod thickness;
mod triangles;

use meniscus_gpu::{
    ComputePipeline, ComputePipelineDescriptor, Definition, Gpu, GpuError, PicturePipeline,
    PicturePipelineDescriptor, Pixels, Shader, shader, wgpu,
};

pub use coloring::{ColoredSet, Coloring, NO_VALUE, ScaleUniform};
pub use foam::{FoamSplats, FoamUniform};
pub(crate) use normal::NormalPass;
pub(crate) use occlusion::tiles;
pub(crate) use pages::STRIP_WORDS;
pub use shape::{ShapePage, ShapePasses, ShapeWork};
pub(crate) use surface::SurfacePasses;
pub(crate) use thickness::ThicknessPasses;

/// What the passes of this stage import besides the common includes.
pub(crate) const INCLUDES: &[Shader] = &[
    shader!(include "ssfr/splat"),
    shader!(include "ssfr/strips"),
    shader!(include "ssfr/shape"),
    shader!(include "ssfr/ellipsoid"),
    shader!(include "ssfr/thickness"),
    shader!(include "ssfr/key"),
    shader!(include "ssfr/four"),
    shader!(include "ssfr/smoothing"),
    shader!(include "ssfr/rule"),
    shader!(include "ssfr/adaptive"),
];

pub(crate) fn pipeline(gpu: &Gpu, shader: Shader) -> ComputePipeline {
    pipeline_with(gpu, shader, &[])
}

pub(crate) fn pipeline_with(gpu: &Gpu, shader: Shader, definitions: &[Definition]) -> ComputePipeline {
    compile(gpu, shader, definitions, None)
}

/// As [`pipeline_with`] for a pass that adds its work to the counter `counts`.
pub(crate) fn counted_pipeline(
    gpu: &Gpu,
    shader: Shader,
    definitions: &[Definition],
    counts: &'static str,
) -> ComputePipeline {
    compile(gpu, shader, definitions, Some(counts))
}

/// A pass over the pixels that show fluid, which writes a texture of this format.
pub(crate) fn covered_pipeline(
    gpu: &Gpu,
    shader: Shader,
    definitions: &[Definition],
    target: wgpu::TextureFormat,
) -> Result<PicturePipeline, GpuError> {
    gpu.picture_pipeline(&PicturePipelineDescriptor {
        shader,
        includes: INCLUDES,
        definitions,
        targets: &[target],
        pixels: Pixels::Covered,
    })
}

fn compile(
    gpu: &Gpu,
    shader: Shader,
    definitions: &[Definition],
    counts: Option<&'static str>,
) -> ComputePipeline {
    gpu.compute_variant(&ComputePipelineDescriptor {
        includes: INCLUDES,
        definitions,
        counts,
        ..ComputePipelineDescriptor::new(shader)
    })
}
