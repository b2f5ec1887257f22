//! The lighting models of this crate, one per file.

mod fluid;

pub(crate) use fluid::FluidUniform;
pub use fluid::{Fluid, FluidParameters};
