//! Continuous level of detail: which particles are drawn, decided per chunk of neighbours (`main-renderer.md` 3).
//!
//! * [`chunks`] reorders a frame once, on the thread that read it: chunks of neighbouring particles, each sorted so that
//!   the particles kept under any threshold are a prefix.
//! * [`select()`] turns a camera and a threshold into [`KeptRange`](meniscus_gpu::role::KeptRange)s. The decision is one
//!   keep probability per chunk, cheap enough for the CPU, and reaches the GPU as an integer: both keep the same set.
//! * [`Selector`] repeats it only when something has changed; [`GpuSet`] holds a set and its ranges on the GPU.
//! * [`weight`] is the CPU twin of what the splat passes make of a kept particle.
//!
//! A particle with 16-bit hash `h` is kept in a range of probability `keep / 65536` exactly when `h < keep`. What is kept
//! at a threshold is therefore kept at every higher one, whatever moves.

mod cells;
pub mod chunks;
pub mod cut;
mod detail;
mod error;
pub mod foam;
mod governor;
mod gpu_set;
mod grid;
mod hash;
mod hilbert;
mod params;
pub mod select;
mod selector;
mod set_store;
mod shape_batches;
mod stand_ins;
mod view;
pub mod weight;

pub use chunks::{Chunk, ChunkOptions, ChunkedSet};
pub use error::LodError;
pub use foam::{FoamOptions, Foaminess};
pub use governor::{RateGovernor, Refinement};
pub use gpu_set::{GpuSet, PageLists};
pub use hash::Identity;
pub use params::{LodParams, Mode, Policy};
pub use select::{Fate, PageSelection, ParticleCounts, Selection, Viewpoint, explain, select};
pub use selector::Selector;
pub use set_store::{SetPage, SetPages, SetStore, SetStoreStats};
pub use shape_batches::{ShapeBatch, shape_batches};
pub use stand_ins::{Coarseness, StandIns};
