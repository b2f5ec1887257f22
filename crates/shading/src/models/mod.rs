//! The lighting models of this crate, one per file: parameters, uniform, name. The formulas are in `shaders/shading` and, for
//! the tests, in [`twin`](crate::twin).

mod blinn_phong;
mod fluid;
mod granular;
mod lambert;
mod opaque_liquid;
mod point_light;
mod vtk;

pub(crate) use blinn_phong::BlinnPhongUniform;
pub use blinn_phong::{BlinnPhong, BlinnPhongParameters};
pub(crate) use fluid::FluidUniform;
pub use fluid::{Fluid, FluidParameters};
pub(crate) use granular::GranularUniform;
pub use granular::{Granular, GranularParameters};
pub use lambert::{Lambert, LambertParameters};
pub(crate) use opaque_liquid::OpaqueLiquidUniform;
pub use opaque_liquid::{OpaqueLiquid, OpaqueLiquidParameters};
pub(crate) use point_light::PointLightUniform;
pub use point_light::{PointLight, PointLightParameters};
pub(crate) use vtk::VtkUniform;
pub use vtk::{DisplayMode, Vtk, VtkParameters};
