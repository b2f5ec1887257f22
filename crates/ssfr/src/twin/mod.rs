//! The stage on the CPU, after the formulas, in double precision: the specification of the shaders of the same names.
//! Images are slices, row by row from the top left.

mod coloring;
mod depth;
mod filter;
mod foam;
mod normal;
mod shape;
mod splat;
mod thickness;
mod view;

pub use coloring::coloring;
pub use depth::{DepthImages, depth};
pub use filter::{adaptive, bilateral, curvature_flow, gaussian, narrow_range, narrow_range_paper, none};
pub use foam::foam;
pub use normal::{normal, unpack_normal};
pub use shape::{HostShape, ShapeRule, shapes};
pub use splat::HostSet;
pub use thickness::{thickness_smooth, thickness_sum};
pub use view::HostView;
