//! Light: what surrounds the water as the GPU sees it, the opaque scene pass, and the lighting models that shade the water.
//!
//! A [`LightingModel`] turns the smoothed surface, its thickness and normals and the drawn scene into linear radiance with
//! the water composited over the scene. Models are found by name in a [`LightingRegistry`], which is a plain value that a
//! program may extend.

mod calm;
pub mod conformance;
mod environment;
mod error;
mod foam;
mod formula;
mod liquid;
mod medium;
mod model;
mod models;
mod object_bounds;
mod opaque_scene;
mod parameters;
mod pictured;
mod registry;
mod solid;
mod sun_view;
mod surroundings;
pub mod twin;
mod vtk_names;

pub use environment::{EnvironmentMap, EnvironmentSize, EnvironmentTexels};
pub use error::ShadingError;
pub use foam::{FoamLook, FoamPass};
pub use formula::{Formula, PixelModel};
pub use liquid::Liquid;
pub use medium::{MediumParameters, MediumUniform};
pub use model::{LightingInputs, LightingModel, LightingPass, Parameters, Promises, WaterScale};
pub use models::{
    BlinnPhong, BlinnPhongParameters, DisplayMode, Fluid, FluidParameters, Granular, GranularParameters,
    Lambert, LambertParameters, OpaqueLiquid, OpaqueLiquidParameters, PointLight, PointLightParameters, Vtk,
    VtkParameters,
};
pub use object_bounds::ObjectBounds;
pub use opaque_scene::{SceneGeometry, ScenePass};
pub use registry::{LightingChoice, LightingRegistry};
pub use solid::{SolidPass, SolidSurface};
pub use sun_view::{Caustics, CausticsPass, CausticsScratch, SunView, SunWater, SunlightPass, Waves};
pub use surroundings::{MaterialUniform, SkyUniform, Surroundings};
pub use vtk_names::VTK_NAMES;

use meniscus_gpu::{Shader, shader};

/// Includes of this stage, dependencies first: `meniscus::brdf` and so on, by the names of the files.
pub const INCLUDES: &[Shader] = &[
    shader!(include "shading/brdf"),
    shader!(include "shading/material"),
    shader!(include "shading/sky"),
    shader!(include "shading/lit"),
    shader!(include "shading/sun_view"),
    shader!(include "shading/sunlight"),
    shader!(include "shading/environment"),
    shader!(include "shading/surroundings"),
    shader!(include "shading/scene_point"),
    shader!(include "shading/water"),
    shader!(include "shading/body"),
    shader!(include "shading/medium"),
    shader!(include "shading/lighting_inputs"),
    shader!(include "shading/neighbourhood"),
    shader!(include "shading/calm"),
    shader!(include "shading/scene_march"),
    shader!(include "shading/refraction"),
    shader!(include "shading/reflection"),
    shader!(include "shading/reflected_objects"),
    shader!(include "shading/shadow"),
];
