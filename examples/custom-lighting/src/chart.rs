use bytemuck::{Pod, Zeroable};
use meniscus_gpu::{HostField, HostStruct, Shader, host_fields};
use meniscus_shading::twin::TwinInput;
use meniscus_shading::{Formula, PixelModel, Promises, Surroundings, WaterScale};

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

impl HostStruct for ChartUniform {
    const WGSL_NAME: &'static str = "Chart";
    const FIELDS: &'static [HostField] =
        host_fields!(ChartUniform { map, depth_world, step_world, line_px, relief });
}

/// The water as a chart: depth as colour, contour lines, relief.
pub type Chart = PixelModel<ChartParams>;

impl Formula for ChartParams {
    const NAME: &'static str = "chart";
    const SHADER: Shader = SHADER;
    const KEEPS_SCENE: bool = true;
    const PASS: &'static str = "custom.chart";
    type Uniform = ChartUniform;

    fn promises(&self) -> Promises {
        // A chart has sharp edges and its own colours.
        Promises::default()
    }

    /// A scale without meaning (zero, NaN) counts as a depth of 1.
    fn uniform(&self, scale: WaterScale, _: &Surroundings) -> ChartUniform {
        let depth = self.depth.unwrap_or(2.0 * scale.depth_world);
        let depth_world = if depth.is_normal() && depth > 0.0 { depth } else { 1.0 };
        let step_world = if self.contours > 0.0 { depth_world / self.contours } else { 0.0 };
        ChartUniform {
            map: linear_map(),
            depth_world,
            step_world,
            line_px: self.line_px,
            relief: self.relief,
        }
    }

    fn shade_pixel(uniform: &ChartUniform, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4] {
        twin::shade_pixel(uniform, input, pixel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_shading::INCLUDES;

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
}
