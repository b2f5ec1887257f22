use bytemuck::{Pod, Zeroable};
use meniscus_gpu::{HostField, HostStruct, Shader, host_fields, shader};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::twin::{TwinInput, lambert};
use crate::{
    Formula, Liquid, MediumParameters, MediumUniform, PixelModel, Promises, Surroundings, WaterScale,
};

const SHADER: Shader = shader!("shading/lambert");

/// Parameters of [`Lambert`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LambertParameters {
    /// How soon the scene behind is veiled.
    #[serde(flatten)]
    pub medium: MediumParameters,
    /// Colour of the veil, linear red, green, blue, 0 to 1.
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub color: [f32; 3],
}

impl LambertParameters {
    /// Without refraction and mirror, water is only seen by its veil.
    pub(crate) const LEAST_TURBIDITY: f32 = 1.0;

    /// The medium of a liquid, dense enough to be seen.
    pub(crate) fn veil(liquid: Liquid) -> MediumParameters {
        let medium = MediumParameters::of(liquid);
        MediumParameters { turbidity: medium.turbidity.max(Self::LEAST_TURBIDITY), ..medium }
    }
}

impl Default for LambertParameters {
    fn default() -> Self {
        Self::of_liquid(Liquid::default())
    }
}

/// The parameters as the GPU sees them; WGSL: `Lambert` in `shaders/shading/lambert.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct LambertUniform {
    pub medium: MediumUniform,
    pub color: [f32; 3],
    pub spacing_world: f32,
}

impl HostStruct for LambertUniform {
    const WGSL_NAME: &'static str = "Lambert";
    const FIELDS: &'static [HostField] = host_fields!(LambertUniform { medium, color, spacing_world });
}

/// Lambert's law on a veil of water: for weak hardware.
pub type Lambert = PixelModel<LambertParameters>;

impl Formula for LambertParameters {
    const NAME: &'static str = "lambert";
    const SHADER: Shader = SHADER;
    const PASS: &'static str = "shading.lambert";
    type Uniform = LambertUniform;

    fn promises(&self) -> Promises {
        Promises {
            fades_with_thickness: true,
            makes_no_light: true,
            reflects_by_fresnel: false,
            absorbs_by_beer_lambert: true,
            shows_attributes: true,
        }
    }

    fn of_liquid(liquid: Liquid) -> Self {
        Self { medium: Self::veil(liquid), color: liquid.look().color }
    }

    fn uniform(&self, scale: WaterScale, _: &Surroundings) -> LambertUniform {
        LambertUniform {
            medium: self.medium.uniform(scale),
            color: self.color,
            spacing_world: scale.usable_spacing(),
        }
    }

    fn shade_pixel(uniform: &LambertUniform, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4] {
        lambert::shade_pixel(uniform, input, pixel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uniform_matches_its_shader() {
        LambertUniform::check_layout(&SHADER, crate::INCLUDES).unwrap();
    }
}
