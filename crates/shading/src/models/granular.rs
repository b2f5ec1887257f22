use bytemuck::{Pod, Zeroable};
use meniscus_gpu::{HostField, HostStruct, Shader, host_fields, shader};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::twin::{TwinInput, granular};
use crate::{Formula, PixelModel, Promises, Surroundings, WaterScale};

const SHADER: Shader = shader!("shading/granular");

/// Parameters of [`Granular`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GranularParameters {
    /// Colour of dry grains, linear red, green, blue, 0 to 1.
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub color: [f32; 3],
    /// Roughness, 0 (Lambert's law) to 1: as bright at its rim as in its middle, like dry sand.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub roughness: f32,
    /// How dark gaps and hollows are, 0 to 1. Use `--filter none` or a weak filter to see grains.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub gaps: f32,
    /// Film of water on the grains, 0 (dry) to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub wetness: f32,
}

impl Default for GranularParameters {
    fn default() -> Self {
        Self { color: [0.36, 0.28, 0.20], roughness: 0.8, gaps: 0.7, wetness: 0.0 }
    }
}

/// The parameters as the GPU sees them; WGSL: `Granular` in `shaders/shading/granular.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct GranularUniform {
    pub color: [f32; 3],
    pub roughness: f32,
    pub gaps: f32,
    pub wetness: f32,
    pub spacing_world: f32,
    pub shadow_extinction: f32,
}

impl HostStruct for GranularUniform {
    const WGSL_NAME: &'static str = "Granular";
    const FIELDS: &'static [HostField] =
        host_fields!(GranularUniform { color, roughness, gaps, wetness, spacing_world, shadow_extinction });
}

/// Sand, gravel, debris: for sliding masses.
pub type Granular = PixelModel<GranularParameters>;

impl Formula for GranularParameters {
    const NAME: &'static str = "granular";
    const SHADER: Shader = SHADER;
    const KEEPS_SCENE: bool = true;
    const PASS: &'static str = "shading.granular";
    type Uniform = GranularUniform;

    fn promises(&self) -> Promises {
        Promises {
            fades_with_thickness: true,
            makes_no_light: true,
            reflects_by_fresnel: false,
            absorbs_by_beer_lambert: false,
            shows_attributes: true,
        }
    }

    fn uniform(&self, scale: WaterScale, _: &Surroundings) -> GranularUniform {
        GranularUniform {
            color: self.color,
            roughness: self.roughness,
            gaps: self.gaps,
            wetness: self.wetness,
            spacing_world: scale.usable_spacing(),
            shadow_extinction: scale.opaque_extinction(),
        }
    }

    fn shade_pixel(uniform: &GranularUniform, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4] {
        granular::shade_pixel(uniform, input, pixel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uniform_matches_its_shader() {
        GranularUniform::check_layout(&SHADER, crate::INCLUDES).unwrap();
    }
}
