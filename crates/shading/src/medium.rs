use bytemuck::{Pod, Zeroable};
use meniscus_gpu::{HostField, HostStruct, host_fields};
use meniscus_scene::PURE_WATER_PER_METRE;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Liquid, WaterScale};

/// What fills the water: parameters that several models share. Optical depths act over a representative depth of the data,
/// so that they need no unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MediumParameters {
    /// Which liquid the parameters that are not given are those of: clear (water), sea, river (with silt), milk, mud or oil.
    pub preset: Liquid,
    /// Optical depth of absorption per channel (red, green, blue) over the representative depth, 0 to 1000.
    #[schemars(inner(range(min = 0.0, max = 1000.0)))]
    pub attenuation_color: [f32; 3],
    /// Factor on the attenuation, 0 to 1000.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub attenuation_scale: f32,
    /// Depth over which optical depths act, world units; left out: the representative depth of the data.
    #[schemars(range(min = 1e-30, max = 1e30))]
    pub attenuation_depth: Option<f32>,
    /// Absorb as pure water does per metre (Pope & Fry 1997), times `attenuation_scale`, instead of `attenuation_color` over
    /// its depth. Needs `--unit` where the file is not in metres; less than some metres of it are nearly colourless.
    pub pure_water: bool,
    /// Optical depth of scattering over the same depth, 0 to 1000: 0 = clear, 1 = turbid, 50 = milk.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub turbidity: f32,
}

impl MediumParameters {
    /// The medium of a liquid.
    pub fn of(liquid: Liquid) -> Self {
        let look = liquid.look();
        Self {
            preset: liquid,
            attenuation_color: look.absorption,
            attenuation_scale: 1.0,
            attenuation_depth: None,
            pure_water: false,
            turbidity: look.turbidity,
        }
    }

    /// Share of light that is scattered over the representative depth, in the channel in which it is most.
    pub(crate) fn albedo(&self) -> f32 {
        let scattered = |absorption: f32| {
            let extinction = self.turbidity + self.attenuation_scale * absorption;
            self.turbidity / extinction.max(f32::MIN_POSITIVE) * (1.0 - (-extinction).exp())
        };
        self.attenuation_color.into_iter().map(scattered).fold(0.0, f32::max)
    }

    /// 1 / the depth over which optical depths act, 1 / world units; 0 for one without meaning.
    pub(crate) fn per_world(&self, scale: WaterScale) -> f32 {
        scale.per_depth(self.attenuation_depth)
    }

    pub(crate) fn uniform(&self, scale: WaterScale) -> MediumUniform {
        let per_world = self.per_world(scale);
        let metres = scale.metres_per_world;
        let known = metres.is_normal() && metres > 0.0;
        // At most 1e30: the products below stay finite.
        let metres = if known { metres.min(1e30) } else { 0.0 };
        let absorption = if self.pure_water {
            PURE_WATER_PER_METRE.map(|per_metre| per_metre * metres)
        } else {
            self.attenuation_color.map(|tau| tau * per_world)
        };
        MediumUniform {
            absorption: absorption.map(|sigma| sigma * self.attenuation_scale),
            scattering: self.turbidity * per_world,
        }
    }
}

impl Default for MediumParameters {
    fn default() -> Self {
        Self::of(Liquid::default())
    }
}

/// Absorption and scattering as the GPU sees them; WGSL: `meniscus::medium::Medium`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct MediumUniform {
    /// 1 / world unit.
    pub absorption: [f32; 3],
    /// 1 / world unit.
    pub scattering: f32,
}

impl MediumUniform {
    /// What is absorbed and scattered together, 1 / world unit.
    pub fn extinction(&self) -> [f32; 3] {
        self.absorption.map(|absorption| absorption + self.scattering)
    }
}

impl HostStruct for MediumUniform {
    const WGSL_NAME: &'static str = "Medium";
    const FIELDS: &'static [HostField] = host_fields!(MediumUniform { absorption, scattering });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_without_meaning_gives_clear_water() {
        for absurd in [0.0, -3.0, f32::NAN, f32::INFINITY] {
            let scale = WaterScale { depth_world: absurd, spacing_world: f32::NAN, metres_per_world: absurd };
            let pure = MediumParameters { pure_water: true, ..Default::default() };
            assert_eq!(pure.uniform(scale).absorption, [0.0; 3]);
            let uniform = MediumParameters::default().uniform(scale);
            assert_eq!((uniform.absorption, uniform.scattering), ([0.0; 3], 0.0));
        }
    }
}
