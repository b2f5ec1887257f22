use bytemuck::{Pod, Zeroable};
use meniscus_gpu::{
    Binding, CameraUniform, ComputePipeline, ComputePipelineDescriptor, Dispatch, Gpu, HostField, HostStruct,
    Recorder, Shader, host_fields,
};
use meniscus_ssfr::filter::{HostSurface, INCLUDES, Properties, TAPS};
use meniscus_ssfr::{FilterEntry, FilterImages, SsfrError, SurfaceFilter};

use crate::{PlaneFitParams, twin};

const SHADER: Shader = Shader { name: "custom.plane_fit", source: include_str!("plane_fit.wgsl") };

/// The parameters as the GPU sees them; WGSL: `PlaneFit`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct PlaneFitUniform {
    sigma_radii: f32,
    range_radii: f32,
}

impl HostStruct for PlaneFitUniform {
    const WGSL_NAME: &'static str = "PlaneFit";
    const FIELDS: &'static [HostField] = host_fields!(PlaneFitUniform { sigma_radii, range_radii });
}

/// Smooths a surface by planes fitted to it, which leaves planes as they are.
pub struct PlaneFit {
    params: PlaneFitParams,
    pass: ComputePipeline,
}

impl PlaneFit {
    /// Name in the registry.
    pub const NAME: &'static str = "plane-fit";

    /// What the registry takes.
    pub fn entry() -> FilterEntry {
        FilterEntry::new(
            Self::NAME,
            "fits planes to the neighbourhood of each pixel; exact on planes up to their edges",
            |gpu, params| Ok(Box::new(Self::new(gpu, params)?)),
        )
    }

    /// Compiles the pass.
    ///
    /// # Errors
    /// A parameter out of range, or a shader that the driver does not take.
    pub fn new(gpu: &Gpu, params: PlaneFitParams) -> Result<Self, SsfrError> {
        params.validate()?;
        let descriptor = ComputePipelineDescriptor {
            includes: INCLUDES,
            counts: Some(TAPS),
            ..ComputePipelineDescriptor::new(SHADER)
        };
        Ok(Self { params, pass: gpu.compute_pipeline(&descriptor)? })
    }
}

impl SurfaceFilter for PlaneFit {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn record(&self, recorder: &mut Recorder, gpu: &Gpu, camera: &Binding, images: &FilterImages<'_>) {
        let mut source = images.front.bind();
        for (pass, sigma_radii) in (1..).zip(self.params.pass_sigmas_radii(images.spacing_per_radius)) {
            let uniform = PlaneFitUniform { sigma_radii, range_radii: self.params.range };
            let smoothed = if pass == self.params.passes {
                images.target.bind()
            } else {
                images.steps[pass as usize % 2].bind()
            };
            let bindings = [
                ("camera", camera.clone()),
                ("plane_fit", recorder.uniform(&uniform)),
                ("source", source),
                ("front", images.front.bind()),
                ("smoothed", smoothed.clone()),
            ];
            let pixels = Dispatch::Pixels(images.front.size());
            recorder.compute(gpu, SHADER.name, &self.pass, &bindings, pixels);
            source = smoothed;
        }
    }

    fn filter_on_cpu(&self, camera: &CameraUniform, surface: &HostSurface<'_>) -> Vec<f32> {
        twin::plane_fit(camera, &self.params, surface)
    }

    fn properties(&self) -> Properties {
        Properties {
            exact_up_to_silhouettes: true,
            nominal_sigma: Some(self.params.sigma),
            range_radii: Some(self.params.range),
            ..Properties::exact_on_tilted_planes()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uniform_has_the_layout_of_its_shader() {
        PlaneFitUniform::check_layout(&SHADER, INCLUDES).unwrap();
    }
}
