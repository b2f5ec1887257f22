//! Light: what surrounds the water as the GPU sees it, the opaque scene pass, and the lighting models that shade the water.
//!
//! A [`LightingModel`] turns the smoothed surface, its thickness and normals and the drawn scene into linear radiance with
//! the water composited over the scene. Models are found by name in a [`LightingRegistry`], which is a plain value that a
//! program may extend.

mod error;
mod model;
mod models;
mod opaque;
mod registry;
mod solid;
mod surroundings;
pub mod twin;
mod water_shadow;

pub use error::ShadingError;
pub use model::{LightingInputs, LightingModel, LightingPass, Parameters, WaterScale};
pub use models::{Fluid, FluidParameters};
pub use opaque::{SceneGeometry, ScenePass};
pub use registry::{LightingChoice, LightingRegistry};
pub use solid::{SolidPass, SolidSurface};
pub use surroundings::{MaterialUniform, SkyUniform, Surroundings};
pub use water_shadow::{SunPath, WaterShadow};

use meniscus_gpu::{Shader, shader};

/// Includes of this stage, dependencies first: `meniscus::brdf`, `material`, `sky`, `lit`, `surroundings`, `water`.
pub const INCLUDES: &[Shader] = &[
    shader!(include "shading/brdf"),
    shader!(include "shading/material"),
    shader!(include "shading/sky"),
    shader!(include "shading/lit"),
    shader!(include "shading/surroundings"),
    shader!(include "shading/water"),
];
