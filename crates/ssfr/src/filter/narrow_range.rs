use bytemuck::{Pod, Zeroable};
use meniscus_gpu::{
    Binding, CameraUniform, ComputePipeline, Definition, Dispatch, Gpu, HostField, HostStruct, Recorder,
    shader,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{FilterImages, HostSurface, SurfaceFilter};
use crate::filter::TAPS;
use crate::params::check_range;
use crate::passes::{counted_pipeline, over_covered, pipeline, pipeline_with};
use crate::{SsfrError, twin};

/// Which form of the narrow-range filter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum NarrowRangeVariant {
    /// Measures deviations from the plane through the pixel; exact on tilted planes (`algorithms.md` 3.7).
    #[default]
    SlopeCompensated,
    /// As published: measures differences of distance, with a range that widens outwards (`algorithms.md` 3.1 to 3.3).
    Paper,
}

/// Parameters of the narrow-range filter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct NarrowRangeParams {
    /// Form of the filter.
    pub variant: NarrowRangeVariant,
    /// Standard deviation in projected particle spacings, all passes together, 0 to 10. Below 0.5 the bumps of the
    /// particles survive, above 2 detail is lost.
    pub sigma: f32,
    /// Passes over rows and columns, 1 to 16; their variances add up to that of `sigma`.
    pub iterations: u32,
    /// Depth range in drawn radii, 0.1 to 1000: what is further in front or behind is another surface. The
    /// slope-compensated form fades over the outer half of the range.
    pub threshold: f32,
    /// How far behind, in drawn radii, what lies beyond the range is taken to be, 0 to 10: rounds silhouettes.
    pub clamp: f32,
}

impl Default for NarrowRangeParams {
    fn default() -> Self {
        Self { variant: Default::default(), sigma: 1.0, iterations: 2, threshold: 8.0, clamp: 1.0 }
    }
}

impl NarrowRangeParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`SsfrError::Parameter`] for the first number out of range.
    pub fn validate(&self) -> Result<(), SsfrError> {
        check_range("sigma", self.sigma, 0.0..=10.0, "0 to 10")?;
        check_range("iterations", self.iterations as f32, 1.0..=16.0, "1 to 16")?;
        check_range("threshold", self.threshold, 0.1..=1000.0, "0.1 to 1000")?;
        check_range("clamp", self.clamp, 0.0..=10.0, "0 to 10")
    }
}

/// `meniscus::narrow_range::NarrowRange` of `shaders/ssfr/narrow_range.inc.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct NarrowRangeUniform {
    direction: [u32; 2],
    sigma_spacings: f32,
    spacing_per_radius: f32,
    iterations: f32,
    range_radii: f32,
    clamp_radii: f32,
    pad: f32,
}

impl HostStruct for NarrowRangeUniform {
    const WGSL_NAME: &'static str = "NarrowRange";
    const FIELDS: &'static [HostField] = meniscus_gpu::host_fields!(NarrowRangeUniform {
        direction,
        sigma_spacings,
        spacing_per_radius,
        iterations,
        range_radii,
        clamp_radii,
        pad,
    });
}

/// Narrow-range filter (Truong and Yuksel 2018): smooths a surface without mixing it with others in front or behind.
pub struct NarrowRange {
    params: NarrowRangeParams,
    key: ComputePipeline,
    along: ComputePipeline,
    clean: ComputePipeline,
    paper_key: ComputePipeline,
    paper_along: ComputePipeline,
    paper_clean: ComputePipeline,
}

impl NarrowRange {
    /// Name in the registry.
    pub const NAME: &'static str = "narrow-range";

    /// Compiles the passes.
    ///
    /// # Errors
    /// A parameter out of range, or a shader that the driver does not take.
    pub fn new(gpu: &Gpu, params: NarrowRangeParams) -> Result<Self, SsfrError> {
        params.validate()?;
        let paper = Definition { name: "PAPER", value: 1 };
        let square = Definition { name: "SQUARE", value: 1 };
        Ok(Self {
            params,
            key: pipeline(gpu, shader!("ssfr/narrow_range_key"))?,
            along: counted_pipeline(gpu, shader!("ssfr/narrow_range"), &[], TAPS)?,
            clean: counted_pipeline(gpu, shader!("ssfr/narrow_range_clean"), &[], TAPS)?,
            paper_key: pipeline_with(gpu, shader!("ssfr/narrow_range_key"), &[paper])?,
            paper_along: counted_pipeline(gpu, shader!("ssfr/narrow_range_paper"), &[], TAPS)?,
            paper_clean: counted_pipeline(gpu, shader!("ssfr/narrow_range_paper"), &[square], TAPS)?,
        })
    }

    fn uniform(&self, spacing_per_radius: f32, direction: [u32; 2]) -> NarrowRangeUniform {
        NarrowRangeUniform {
            direction,
            sigma_spacings: self.params.sigma,
            spacing_per_radius,
            iterations: self.params.iterations as f32,
            range_radii: self.params.threshold,
            clamp_radii: self.params.clamp,
            pad: 0.0,
        }
    }
}

impl SurfaceFilter for NarrowRange {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn record(&self, recorder: &mut Recorder, gpu: &Gpu, camera: &Binding, images: &FilterImages<'_>) {
        let size = images.source.size();
        let pixels = over_covered(size);
        let is_paper = self.params.variant == NarrowRangeVariant::Paper;
        let (along, clean, out) = if is_paper {
            (&self.paper_along, &self.paper_clean, "smoothed")
        } else {
            (&self.along, &self.clean, "distance")
        };
        let unfiltered = images.source.bind();
        let [mut next, mut other] = images.scratch.map(|image| image.bind());
        let key = if is_paper { &self.paper_key } else { &self.key };
        let bindings = [
            ("camera", camera.clone()),
            ("distance", unfiltered.clone()),
            ("key", other.clone()),
            ("other", next.clone()),
        ];
        recorder.compute(gpu, "ssfr.narrow_range_key", key, &bindings, Dispatch::Pixels(size));
        let mut current = other.clone();
        let common = |recorder: &mut Recorder, direction, source| {
            let uniform = self.uniform(images.spacing_per_radius, direction);
            let mut bindings = vec![
                ("camera", camera.clone()),
                ("narrow", recorder.uniform(&uniform)),
                ("radius", images.radius.bind()),
                ("source", source),
                ("covered", images.covered.bind()),
            ];
            if !is_paper {
                bindings.push(("unfiltered", unfiltered.clone()));
            }
            bindings
        };
        for direction in directions(self.params.iterations) {
            let mut bindings = common(recorder, direction, current);
            bindings.push(("smoothed", next.clone()));
            recorder.compute(gpu, "ssfr.narrow_range", along, &bindings, pixels);
            current = next.clone();
            std::mem::swap(&mut next, &mut other);
        }
        let mut bindings = common(recorder, [0, 0], current);
        bindings.push((out, images.target.bind()));
        recorder.compute(gpu, "ssfr.narrow_range_clean", clean, &bindings, pixels);
    }

    fn filter_on_cpu(&self, camera: &CameraUniform, surface: &HostSurface<'_>) -> Vec<f32> {
        twin::narrow_range(&twin::HostView::new(camera), &self.params, surface)
    }

    fn nominal_sigma(&self) -> Option<f32> {
        Some(self.params.sigma)
    }
}

/// Rows and columns in turn, the order swapped from one iteration to the next (`algorithms.md` 3.5).
pub(crate) fn directions(iterations: u32) -> impl Iterator<Item = [u32; 2]> {
    (0..iterations).flat_map(|i| if i % 2 == 0 { [[1, 0], [0, 1]] } else { [[0, 1], [1, 0]] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::passes::INCLUDES;

    #[test]
    fn the_uniform_has_the_layout_of_its_shaders() {
        for shader in [
            shader!("ssfr/narrow_range"),
            shader!("ssfr/narrow_range_clean"),
            shader!("ssfr/narrow_range_paper"),
        ] {
            NarrowRangeUniform::check_layout(&shader, INCLUDES).unwrap();
        }
    }

    #[test]
    fn numbers_out_of_range_are_named() {
        assert!(NarrowRangeParams::default().validate().is_ok());
        let params = NarrowRangeParams { iterations: 0, ..Default::default() };
        assert!(params.validate().unwrap_err().to_string().contains("iterations is 0"));
    }
}
