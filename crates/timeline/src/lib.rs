//! Films run on the time of the simulation, whose frames need not lie evenly.
//!
//! A [`Timeline`] says which moment each picture shows. A [`Resampled`] source delivers the particles of these moments as if the
//! series had a frame for each: a frame of the data, or the particles on their way between two of them.

mod between;
mod source;
mod timeline;

pub use between::{Motion, between};
pub use source::Resampled;
pub use timeline::{Moment, Sample, Sampling, Shutter, Timeline, TimelineError, usual_step};
