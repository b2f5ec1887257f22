use bytemuck::{Pod, Zeroable};
use meniscus_gpu::role::Radiance;
use meniscus_gpu::{
    ComputePipeline, ComputePipelineDescriptor, Dispatch, Gpu, HostField, HostStruct, Image, Recorder,
    Shader, host_fields, shader,
};
use meniscus_scene::{CLEAR_WATER_OPTICAL_DEPTH, PURE_WATER_PER_METRE};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::twin::{TwinInput, fluid};
use crate::{INCLUDES, LightingInputs, LightingModel, LightingPass, Parameters, ShadingError, WaterScale};

const SHADER: Shader = shader!("shading/fluid");

/// Parameters of [`Fluid`]. The aliases are the names of VTK's mapper.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FluidParameters {
    /// Index of refraction against air, 1 to 3.
    #[serde(alias = "RefractiveIndex")]
    #[schemars(range(min = 1.0, max = 3.0))]
    pub refractive_index: f32,
    /// How much of the bending is applied: 0 = light passes straight, 1 = physical, at most 2.
    #[serde(alias = "RefractionScale")]
    #[schemars(range(min = 0.0, max = 2.0))]
    pub refraction_scale: f32,
    /// Share of the transmitted light that is replaced by reflection, 0 to 1.
    #[serde(alias = "AdditionalReflection")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub additional_reflection: f32,
    /// Optical depth per channel (red, green, blue) of the water's representative depth, 0 to 1000.
    #[serde(alias = "AttenuationColor")]
    pub attenuation_color: [f32; 3],
    /// Factor on the attenuation, 0 to 1000.
    #[serde(alias = "AttenuationScale")]
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub attenuation_scale: f32,
    /// Depth over which `attenuation_color` acts, world units; left out: the representative depth of the data.
    pub attenuation_depth: Option<f32>,
    /// Absorb as pure water does per metre (Pope & Fry 1997), times `attenuation_scale`, instead of `attenuation_color` over
    /// its depth. Needs `--unit` where the file is not in metres; less than some metres of it are nearly colourless.
    pub pure_water: bool,
    /// Optical depth of scattering over the same depth, 0 to 1000: 0 = clear, 1 = turbid.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub turbidity: f32,
    /// Perceptual roughness of the calm surface, 0.01 to 1: width of the sun's reflection.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub roughness: f32,
    /// Optical depth of the shadow that the water throws, over the same depth and on top of its absorption, 0 to 1000: the
    /// light that the surface bends elsewhere.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub shadow: f32,
    /// Whiteness of single drops, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub spray: f32,
}

impl Default for FluidParameters {
    fn default() -> Self {
        Self {
            refractive_index: 1.333,
            refraction_scale: 1.0,
            additional_reflection: 0.0,
            attenuation_color: CLEAR_WATER_OPTICAL_DEPTH,
            attenuation_scale: 1.0,
            attenuation_depth: None,
            pure_water: false,
            turbidity: 0.06,
            roughness: 0.15,
            shadow: 0.3,
            spray: 0.35,
        }
    }
}

impl FluidParameters {
    /// Checks every range.
    ///
    /// # Errors
    /// [`ShadingError::OutOfRange`] for the first value that does not fit (NaN never fits).
    pub fn validate(&self) -> Result<(), ShadingError> {
        let [red, green, blue] = self.attenuation_color;
        for (name, found, range, expected) in [
            ("refractive_index", self.refractive_index, 1.0..=3.0, "1 to 3"),
            ("refraction_scale", self.refraction_scale, 0.0..=2.0, "0 to 2"),
            ("additional_reflection", self.additional_reflection, 0.0..=1.0, "0 to 1"),
            ("attenuation_color (red)", red, 0.0..=1e3, "0 to 1000"),
            ("attenuation_color (green)", green, 0.0..=1e3, "0 to 1000"),
            ("attenuation_color (blue)", blue, 0.0..=1e3, "0 to 1000"),
            ("attenuation_scale", self.attenuation_scale, 0.0..=1e3, "0 to 1000"),
            ("attenuation_depth", self.attenuation_depth.unwrap_or(1.0), 1e-30..=1e30, "a positive length"),
            ("turbidity", self.turbidity, 0.0..=1e3, "0 to 1000"),
            ("roughness", self.roughness, 0.01..=1.0, "0.01 to 1"),
            ("shadow", self.shadow, 0.0..=1e3, "0 to 1000"),
            ("spray", self.spray, 0.0..=1.0, "0 to 1"),
        ] {
            if !range.contains(&found) {
                return Err(ShadingError::OutOfRange { model: Fluid::NAME, name, found, expected });
            }
        }
        Ok(())
    }
}

/// The parameters as the GPU sees them; WGSL: `Fluid` in `shaders/shading/fluid.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct FluidUniform {
    pub absorption: [f32; 3],
    pub scattering: f32,
    pub refractive_index: f32,
    pub refraction_scale: f32,
    pub additional_reflection: f32,
    pub alpha: f32,
    pub spray: f32,
    pub spacing_world: f32,
    pub shadow_extinction: f32,
    pub pad_a: f32,
}

impl FluidUniform {
    fn new(parameters: &FluidParameters, scale: WaterScale) -> Self {
        let depth = parameters.attenuation_depth.unwrap_or(scale.depth_world);
        let usable = depth.is_normal() && depth > 0.0;
        let per_world = if usable { depth.recip() } else { 0.0 };
        let metres = scale.metres_per_world;
        let known = metres.is_normal() && metres > 0.0;
        // At most 1e30: the products below stay finite.
        let metres = if known { metres.min(1e30) } else { 0.0 };
        let absorption = if parameters.pure_water {
            PURE_WATER_PER_METRE.map(|per_metre| per_metre * metres)
        } else {
            parameters.attenuation_color.map(|tau| tau * per_world)
        };
        Self {
            absorption: absorption.map(|sigma| sigma * parameters.attenuation_scale),
            scattering: parameters.turbidity * per_world,
            refractive_index: parameters.refractive_index,
            refraction_scale: parameters.refraction_scale,
            additional_reflection: parameters.additional_reflection,
            alpha: parameters.roughness * parameters.roughness,
            spray: parameters.spray,
            spacing_world: if scale.spacing_world.is_finite() { scale.spacing_world.max(0.0) } else { 0.0 },
            shadow_extinction: parameters.shadow * per_world,
            pad_a: 0.0,
        }
    }
}

impl HostStruct for FluidUniform {
    const WGSL_NAME: &'static str = "Fluid";
    const FIELDS: &'static [HostField] = host_fields!(FluidUniform {
        absorption,
        scattering,
        refractive_index,
        refraction_scale,
        additional_reflection,
        alpha,
        spray,
        spacing_world,
        shadow_extinction,
        pad_a,
    });
}

/// Clear liquid: the default lighting model (`algorithms.md` 10, recommended composite).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fluid {
    parameters: FluidParameters,
}

impl Fluid {
    /// Name in the registry.
    pub const NAME: &'static str = "fluid";

    /// The model with these parameters.
    ///
    /// # Errors
    /// [`ShadingError::OutOfRange`].
    pub fn new(parameters: FluidParameters) -> Result<Self, ShadingError> {
        parameters.validate()?;
        Ok(Self { parameters })
    }

    /// The model with parameters from JSON; what is left out has its default.
    ///
    /// # Errors
    /// Unknown names, wrong types, values out of range.
    pub fn from_parameters(parameters: &Parameters) -> Result<Self, ShadingError> {
        let parsed = serde_json::from_value(parameters.clone().into())
            .map_err(|e| ShadingError::Parameters { model: Self::NAME, message: e.to_string() })?;
        Self::new(parsed)
    }
}

impl LightingModel for Fluid {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn schema(&self) -> schemars::Schema {
        schemars::schema_for!(FluidParameters)
    }

    fn parameters(&self) -> Parameters {
        match serde_json::to_value(&self.parameters) {
            Ok(serde_json::Value::Object(map)) => map,
            _ => Parameters::new(),
        }
    }

    fn compile(&self, gpu: &Gpu) -> Result<Box<dyn LightingPass>, ShadingError> {
        let descriptor =
            ComputePipelineDescriptor { includes: INCLUDES, ..ComputePipelineDescriptor::new(SHADER) };
        Ok(Box::new(FluidPass { model: self.clone(), pipeline: gpu.compute_pipeline(&descriptor)? }))
    }

    fn twin(&self, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4] {
        fluid::shade_pixel(&FluidUniform::new(&self.parameters, input.scale), input, pixel)
    }
}

struct FluidPass {
    model: Fluid,
    pipeline: ComputePipeline,
}

impl LightingPass for FluidPass {
    fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), ShadingError> {
        self.model = Fluid::from_parameters(parameters)?;
        Ok(())
    }

    fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        inputs: &LightingInputs<'_>,
        output: &Image<Radiance>,
    ) {
        let uniform = FluidUniform::new(&self.model.parameters, inputs.scale);
        let bindings = [
            ("camera", recorder.uniform(inputs.camera)),
            ("surroundings", recorder.uniform(inputs.surroundings)),
            ("fluid", recorder.uniform(&uniform)),
            ("distances", inputs.distance.bind()),
            ("thicknesses", inputs.thickness.bind()),
            ("normals", inputs.normal.bind()),
            ("scene_color", inputs.scene_color.bind()),
            ("scene_distance", inputs.scene_distance.bind()),
            ("sun_paths", inputs.sun_path.bind()),
            ("radiance", output.bind()),
        ];
        let size = Dispatch::Pixels(inputs.camera.size_px);
        recorder.compute(gpu, "shading.fluid", &self.pipeline, &bindings, size);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uniform_matches_its_shader() {
        FluidUniform::check_layout(&SHADER, INCLUDES).unwrap();
    }

    #[test]
    fn vtk_names_are_understood_and_every_range_is_checked() {
        let json = serde_json::json!({"RefractiveIndex": 1.5, "AttenuationScale": 2.0});
        let model = Fluid::from_parameters(json.as_object().unwrap()).unwrap();
        assert_eq!(model.parameters.refractive_index, 1.5);
        assert_eq!(model.parameters.attenuation_scale, 2.0);
        let defaults = Fluid::default().parameters();
        for (name, value) in defaults.iter().filter(|(_, value)| !value.is_boolean()) {
            for bad in [-1.0, 1e31] {
                let mut parameters = defaults.clone();
                parameters[name] = if value.is_array() { serde_json::json!([bad, 0, 0]) } else { bad.into() };
                let error = Fluid::from_parameters(&parameters).unwrap_err().to_string();
                assert!(error.contains(name.as_str()), "{error}");
            }
        }
    }

    #[test]
    fn a_scale_without_meaning_gives_clear_water() {
        for absurd in [0.0, -3.0, f32::NAN, f32::INFINITY] {
            let scale = WaterScale { depth_world: absurd, spacing_world: f32::NAN, metres_per_world: absurd };
            let pure = FluidParameters { pure_water: true, ..Default::default() };
            assert_eq!(FluidUniform::new(&pure, scale).absorption, [0.0; 3]);
            let uniform = FluidUniform::new(&FluidParameters::default(), scale);
            assert_eq!((uniform.absorption, uniform.scattering, uniform.spacing_world), ([0.0; 3], 0.0, 0.0));
            assert_eq!(uniform.shadow_extinction, 0.0);
        }
    }
}
