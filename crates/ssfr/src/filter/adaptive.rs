use bytemuck::{Pod, Zeroable};
use meniscus_gpu::{Binding, CameraUniform, ComputePipeline, Gpu, HostField, HostStruct, Recorder, shader};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::smoothing::{CLOSE_TAPS, Rule, Smoothing, Width};
use super::{FilterImages, HostSurface, Properties, SurfaceFilter, TAPS};
use crate::params::check_range;
use crate::passes::{counted_pipeline, pipeline};
use crate::{SsfrError, twin};

/// Pixels per side of a tile; `TILE` of `shaders/ssfr/adaptive.inc.wgsl`.
pub(crate) const TILE: u32 = 16;

/// Parameters of the adaptive filter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AdaptiveParams {
    /// Standard deviation in projected particle spacings, all passes together, 0 to 10.
    pub sigma: f32,
    /// Passes over rows and columns, 1 to 16; their variances add up to that of `sigma`.
    pub iterations: u32,
    /// Depth range in drawn radii, 0.1 to 1000, of both filters.
    pub threshold: f32,
    /// How far behind, in drawn radii, what lies beyond the range is taken to be by the narrow-range filter, 0 to 10.
    pub clamp: f32,
    /// Share of a tile's pixels within a spacing of an edge from which on the narrow-range filter takes over, 0.001 to 1.
    pub edges: f32,
    /// Mean bend of the surface within a spacing, in drawn radii, from which on the narrow-range filter takes over, 0.001 to
    /// 16. Particles themselves bend it by some 0.3.
    pub bend: f32,
}

impl Default for AdaptiveParams {
    fn default() -> Self {
        Self { sigma: 1.0, iterations: 2, threshold: 8.0, clamp: 1.0, edges: 0.05, bend: 1.0 }
    }
}

impl AdaptiveParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`SsfrError::Parameter`] for the first number out of range.
    pub fn validate(&self) -> Result<(), SsfrError> {
        self.width().validate()?;
        check_range("edges", self.edges, 0.001..=1.0, "0.001 to 1")?;
        check_range("bend", self.bend, 0.001..=16.0, "0.001 to 16")
    }

    pub(crate) fn width(&self) -> Width {
        Width {
            sigma: self.sigma,
            iterations: self.iterations,
            range: self.threshold,
            clamp: self.clamp,
            close_taps: CLOSE_TAPS,
        }
    }
}

/// `meniscus::adaptive::Adaptive` of `shaders/ssfr/adaptive.inc.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct AdaptiveUniform {
    spacing_per_radius: f32,
    range_radii: f32,
    edges: f32,
    bend: f32,
}

impl HostStruct for AdaptiveUniform {
    const WGSL_NAME: &'static str = "Adaptive";
    const FIELDS: &'static [HostField] =
        meniscus_gpu::host_fields!(AdaptiveUniform { spacing_per_radius, range_radii, edges, bend });
}

/// Bilateral where the surface is simple, narrow-range where it is complex, tile by tile (`main-renderer.md` 5.4): by the
/// share of pixels beside edges and by how much the surface bends. Blended between tiles.
///
/// It gains nothing over the narrow-range filter: on the views of `benches/ssfr-filter` it takes a quarter to a third more CPU
/// time on a software driver (the bilateral rule is no cheaper than the narrow-range one, and tiles have to be measured), and
/// its pictures look the same. It is here because the method that this program follows has it.
pub struct Adaptive {
    params: AdaptiveParams,
    measure: ComputePipeline,
    blend: ComputePipeline,
    smoothing: Smoothing,
}

impl Adaptive {
    /// Name in the registry.
    pub const NAME: &'static str = "adaptive";

    /// Compiles the passes.
    ///
    /// # Errors
    /// A parameter out of range, or a shader that the driver does not take.
    pub fn new(gpu: &Gpu, params: AdaptiveParams) -> Result<Self, SsfrError> {
        params.validate()?;
        Ok(Self {
            params,
            measure: counted_pipeline(gpu, shader!("ssfr/adaptive_measure"), &[], TAPS),
            blend: pipeline(gpu, shader!("ssfr/adaptive_blend")),
            smoothing: Smoothing::new(gpu, Rule::Adaptive)?,
        })
    }
}

impl SurfaceFilter for Adaptive {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn record(&self, recorder: &mut Recorder, gpu: &Gpu, camera: &Binding, images: &FilterImages<'_>) {
        let size = images.front.size();
        let tiles: usize = size.iter().map(|side| side.div_ceil(TILE) as usize).product();
        let [sums, complexity] = images.scratch;
        recorder.clear(gpu, "ssfr.adaptive_clear", sums, 2 * tiles);
        let uniform = recorder.uniform(&AdaptiveUniform {
            spacing_per_radius: images.spacing_per_radius,
            range_radii: self.params.threshold,
            edges: self.params.edges,
            bend: self.params.bend,
        });
        let common = [
            ("camera", camera.clone()),
            ("adaptive", uniform),
            ("covered", images.covered.list(recorder, gpu)),
            ("sums", sums.bind()),
        ];
        let pixels = images.over_covered();
        let measured = [&common[..], &[("front", images.front.bind())]].concat();
        recorder.compute(gpu, "ssfr.adaptive_measure", &self.measure, &measured, pixels);
        let blended = [&common[..], &[("complexity", complexity.bind())]].concat();
        recorder.compute(gpu, "ssfr.adaptive_blend", &self.blend, &blended, pixels);
        self.smoothing.record(recorder, gpu, camera, images, &self.params.width());
    }

    fn filter_on_cpu(&self, camera: &CameraUniform, surface: &HostSurface<'_>) -> Vec<f32> {
        twin::adaptive(&twin::HostView::new(camera), &self.params, surface)
    }

    fn properties(&self) -> Properties {
        Properties {
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
    fn the_uniform_has_the_layout_of_its_shaders() {
        for shader in [shader!("ssfr/adaptive_measure"), shader!("ssfr/adaptive_blend")] {
            AdaptiveUniform::check_layout(&shader, INCLUDES).unwrap();
        }
    }
}
