//! The screen-space surface: splats of particles (nearest distance, thickness as a true length), smoothing by a swappable
//! filter, normals. All passes are compute passes over storage images.
//!
//! [`Ssfr`] records the passes of a frame into [`SurfaceImages`]. Filters implement [`SurfaceFilter`] and are found by
//! name in a [`FilterRegistry`]. [`twin`] has the same algorithms on the CPU, written after the formulas; they are the
//! specification that the shaders are tested against.
//!
//! A splat is the exact sphere of a particle, or the ellipsoid that [`ShapePasses`] made of it after how its neighbours lie
//! ([`AnisotropyParams`]). It is drawn when all of it lies beyond the camera's near distance (so the
//! eye is never inside a splat) and only where it is in front of the opaque scene.

pub mod conformance;
mod error;
pub mod filter;
mod images;
mod params;
mod passes;
mod shape;
mod splats;
mod stage;
pub mod twin;

pub use error::SsfrError;
pub use filter::{FilterEntry, FilterImages, FilterRegistry, SurfaceFilter};
pub use images::SurfaceImages;
pub use params::{Anisotropy, AnisotropyParams, FilterChoice, SplatParams, SsfrParams, ThicknessParams};
pub use passes::{
    ColoredSet, Coloring, FoamSplats, FoamUniform, NO_VALUE, ScaleUniform, ShapePage, ShapePasses, ShapeWork,
};
pub use splats::{Radii, SplatInput, SplatSet, Tested};
pub use stage::Ssfr;
