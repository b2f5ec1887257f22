use meniscus_gpu::Shader;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::blinn_phong::BlinnPhongUniform;
use crate::twin::TwinInput;
use crate::{
    BlinnPhongParameters, Formula, Liquid, MediumParameters, PixelModel, Promises, Surroundings, WaterScale,
};

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

/// Lambert's law on a veil of water: [`BlinnPhong`](crate::BlinnPhong) without its highlight.
pub type Lambert = PixelModel<LambertParameters>;

impl Formula for LambertParameters {
    const NAME: &'static str = "lambert";
    const SHADER: Shader = BlinnPhongParameters::SHADER;
    const KEEPS_SCENE: bool = true;
    const PASS: &'static str = "shading.lambert";
    type Uniform = BlinnPhongUniform;

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

    fn uniform(&self, scale: WaterScale, surroundings: &Surroundings) -> BlinnPhongUniform {
        let Self { medium, color } = self.clone();
        BlinnPhongParameters { medium, color, specular: 0.0, shininess: 1.0 }.uniform(scale, surroundings)
    }

    fn extinction(&self, scale: WaterScale) -> [f32; 3] {
        self.medium.uniform(scale).extinction()
    }

    fn shade_pixel(uniform: &BlinnPhongUniform, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4] {
        BlinnPhongParameters::shade_pixel(uniform, input, pixel)
    }
}
