//! From linear radiance to a display image: exposure, white balance, contrast, saturation, tone curve, sRGB transfer and
//! anti-aliasing. Whatever comes in, every pixel that goes out is a colour.

mod compositor;
pub mod develop;
mod error;
mod parameters;
pub mod twin;

pub use compositor::Compositor;
pub use error::CompositorError;
pub use parameters::{CompositorParameters, ToneCurve};
