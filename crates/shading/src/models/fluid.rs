use bytemuck::{Pod, Zeroable};
use meniscus_gpu::{HostField, HostStruct, Shader, host_fields, shader};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::twin::{TwinInput, fluid};
use crate::{
    Formula, Liquid, MediumParameters, MediumUniform, PixelModel, Promises, Surroundings, WaterScale,
};

const SHADER: Shader = shader!("shading/fluid");

/// Parameters of [`Fluid`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FluidParameters {
    /// What fills the water.
    #[serde(flatten)]
    pub medium: MediumParameters,
    /// Index of refraction against air, 1 to 3.
    #[schemars(range(min = 1.0, max = 3.0))]
    pub refractive_index: f32,
    /// How much of the bending is applied: 0 = light passes straight, 1 = physical, at most 2.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub refraction_scale: f32,
    /// Share of the transmitted light that is replaced by reflection, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub additional_reflection: f32,
    /// Perceptual roughness of the calm surface, 0.01 to 1: width of the sun's reflection.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub roughness: f32,
    /// Optical depth of the shadow that the water throws, over the same depth and on top of its absorption, 0 to 1000: the
    /// light that the surface bends elsewhere.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub shadow: f32,
    /// Whiteness of single drops, 0 to 1; from near by, when their spacing is 8 pixels and more, 0.4 of it.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub spray: f32,
}

impl Default for FluidParameters {
    fn default() -> Self {
        Self::of_liquid(Liquid::default())
    }
}

/// The parameters as the GPU sees them; WGSL: `Fluid` in `shaders/shading/fluid.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct FluidUniform {
    pub medium: MediumUniform,
    pub refractive_index: f32,
    pub refraction_scale: f32,
    pub additional_reflection: f32,
    pub alpha: f32,
    pub spray: f32,
    pub spacing_world: f32,
    pub shadow_extinction: f32,
    pub pad: f32,
}

impl HostStruct for FluidUniform {
    const WGSL_NAME: &'static str = "Fluid";
    const FIELDS: &'static [HostField] = host_fields!(FluidUniform {
        medium,
        refractive_index,
        refraction_scale,
        additional_reflection,
        alpha,
        spray,
        spacing_world,
        shadow_extinction,
        pad,
    });
}

/// Clear liquid: the default lighting model (`algorithms.md` 10, recommended composite).
pub type Fluid = PixelModel<FluidParameters>;

impl Formula for FluidParameters {
    const NAME: &'static str = "fluid";
    const SHADER: Shader = SHADER;
    const KEEPS_SCENE: bool = true;
    const PASS: &'static str = "shading.fluid";
    type Uniform = FluidUniform;

    fn promises(&self) -> Promises {
        Promises {
            fades_with_thickness: true,
            makes_no_light: true,
            reflects_by_fresnel: true,
            absorbs_by_beer_lambert: true,
            shows_attributes: true,
        }
    }

    fn of_liquid(liquid: Liquid) -> Self {
        let look = liquid.look();
        Self {
            medium: MediumParameters::of(liquid),
            refractive_index: look.refractive_index,
            refraction_scale: 1.0,
            additional_reflection: 0.0,
            roughness: look.roughness,
            shadow: 0.3,
            spray: look.spray,
        }
    }

    fn body_albedo(&self) -> f32 {
        self.medium.albedo()
    }

    fn uniform(&self, scale: WaterScale, _: &Surroundings) -> FluidUniform {
        FluidUniform {
            medium: self.medium.uniform(scale),
            refractive_index: self.refractive_index,
            refraction_scale: self.refraction_scale,
            additional_reflection: self.additional_reflection,
            alpha: self.roughness * self.roughness,
            spray: self.spray,
            spacing_world: scale.usable_spacing(),
            shadow_extinction: self.shadow * self.medium.per_world(scale),
            pad: 0.0,
        }
    }

    fn extinction(&self, scale: WaterScale) -> [f32; 3] {
        self.medium.uniform(scale).extinction()
    }

    fn shade_pixel(uniform: &FluidUniform, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4] {
        fluid::shade_pixel(uniform, input, pixel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uniform_matches_its_shader() {
        FluidUniform::check_layout(&SHADER, crate::INCLUDES).unwrap();
    }
}
