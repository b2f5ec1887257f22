//! What every stage shares and what crosses layers: particle frames, the space of a series, cameras, cost
//! reports, flaws and the [`FrameSource`] trait. Nothing here knows files or GPUs.
//!
//! # Spaces
//! * **file** space: the coordinates in the user's file, `f64`, any unit, any up axis.
//! * **world** space: file space minus the series' origin, `f32`, still in the file's unit and axes.
//! * **view** space: right-handed, x right, y up, the camera looks along -z. A *distance* is `-z`: positive, measured
//!   along the view axis, not along the ray.

mod bounds;
mod bulk;
mod camera;
mod counters;
mod flaws;
mod frame;
mod frustum;
mod hermite;
mod pixels;
mod report;
mod series;
mod short;
mod source;
pub mod srgb;

pub use bounds::Aabb;
pub use bulk::Bulk;
pub use camera::{Camera, CameraError, Projection};
pub use counters::{FrameRead, WorkCounters};
pub use flaws::{Flaw, Flaws};
pub use frame::{Attribute, Look, ParticleFrame, ParticleSet, SIZES, SetFrame};
pub use frustum::Frustum;
pub use hermite::hermite_weights;
pub use pixels::{Channel, PixelDepth, Pixels};
pub use report::{Choice, FrameReport, StageCost};
pub use series::{
    DEFAULT_RADIUS_PER_SPACING, RadiusChoice, SeriesSpace, SpacingSource, UNEVEN_RADIUS_PER_SPACING, UpAxis,
};
pub use short::Short;
pub use source::{Cancel, FrameError, FrameErrorKind, FrameRequest, FrameSource};
