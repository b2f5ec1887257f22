//! Future frames, loaded ahead as far as free memory allows.
//!
//! A [`Prefetcher`] reads the frames that a [`Plan`] says come next, several at once, on its own threads, and keeps them
//! prepared until they are taken. Its parts:
//!
//! * the *policy* decides: which frame to read next, which running read to stop, which frame to give up. It knows no
//!   threads, files or clocks, only what it is told, so that tests can play any disk and any memory against it;
//! * one coordinating thread owns the policy and all waiting frames. Everything reaches it as a message, nothing is shared;
//! * reader threads read and prepare one frame after the other. They are handed a frame only when they are idle, so that no
//!   stale request ever waits in a queue;
//! * one thread watches the medium: frames whose files have changed since they were read, or since they failed, are read again,
//!   and frames that are added to the series join in.
//!
//! The order of reading is the order of showing: nearest deadline first. Memory is a share of what the system has free
//! plus what is held here, asked again while running.

mod budget;
mod coordinator;
mod error;
mod memory;
mod meter;
mod plan;
mod policy;
mod prefetcher;
mod reader;
mod record;
#[cfg(test)]
mod simulation;
mod watch;

pub use budget::MemoryLimit;
pub use error::PrefetchError;
pub use memory::{MemoryProbe, SystemMemory};
pub use meter::PrefetchStats;
pub use plan::Plan;
pub use policy::FrameState;
pub use prefetcher::{PrefetchOptions, Prefetcher};
pub use record::FrameRecord;
