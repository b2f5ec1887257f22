//! A lighting model of one's own: a chart of the water instead of its look.
//!
//! Colour tells the length of water behind a pixel (seen from above: its depth), contour lines mark equal steps, and a
//! relief shading shows the waves. The formula is in `chart.wgsl` and, for the tests, in [`twin`].

mod chart;
mod map;
mod params;
pub mod twin;

pub use chart::{Chart, ChartUniform};
pub use map::{STOPS, VIRIDIS};
pub use params::ChartParams;
