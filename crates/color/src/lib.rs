//! Numbers as colours: which number of an attribute ([`Quantity`]), from where to where ([`ColorScale`]), in which colours
//! ([`ColorMap`]). Pictures and their legends use the same.

mod error;
mod map;
mod quantity;
mod scale;

pub use error::ColorError;
pub use map::ColorMap;
pub use quantity::{Component, Quantity};
pub use scale::{ColorScale, range_of};
