use bytemuck::{Pod, Zeroable};
use meniscus_gpu::role::Radiance;
use meniscus_gpu::{
    ComputePipeline, ComputePipelineDescriptor, Dispatch, Gpu, HostField, HostStruct, Image, Recorder,
    Shader, host_fields,
};
use meniscus_shading::twin::TwinInput;
use meniscus_shading::{
    INCLUDES, LightingInputs, LightingModel, LightingPass, Parameters, ShadingError, WaterScale,
};

use crate::map::{STOPS, linear_map};
use crate::{ChartParams, twin};

const SHADER: Shader = Shader { name: "custom.chart", source: include_str!("chart.wgsl") };

/// The parameters as the GPU sees them; WGSL: `Chart`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ChartUniform {
    /// Linear radiance from no water to the end of the map.
    pub map: [[f32; 4]; STOPS],
    /// Thickness at the end of the map, world units, > 0.
    pub depth_world: f32,
    /// Between contour lines, world units; 0 = no lines.
    pub step_world: f32,
    /// Width of contour lines, pixels.
    pub line_px: f32,
    /// Strength of the relief, 0 to 1.
    pub relief: f32,
}

impl ChartUniform {
    /// `params` for water of this scale; a scale without meaning (zero, NaN) counts as 1.
    pub fn new(params: &ChartParams, scale: WaterScale) -> Self {
        let depth = params.depth.unwrap_or(2.0 * scale.depth_world);
        let depth_world = if depth.is_normal() && depth > 0.0 { depth } else { 1.0 };
        let step_world = if params.contours > 0.0 { depth_world / params.contours } else { 0.0 };
        Self { map: linear_map(), depth_world, step_world, line_px: params.line_px, relief: params.relief }
    }
}

impl HostStruct for ChartUniform {
    const WGSL_NAME: &'static str = "Chart";
    const FIELDS: &'static [HostField] =
        host_fields!(ChartUniform { map, depth_world, step_world, line_px, relief });
}

/// The water as a chart: depth as colour, contour lines, relief.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chart {
    params: ChartParams,
}

impl Chart {
    /// Name in the registry.
    pub const NAME: &'static str = "chart";

    /// The model with these parameters.
    ///
    /// # Errors
    /// [`ShadingError::OutOfRange`].
    pub fn new(params: ChartParams) -> Result<Self, ShadingError> {
        params.validate()?;
        Ok(Self { params })
    }

    /// What the registry takes: the model with parameters from JSON; what is left out has its default.
    ///
    /// # Errors
    /// Unknown names, wrong types, values out of range.
    pub fn make(parameters: &Parameters) -> Result<Box<dyn LightingModel>, ShadingError> {
        Ok(Box::new(Self::from_json(parameters)?))
    }

    fn from_json(parameters: &Parameters) -> Result<Self, ShadingError> {
        let params = serde_json::from_value(parameters.clone().into())
            .map_err(|e| ShadingError::Parameters { model: Self::NAME, message: e.to_string() })?;
        Self::new(params)
    }
}

impl LightingModel for Chart {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn schema(&self) -> schemars::Schema {
        schemars::schema_for!(ChartParams)
    }

    fn parameters(&self) -> Parameters {
        match serde_json::to_value(&self.params) {
            Ok(serde_json::Value::Object(map)) => map,
            _ => Parameters::new(),
        }
    }

    fn compile(&self, gpu: &Gpu) -> Result<Box<dyn LightingPass>, ShadingError> {
        let descriptor =
            ComputePipelineDescriptor { includes: INCLUDES, ..ComputePipelineDescriptor::new(SHADER) };
        Ok(Box::new(ChartPass { model: self.clone(), pipeline: gpu.compute_pipeline(&descriptor)? }))
    }

    fn twin(&self, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4] {
        twin::shade_pixel(&ChartUniform::new(&self.params, input.scale), input, pixel)
    }
}

struct ChartPass {
    model: Chart,
    pipeline: ComputePipeline,
}

impl LightingPass for ChartPass {
    fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), ShadingError> {
        self.model = Chart::from_json(parameters)?;
        Ok(())
    }

    fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        inputs: &LightingInputs<'_>,
        output: &Image<Radiance>,
    ) {
        let uniform = ChartUniform::new(&self.model.params, inputs.scale);
        let bindings = [
            ("camera", recorder.uniform(inputs.camera)),
            ("surroundings", recorder.uniform(inputs.surroundings)),
            ("chart", recorder.uniform(&uniform)),
            ("distances", inputs.distance.bind()),
            ("thicknesses", inputs.thickness.bind()),
            ("normals", inputs.normal.bind()),
            ("scene_color", inputs.scene_color.bind()),
            ("scene_distance", inputs.scene_distance.bind()),
            ("radiance", output.bind()),
        ];
        let size = Dispatch::Pixels(inputs.camera.size_px);
        recorder.compute(gpu, SHADER.name, &self.pipeline, &bindings, size);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uniform_matches_its_shader() {
        ChartUniform::check_layout(&SHADER, INCLUDES).unwrap();
    }

    #[test]
    fn parameters_are_taken_from_json_and_checked() {
        let make = |json: serde_json::Value| Chart::make(json.as_object().unwrap());
        assert_eq!(make(serde_json::json!({"relief": 0.25})).unwrap().parameters()["relief"], 0.25);
        for (json, named) in [
            (serde_json::json!({"relief": 2}), "relief is 2"),
            (serde_json::json!({"depth": -1}), "depth is -1"),
            (serde_json::json!({"reliefs": 1}), "reliefs"),
        ] {
            let message = make(json).err().unwrap().to_string();
            assert!(message.contains(named), "{message}");
        }
    }

    #[test]
    fn a_scale_without_meaning_still_gives_a_chart() {
        for depth_world in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            let scale = WaterScale { depth_world, spacing_world: 1.0, metres_per_world: 1.0 };
            assert_eq!(ChartUniform::new(&ChartParams::default(), scale).depth_world, 1.0);
        }
    }
}
