use bytemuck::{Pod, Zeroable};
use meniscus_gpu::{Definition, HostField, HostStruct, Shader, host_fields, shader};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::twin::{TwinInput, vtk};
use crate::{Formula, PixelModel, Promises, Surroundings, WaterScale};

const SHADER: Shader = shader!("shading/vtk");

/// Where the surface is opaque.
const OPAQUE: Definition = Definition { name: "OPAQUE", value: 1 };

/// What VTK's mapper shows of the water.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DisplayMode {
    /// A translucent volume.
    #[default]
    #[serde(alias = "TransparentFluidVolume")]
    Translucent,
    /// An opaque surface.
    #[serde(alias = "FilteredOpaqueSurface")]
    Opaque,
}

/// Parameters of [`Vtk`]: those of VTK's mapper under our names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct VtkParameters {
    /// Translucent volume or opaque surface.
    pub display_mode: DisplayMode,
    /// Index of refraction against air, 1 to 3.
    #[schemars(range(min = 1.0, max = 3.0))]
    pub refractive_index: f32,
    /// Shift of the background, in pictures per unit of the refracted direction, 0 to 1. VTK's own default of 1 shows the
    /// opposite side of the picture; its example sets 0.07.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub refraction_scale: f32,
    /// Share of the transmitted light that is replaced by reflection, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub additional_reflection: f32,
    /// Optical depth per channel (red, green, blue) over the representative depth, 0 to 1000.
    #[schemars(inner(range(min = 0.0, max = 1000.0)))]
    pub attenuation_color: [f32; 3],
    /// Factor on the attenuation, 0 to 1000.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub attenuation_scale: f32,
    /// Depth over which the attenuation acts, world units; left out: the representative depth of the data. VTK's numbers are
    /// per world unit: 1.
    #[schemars(range(min = 1e-30, max = 1e30))]
    pub attenuation_depth: Option<f32>,
    /// Colour of the opaque surface, linear red, green, blue, 0 to 1.
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub color: [f32; 3],
    /// Exponent on the colour that an attribute gives, 0 to 10.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub particle_color_power: f32,
    /// Factor on that, 0 to 1: what is left attenuates.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub particle_color_scale: f32,
}

impl Default for VtkParameters {
    fn default() -> Self {
        Self {
            display_mode: DisplayMode::default(),
            refractive_index: 1.33,
            refraction_scale: 0.07,
            additional_reflection: 0.0,
            attenuation_color: [0.5, 0.2, 0.05],
            attenuation_scale: 1.0,
            attenuation_depth: None,
            color: [0.0, 0.0, 0.95],
            particle_color_power: 0.1,
            particle_color_scale: 1.0,
        }
    }
}

/// The parameters as the GPU sees them; WGSL: `Vtk` in `shaders/shading/vtk.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct VtkUniform {
    pub attenuation: [f32; 3],
    pub refractive_index: f32,
    pub color: [f32; 3],
    pub refraction_scale: f32,
    pub additional_reflection: f32,
    pub particle_color_power: f32,
    pub particle_color_scale: f32,
    pub dye_per_world: f32,
    pub is_opaque: u32,
    pub pad_a: u32,
    pub pad_b: u32,
    pub pad_c: u32,
}

impl HostStruct for VtkUniform {
    const WGSL_NAME: &'static str = "Vtk";
    const FIELDS: &'static [HostField] = host_fields!(VtkUniform {
        attenuation,
        refractive_index,
        color,
        refraction_scale,
        additional_reflection,
        particle_color_power,
        particle_color_scale,
        dye_per_world,
        is_opaque,
        pad_a,
        pad_b,
        pad_c,
    });
}

/// The composite of VTK's `vtkOpenGLFluidMapper`, for pictures side by side.
pub type Vtk = PixelModel<VtkParameters>;

impl Formula for VtkParameters {
    const NAME: &'static str = "vtk";
    const SHADER: Shader = SHADER;
    const KEEPS_SCENE: bool = true;
    const PASS: &'static str = "shading.vtk";
    type Uniform = VtkUniform;

    fn promises(&self) -> Promises {
        // Schlick's approximation, hard edges, and colours of attributes that are pale unless the surface is opaque: as there.
        let is_opaque = self.display_mode == DisplayMode::Opaque;
        Promises {
            makes_no_light: true,
            absorbs_by_beer_lambert: !is_opaque,
            shows_attributes: is_opaque,
            ..Default::default()
        }
    }

    fn kind(&self) -> Option<Definition> {
        (self.display_mode == DisplayMode::Opaque).then_some(OPAQUE)
    }

    fn uniform(&self, scale: WaterScale, _: &Surroundings) -> VtkUniform {
        let per_world = self.attenuation_scale * scale.per_depth(self.attenuation_depth);
        VtkUniform {
            attenuation: self.attenuation_color.map(|tau| tau * per_world),
            refractive_index: self.refractive_index,
            color: self.color,
            refraction_scale: self.refraction_scale,
            additional_reflection: self.additional_reflection,
            particle_color_power: self.particle_color_power,
            particle_color_scale: self.particle_color_scale,
            dye_per_world: per_world,
            is_opaque: (self.display_mode == DisplayMode::Opaque).into(),
            pad_a: 0,
            pad_b: 0,
            pad_c: 0,
        }
    }

    fn extinction(&self, scale: WaterScale) -> [f32; 3] {
        match self.display_mode {
            DisplayMode::Opaque => [scale.opaque_extinction(); 3],
            _ => {
                let per_world = self.attenuation_scale * scale.per_depth(self.attenuation_depth);
                self.attenuation_color.map(|tau| tau * per_world)
            }
        }
    }

    fn shade_pixel(uniform: &VtkUniform, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4] {
        vtk::shade_pixel(uniform, input, pixel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uniform_matches_its_shader() {
        VtkUniform::check_layout(&SHADER, crate::INCLUDES).unwrap();
    }
}
