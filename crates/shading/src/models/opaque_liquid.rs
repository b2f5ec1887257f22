use bytemuck::{Pod, Zeroable};
use meniscus_gpu::{HostField, HostStruct, Shader, host_fields, shader};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::twin::{TwinInput, opaque_liquid};
use crate::{Formula, Liquid, PixelModel, Promises, Surroundings, WaterScale};

const SHADER: Shader = shader!("shading/opaque_liquid");

/// Parameters of [`OpaqueLiquid`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OpaqueLiquidParameters {
    /// Which liquid the parameters that are not given are those of; left out: milk.
    pub preset: Liquid,
    /// Colour of the body, linear red, green, blue, 0 to 1.
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub color: [f32; 3],
    /// How far light gets inside and around the body, 0 (paint) to 1 (wax).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub softness: f32,
    /// Index of refraction against air, 1 to 3: strength of the reflection.
    #[schemars(range(min = 1.0, max = 3.0))]
    pub refractive_index: f32,
    /// Perceptual roughness of the calm surface, 0.01 to 1: width of the sun's reflection.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub roughness: f32,
}

impl Default for OpaqueLiquidParameters {
    fn default() -> Self {
        Self::of_liquid(Liquid::Milk)
    }
}

/// The parameters as the GPU sees them; WGSL: `OpaqueLiquid` in `shaders/shading/opaque_liquid.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct OpaqueLiquidUniform {
    pub color: [f32; 3],
    pub softness: f32,
    pub refractive_index: f32,
    pub alpha: f32,
    pub spacing_world: f32,
    pub shadow_extinction: f32,
}

impl HostStruct for OpaqueLiquidUniform {
    const WGSL_NAME: &'static str = "OpaqueLiquid";
    const FIELDS: &'static [HostField] = host_fields!(OpaqueLiquidUniform {
        color,
        softness,
        refractive_index,
        alpha,
        spacing_world,
        shadow_extinction,
    });
}

/// Liquids that nothing is seen through, like milk or paint.
pub type OpaqueLiquid = PixelModel<OpaqueLiquidParameters>;

impl Formula for OpaqueLiquidParameters {
    const NAME: &'static str = "opaque";
    const SHADER: Shader = SHADER;
    const KEEPS_SCENE: bool = true;
    const PASS: &'static str = "shading.opaque_liquid";
    type Uniform = OpaqueLiquidUniform;

    fn promises(&self) -> Promises {
        Promises {
            fades_with_thickness: true,
            makes_no_light: true,
            reflects_by_fresnel: false,
            absorbs_by_beer_lambert: false,
            shows_attributes: true,
        }
    }

    fn of_liquid(liquid: Liquid) -> Self {
        let look = liquid.look();
        Self {
            preset: liquid,
            color: look.color,
            softness: 0.35,
            refractive_index: look.refractive_index,
            roughness: look.roughness,
        }
    }

    fn body_albedo(&self) -> f32 {
        self.color.into_iter().fold(0.0, f32::max)
    }

    fn uniform(&self, scale: WaterScale, _: &Surroundings) -> OpaqueLiquidUniform {
        OpaqueLiquidUniform {
            color: self.color,
            softness: self.softness,
            refractive_index: self.refractive_index,
            alpha: self.roughness * self.roughness,
            spacing_world: scale.usable_spacing(),
            shadow_extinction: scale.opaque_extinction(),
        }
    }

    fn shade_pixel(uniform: &OpaqueLiquidUniform, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4] {
        opaque_liquid::shade_pixel(uniform, input, pixel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uniform_matches_its_shader() {
        OpaqueLiquidUniform::check_layout(&SHADER, crate::INCLUDES).unwrap();
    }
}
