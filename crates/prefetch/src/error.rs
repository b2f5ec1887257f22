use std::io;

/// Why prefetching cannot start.
#[derive(Debug, thiserror::Error)]
pub enum PrefetchError {
    /// The share of free memory is out of range.
    #[error("memory share is {found}: expected a number above 0 and at most 1")]
    MemoryShare {
        /// The share given.
        found: f64,
    },
    /// The system refused a thread.
    #[error("cannot start a reader thread: {0}; allow more threads or ask for fewer with --threads")]
    Thread(#[from] io::Error),
    /// The system does not tell how much memory is free.
    #[error("cannot find out how much memory is free: {0}")]
    Memory(#[from] sysinfo::Error),
}
