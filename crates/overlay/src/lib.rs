//! What is written over a finished picture: the time, a text, a colour legend and a scale bar. Nothing here knows the GPU.

mod canvas;
mod layout;
mod legend;
mod number;
mod scale_bar;
mod text;

pub use layout::Overlay;
pub use number::decimals_of_step;
pub use scale_bar::ScaleBar;
