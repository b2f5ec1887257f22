use meniscus_scene::CLEAR_WATER_OPTICAL_DEPTH;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A kind of liquid: a preset of lighting models.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Liquid {
    /// Clear water.
    #[default]
    Clear,
    /// Sea water: greener and a little turbid.
    Sea,
    /// A river that carries silt.
    River,
    /// Milk.
    Milk,
    /// Mud.
    Mud,
    /// Vegetable oil.
    Oil,
}

/// How a liquid looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LiquidLook {
    /// Optical depth of absorption per channel over the representative depth.
    pub absorption: [f32; 3],
    /// Optical depth of scattering.
    pub turbidity: f32,
    pub refractive_index: f32,
    /// Perceptual.
    pub roughness: f32,
    /// Whiteness of single drops.
    pub spray: f32,
    /// Albedo of a body that is too deep to be seen through.
    pub color: [f32; 3],
}

impl Liquid {
    /// All names.
    pub const NAMES: [&'static str; 6] = ["clear", "sea", "river", "milk", "mud", "oil"];

    pub(crate) fn look(self) -> LiquidLook {
        match self {
            Self::Clear => LiquidLook {
                absorption: CLEAR_WATER_OPTICAL_DEPTH,
                turbidity: 0.06,
                refractive_index: 1.333,
                roughness: 0.15,
                spray: 0.35,
                color: [0.08, 0.27, 0.40],
            },
            Self::Sea => LiquidLook {
                absorption: [2.6, 0.62, 0.48],
                turbidity: 0.22,
                refractive_index: 1.339,
                roughness: 0.17,
                spray: 0.45,
                color: [0.04, 0.20, 0.24],
            },
            Self::River => LiquidLook::turbid([0.40, 0.34, 0.22], 2.2, 1.333, 0.17, 0.3),
            Self::Milk => LiquidLook::turbid([0.93, 0.90, 0.83], 60.0, 1.346, 0.2, 0.0),
            Self::Mud => LiquidLook::turbid([0.30, 0.20, 0.12], 25.0, 1.36, 0.32, 0.0),
            Self::Oil => LiquidLook {
                absorption: [0.18, 0.75, 4.2],
                turbidity: 0.08,
                refractive_index: 1.47,
                roughness: 0.12,
                spray: 0.0,
                color: [0.55, 0.36, 0.04],
            },
        }
    }
}

impl LiquidLook {
    /// A liquid with this albedo where light does not get through: scattering over extinction.
    fn turbid(color: [f32; 3], turbidity: f32, refractive_index: f32, roughness: f32, spray: f32) -> Self {
        let absorption = color.map(|albedo| turbidity * (1.0 / albedo - 1.0));
        Self { absorption, turbidity, refractive_index, roughness, spray, color }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_parameter() {
        for name in Liquid::NAMES {
            let liquid: Liquid = serde_json::from_value(name.into()).unwrap();
            assert_eq!(serde_json::to_value(liquid).unwrap(), name);
        }
    }
}
