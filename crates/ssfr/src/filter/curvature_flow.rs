use bytemuck::{Pod, Zeroable};
use meniscus_gpu::{
    Binding, CameraUniform, ComputePipeline, Definition, Gpu, HostField, HostStruct, PicturePipeline,
    Recorder, shader,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::smoothing::{GAP, key_pipeline, record_keys, shares};
use super::{FilterImages, HostSurface, Properties, SurfaceFilter, TAPS};
use crate::params::check_range;
use crate::passes::counted_pipeline;
use crate::{SsfrError, twin};

/// Parameters of the curvature flow.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CurvatureFlowParams {
    /// Standard deviation in projected particle spacings that the whole flow has on flat surfaces, 0 to 10: the square root
    /// of its duration.
    pub sigma: f32,
    /// Steps, 1 to 256, each stable. More are smoother and dearer, and do not flow longer.
    pub iterations: u32,
    /// Depth range in drawn radii, 0.1 to 1000: what bends by more within a difference is an edge, across which nothing
    /// flows. Published are 5 for differences to one side; particles that hide each other at grazing angles need more.
    pub threshold: f32,
}

impl Default for CurvatureFlowParams {
    fn default() -> Self {
        Self { sigma: 1.0, iterations: 16, threshold: 10.0 }
    }
}

impl CurvatureFlowParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`SsfrError::Parameter`] for the first number out of range.
    pub fn validate(&self) -> Result<(), SsfrError> {
        check_range("sigma", self.sigma, 0.0..=10.0, "0 to 10")?;
        check_range("iterations", self.iterations as f32, 1.0..=256.0, "1 to 256")?;
        check_range("threshold", self.threshold, 0.1..=1000.0, "0.1 to 1000")
    }

    /// Fractions of the flow's duration, step by step. Differences are as wide as the square root of a step's duration; equal
    /// ones would never see waves of just that length.
    pub(crate) fn shares(&self) -> impl Iterator<Item = f32> {
        shares(self.iterations, 0.125)
    }
}

/// `CurvatureFlow` of `shaders/ssfr/curvature_flow.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct CurvatureFlowUniform {
    sigma_spacings: f32,
    share: f32,
    spacing_per_radius: f32,
    range_radii: f32,
}

impl HostStruct for CurvatureFlowUniform {
    const WGSL_NAME: &'static str = "CurvatureFlow";
    const FIELDS: &'static [HostField] = meniscus_gpu::host_fields!(CurvatureFlowUniform {
        sigma_spacings,
        share,
        spacing_per_radius,
        range_radii,
    });
}

/// Flow of the surface by its mean curvature (van der Laan et al. 2009; `algorithms.md` 5), which flattens bumps and flows
/// across no edge.
pub struct CurvatureFlow {
    params: CurvatureFlowParams,
    key: PicturePipeline,
    step: ComputePipeline,
    last: ComputePipeline,
}

impl CurvatureFlow {
    /// Name in the registry.
    pub const NAME: &'static str = "curvature-flow";

    /// Compiles the passes.
    ///
    /// # Errors
    /// A parameter out of range, or a shader that the driver does not take.
    pub fn new(gpu: &Gpu, params: CurvatureFlowParams) -> Result<Self, SsfrError> {
        params.validate()?;
        let last = Definition { name: "LAST", value: 1 };
        Ok(Self {
            params,
            key: key_pipeline(gpu, &[])?,
            step: counted_pipeline(gpu, shader!("ssfr/curvature_flow"), &[], TAPS),
            last: counted_pipeline(gpu, shader!("ssfr/curvature_flow"), &[last], TAPS),
        })
    }
}

impl SurfaceFilter for CurvatureFlow {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn record(&self, recorder: &mut Recorder, gpu: &Gpu, camera: &Binding, images: &FilterImages<'_>) {
        let [mut next, mut current] = images.steps.map(|image| image.bind());
        record_keys(recorder, gpu, camera, images, &self.key, GAP);
        for (step, share) in (1..).zip(self.params.shares()) {
            let is_last = step == self.params.iterations;
            let uniform = CurvatureFlowUniform {
                sigma_spacings: self.params.sigma,
                share,
                spacing_per_radius: images.spacing_per_radius,
                range_radii: self.params.threshold,
            };
            let bindings = [
                ("camera", camera.clone()),
                ("flow", recorder.uniform(&uniform)),
                ("front", images.front.bind()),
                ("source", current.clone()),
                ("smoothed", if is_last { images.target.bind() } else { next.clone() }),
                ("covered", images.covered.list(recorder, gpu)),
            ];
            let pass = if is_last { &self.last } else { &self.step };
            let pixels = images.over_covered();
            recorder.compute(gpu, "ssfr.curvature_flow", pass, &bindings, pixels);
            std::mem::swap(&mut next, &mut current);
        }
    }

    fn filter_on_cpu(&self, camera: &CameraUniform, surface: &HostSurface<'_>) -> Vec<f32> {
        twin::curvature_flow(&twin::HostView::new(camera), &self.params, surface)
    }

    fn properties(&self) -> Properties {
        Properties {
            // Second differences of a plane are 0 on any side.
            exact_up_to_silhouettes: true,
            nominal_sigma: Some(self.params.sigma),
            range_radii: Some(self.params.threshold),
            even_in_close_ups: true,
            ..Properties::exact_on_tilted_planes()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::passes::INCLUDES;

    #[test]
    fn the_uniform_has_the_layout_of_its_shader() {
        CurvatureFlowUniform::check_layout(&shader!("ssfr/curvature_flow"), INCLUDES).unwrap();
    }
}
