use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Procedural structure of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Pattern {
    /// One colour.
    Plain,
    /// Square tiles with joints, each of a slightly different tone.
    Tiles,
    /// Cast concrete: cloudy tone, fine pores, wide joints.
    Concrete,
    /// Earth or sand: coarse and fine mottling.
    Soil,
}

/// An opaque surface in the metallic/roughness parametrisation (Burley 2012).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Material {
    /// Structure.
    pub pattern: Pattern,
    /// Base colour, linear Rec. 709, each in [0, 1].
    pub color: [f32; 3],
    /// Perceptual roughness in [0, 1]; GGX alpha is its square.
    pub roughness: f32,
    /// 0 = dielectric, 1 = metal.
    pub metallic: f32,
    /// Size of the pattern's largest element, e.g. a tile, in units of the file; 0 = chosen from the size of the scene.
    pub scale: f32,
}

impl Default for Material {
    fn default() -> Self {
        Self { pattern: Pattern::Plain, color: [0.5; 3], roughness: 0.7, metallic: 0.0, scale: 0.0 }
    }
}

impl Material {
    /// Names that [`Self::named`] knows.
    pub const NAMES: [&'static str; 6] = ["tiles", "concrete", "soil", "rock", "steel", "plain"];

    /// A built-in material.
    pub fn named(name: &str) -> Option<Self> {
        let of =
            |pattern, color, roughness, metallic| Self { pattern, color, roughness, metallic, scale: 0.0 };
        Some(match name {
            "tiles" => of(Pattern::Tiles, [0.65, 0.59, 0.50], 0.65, 0.0),
            "concrete" => of(Pattern::Concrete, [0.46, 0.45, 0.43], 0.85, 0.0),
            "soil" => of(Pattern::Soil, [0.34, 0.26, 0.18], 0.95, 0.0),
            "rock" => of(Pattern::Soil, [0.25, 0.235, 0.21], 0.9, 0.0),
            "steel" => of(Pattern::Plain, [0.56, 0.57, 0.58], 0.35, 1.0),
            "plain" => Self::default(),
            _ => return None,
        })
    }
}
