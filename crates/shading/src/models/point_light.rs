use std::f32::consts::FRAC_1_PI;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use meniscus_gpu::{HostField, HostStruct, Shader, host_fields, shader};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::twin::{TwinInput, point_light};
use crate::{
    Formula, Liquid, MediumParameters, MediumUniform, PixelModel, Promises, Surroundings, WaterScale,
};

const SHADER: Shader = shader!("shading/point_light");

/// Parameters of [`PointLight`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PointLightParameters {
    /// What fills the water.
    #[serde(flatten)]
    pub medium: MediumParameters,
    /// Index of refraction against air, 1 to 3.
    #[schemars(range(min = 1.0, max = 3.0))]
    pub refractive_index: f32,
    /// How much of the bending is applied: 0 = light passes straight, 1 = physical, at most 2.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub refraction_scale: f32,
    /// Distance of the light from the middle of the data, towards the sun, in sizes of the data, 0.5 to 100.
    #[schemars(range(min = 0.5, max = 100.0))]
    pub light_distance: f32,
    /// Brightness of the light as a factor on the sun's, 0 to 100.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub light_intensity: f32,
    /// Exponent of the highlight, 1 to 2000.
    #[schemars(range(min = 1.0, max = 2000.0))]
    pub shininess: f32,
    /// Optical depth of the shadow that the water throws, over the same depth and on top of its absorption, 0 to 1000.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub shadow: f32,
}

impl Default for PointLightParameters {
    fn default() -> Self {
        Self::of_liquid(Liquid::default())
    }
}

/// The parameters as the GPU sees them; WGSL: `PointLight` in `shaders/shading/point_light.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PointLightUniform {
    pub medium: MediumUniform,
    pub light_position_world: [f32; 3],
    pub light_distance_world: f32,
    pub intensity: [f32; 3],
    pub shininess: f32,
    pub refractive_index: f32,
    pub refraction_scale: f32,
    pub spacing_world: f32,
    pub shadow_extinction: f32,
}

impl HostStruct for PointLightUniform {
    const WGSL_NAME: &'static str = "PointLight";
    const FIELDS: &'static [HostField] = host_fields!(PointLightUniform {
        medium,
        light_position_world,
        light_distance_world,
        intensity,
        shininess,
        refractive_index,
        refraction_scale,
        spacing_world,
        shadow_extinction,
    });
}

/// A light near the water, whose Fresnel reflectance decides over everything: Wang et al. 2012, 3.1.
pub type PointLight = PixelModel<PointLightParameters>;

impl Formula for PointLightParameters {
    const NAME: &'static str = "point-light";
    const SHADER: Shader = SHADER;
    const KEEPS_SCENE: bool = true;
    const PASS: &'static str = "shading.point_light";
    type Uniform = PointLightUniform;

    fn promises(&self) -> Promises {
        // The reflectance is that of the light's direction, not of the eye's.
        Promises {
            fades_with_thickness: true,
            makes_no_light: true,
            reflects_by_fresnel: false,
            absorbs_by_beer_lambert: true,
            shows_attributes: true,
        }
    }

    fn of_liquid(liquid: Liquid) -> Self {
        Self {
            medium: MediumParameters::of(liquid),
            refractive_index: liquid.look().refractive_index,
            refraction_scale: 1.0,
            light_distance: 2.0,
            light_intensity: 1.0,
            shininess: 300.0,
            shadow: 0.3,
        }
    }

    fn uniform(&self, scale: WaterScale, surroundings: &Surroundings) -> PointLightUniform {
        let sky = &surroundings.sky;
        let distance = self.light_distance * surroundings.size_world();
        let position = Vec3::from(surroundings.anchor) + distance * Vec3::from(sky.sun_direction);
        PointLightUniform {
            medium: self.medium.uniform(scale),
            light_position_world: position.to_array(),
            light_distance_world: distance,
            intensity: sky.sun_irradiance.map(|e| e * self.light_intensity * FRAC_1_PI),
            shininess: self.shininess,
            refractive_index: self.refractive_index,
            refraction_scale: self.refraction_scale,
            spacing_world: scale.usable_spacing(),
            shadow_extinction: self.shadow * self.medium.per_world(scale),
        }
    }

    fn extinction(&self, scale: WaterScale) -> [f32; 3] {
        self.medium.uniform(scale).extinction()
    }

    fn shade_pixel(uniform: &PointLightUniform, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4] {
        point_light::shade_pixel(uniform, input, pixel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uniform_matches_its_shader() {
        PointLightUniform::check_layout(&SHADER, crate::INCLUDES).unwrap();
    }
}
