//! Normals without the noise that the places of single particles leave: what refraction sees.

use std::sync::{Mutex, PoisonError};

use bytemuck::{Pod, Zeroable};
use meniscus_gpu::role::ViewNormal;
use meniscus_gpu::{
    Binding, ComputePipeline, ComputePipelineDescriptor, Dispatch, Gpu, GpuError, HostField, HostStruct,
    Recorder, Shader, Texture, host_fields, shader,
};

use crate::{INCLUDES, LightingInputs};

const SHADER: Shader = shader!("shading/calm_normals");

/// Pixels per side of a block that shares one normal; WGSL: `BLOCK_PX` in `shaders/shading/calm.inc.wgsl`.
pub(crate) const BLOCK_PX: u32 = 4;

/// WGSL: `Fit` in `shaders/shading/calm_normals.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
struct FitUniform {
    spacing_world: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

impl HostStruct for FitUniform {
    const WGSL_NAME: &'static str = "Fit";
    const FIELDS: &'static [HostField] = host_fields!(FitUniform { spacing_world, pad_a, pad_b, pad_c });
}

/// Makes what `meniscus::calm` reads.
#[derive(Debug)]
pub(crate) struct CalmPass {
    pipeline: ComputePipeline,
    /// Of the last picture; another size takes another.
    normals: Mutex<Option<Texture<ViewNormal>>>,
}

impl CalmPass {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let pipeline = gpu.compute_pipeline(&ComputePipelineDescriptor {
            includes: INCLUDES,
            ..ComputePipelineDescriptor::new(SHADER)
        })?;
        Ok(Self { pipeline, normals: Mutex::default() })
    }

    /// Records `shading.calm_normals`; the normals, for the binding `calm_normals`.
    pub(crate) fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        inputs: &LightingInputs<'_>,
    ) -> Result<Binding, GpuError> {
        let size = inputs.camera.size_px.map(|pixels| pixels.div_ceil(BLOCK_PX));
        let mut kept = self.normals.lock().unwrap_or_else(PoisonError::into_inner);
        let normals = match kept.take() {
            Some(normals) if normals.size() == size => normals,
            stale => {
                if stale.is_some() {
                    drop(stale);
                    gpu.forget_bindings();
                }
                Texture::new(gpu, size)?
            }
        };
        let spacing_world = inputs.scale.usable_spacing();
        let uniform = FitUniform { spacing_world, pad_a: 0.0, pad_b: 0.0, pad_c: 0.0 };
        let bindings = [
            ("camera", recorder.uniform(inputs.camera)),
            ("fit", recorder.uniform(&uniform)),
            ("distances", inputs.distance.bind()),
            ("normals", inputs.normal.bind()),
            ("blocks", normals.bind()),
        ];
        recorder.compute(gpu, "shading.calm_normals", &self.pipeline, &bindings, Dispatch::Pixels(size));
        Ok(kept.insert(normals).bind())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uniform_matches_its_shader() {
        FitUniform::check_layout(&SHADER, INCLUDES).unwrap();
    }
}
