use bytemuck::{Pod, Zeroable};
use meniscus_gpu::{HostField, HostStruct, Shader, host_fields, shader};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::twin::{TwinInput, blinn_phong};
use crate::{
    Formula, LambertParameters, Liquid, MediumParameters, MediumUniform, PixelModel, Promises, Surroundings,
    WaterScale,
};

const SHADER: Shader = shader!("shading/blinn_phong");

/// Parameters of [`BlinnPhong`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BlinnPhongParameters {
    /// How soon the scene behind is veiled.
    #[serde(flatten)]
    pub medium: MediumParameters,
    /// Colour of the veil, linear red, green, blue, 0 to 1.
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub color: [f32; 3],
    /// Brightness of the highlight, 0 to 10.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub specular: f32,
    /// Exponent of the highlight, 1 to 2000.
    #[schemars(range(min = 1.0, max = 2000.0))]
    pub shininess: f32,
}

impl Default for BlinnPhongParameters {
    fn default() -> Self {
        Self::of_liquid(Liquid::default())
    }
}

/// The parameters as the GPU sees them; WGSL: `BlinnPhong` in `shaders/shading/blinn_phong.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct BlinnPhongUniform {
    pub medium: MediumUniform,
    pub color: [f32; 3],
    pub spacing_world: f32,
    pub specular: f32,
    pub shininess: f32,
    pub pad_a: f32,
    pub pad_b: f32,
}

impl HostStruct for BlinnPhongUniform {
    const WGSL_NAME: &'static str = "BlinnPhong";
    const FIELDS: &'static [HostField] =
        host_fields!(BlinnPhongUniform { medium, color, spacing_world, specular, shininess, pad_a, pad_b });
}

/// [`Lambert`](crate::Lambert) with the highlight of Blinn 1977: for weak hardware.
pub type BlinnPhong = PixelModel<BlinnPhongParameters>;

impl Formula for BlinnPhongParameters {
    const NAME: &'static str = "blinn-phong";
    const SHADER: Shader = SHADER;
    const KEEPS_SCENE: bool = true;
    const PASS: &'static str = "shading.blinn_phong";
    type Uniform = BlinnPhongUniform;

    fn promises(&self) -> Promises {
        LambertParameters::default().promises()
    }

    fn of_liquid(liquid: Liquid) -> Self {
        let LambertParameters { medium, color } = LambertParameters::of_liquid(liquid);
        Self { medium, color, specular: 0.6, shininess: 120.0 }
    }

    fn uniform(&self, scale: WaterScale, _: &Surroundings) -> BlinnPhongUniform {
        BlinnPhongUniform {
            medium: self.medium.uniform(scale),
            color: self.color,
            spacing_world: scale.usable_spacing(),
            specular: self.specular,
            shininess: self.shininess,
            pad_a: 0.0,
            pad_b: 0.0,
        }
    }

    fn extinction(&self, scale: WaterScale) -> [f32; 3] {
        self.medium.uniform(scale).extinction()
    }

    fn shade_pixel(uniform: &BlinnPhongUniform, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4] {
        blinn_phong::shade_pixel(uniform, input, pixel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uniform_matches_its_shader() {
        BlinnPhongUniform::check_layout(&SHADER, crate::INCLUDES).unwrap();
    }
}
