//! From linear radiance to a display image: exposure, white balance, bloom, contrast, saturation, tone curve, sRGB transfer and
//! anti-aliasing. Whatever comes in, every pixel that goes out is a colour.

mod bloom;
mod compositor;
pub mod develop;
mod display;
mod error;
mod meter;
mod parameters;
pub mod twin;

pub use compositor::Compositor;
pub use display::Display;
pub use error::CompositorError;
pub use meter::Meter;
pub use parameters::{CompositorParameters, ToneCurve};
