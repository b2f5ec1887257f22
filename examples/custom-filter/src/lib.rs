//! A surface filter of one's own: planes fitted to the neighbourhood of every pixel.
//!
//! It stays on planes of any tilt up to the silhouettes, where filters that average are drawn off them. On a software driver
//! it costs about twice as much as the default filter. The formula is in `plane_fit.wgsl` and, for the tests, in [`twin`].

mod filter;
mod params;
pub mod twin;

pub use filter::PlaneFit;
pub use params::PlaneFitParams;
