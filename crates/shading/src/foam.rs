//! Foam over what a lighting model has lit.

use bytemuck::{Pod, Zeroable};
use meniscus_gpu::role::{FoamLayers, Radiance};
use meniscus_gpu::{
    ComputePipeline, ComputePipelineDescriptor, Dispatch, Gpu, HostField, HostStruct, Image, Recorder,
    Shader, Texture, host_fields, shader,
};

use crate::{INCLUDES, LightingInputs, ShadingError, WaterScale};

const SHADER: Shader = shader!("shading/foam");

/// The parameters as the GPU sees them; WGSL: `FoamLook` in `shaders/shading/foam.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct FoamLook {
    /// What the water takes of the light of bubbles, 1 / world unit ([`crate::LightingPass::extinction`]).
    pub extinction: [f32; 3],
    /// Spacing of the particles, world units.
    pub spacing_world: f32,
    /// Optical depth of foam where the surface is bent sharply, >= 0; 0: none.
    pub curvature: f32,
    /// Sine of the angle between normals 0.6 spacings apart at which that begins, > 0; in full at twice as much.
    pub curvature_threshold: f32,
    /// Pad.
    pub pad_a: f32,
    /// Pad to 16 bytes.
    pub pad_b: f32,
}

impl HostStruct for FoamLook {
    const WGSL_NAME: &'static str = "FoamLook";
    const FIELDS: &'static [HostField] =
        host_fields!(FoamLook { extinction, spacing_world, curvature, curvature_threshold, pad_a, pad_b });
}

impl FoamLook {
    /// Foam on water of this scale and extinction, with foam at crests by `curvature` from `curvature_threshold` on.
    pub fn new(extinction: [f32; 3], scale: WaterScale, curvature: f32, curvature_threshold: f32) -> Self {
        Self {
            extinction,
            spacing_world: scale.usable_spacing(),
            curvature,
            curvature_threshold,
            pad_a: 0.0,
            pad_b: 0.0,
        }
    }
}

/// Composes layers of foam with the picture that a lighting model has made: no model has to know foam.
#[derive(Debug)]
pub struct FoamPass {
    pipeline: ComputePipeline,
}

impl FoamPass {
    /// Compiles the pass.
    ///
    /// # Errors
    /// [`ShadingError::Gpu`] when the shader does not compile.
    pub fn new(gpu: &Gpu) -> Result<Self, ShadingError> {
        let descriptor =
            ComputePipelineDescriptor { includes: INCLUDES, ..ComputePipelineDescriptor::new(SHADER) };
        Ok(Self { pipeline: gpu.compute_pipeline(&descriptor)? })
    }

    /// Records `shading.foam`, which draws `layers` over `bare`: `output`, another texture of its size.
    #[expect(clippy::too_many_arguments, reason = "inputs and output of one pass")]
    pub fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        inputs: &LightingInputs<'_>,
        layers: &Image<FoamLayers>,
        look: &FoamLook,
        bare: &Texture<Radiance>,
        output: &Texture<Radiance>,
    ) {
        let mut bindings = inputs.bindings(recorder);
        bindings.extend([
            ("model", recorder.uniform(look)),
            ("foam_layers", layers.bind()),
            ("bare_radiance", bare.bind()),
            ("radiance", output.bind()),
        ]);
        bindings.retain(|(name, _)| self.pipeline.binds(name));
        let size = Dispatch::Pixels(inputs.camera.size_px);
        recorder.compute(gpu, "shading.foam", &self.pipeline, &bindings, size);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uniform_matches_its_shader() {
        FoamLook::check_layout(&SHADER, INCLUDES).unwrap();
    }
}
