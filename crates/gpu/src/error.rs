use std::sync::{Arc, Mutex, PoisonError};

use crate::INSTALL_HINT;

/// What can go wrong with the GPU.
#[derive(Clone, Debug, thiserror::Error)]
pub enum GpuError {
    /// No Vulkan driver at all.
    #[error("no Vulkan adapter was found, neither a GPU nor a software driver. {INSTALL_HINT}")]
    NoAdapter,
    /// `--adapter` matches nothing.
    #[error(
        "no adapter matches `{wanted}`; there are: {available}. `--list-adapters` shows them with their drivers"
    )]
    NoSuchAdapter {
        /// What was asked for.
        wanted: String,
        /// Names and indices found.
        available: String,
    },
    /// `--require-gpu`, but only software.
    #[error("--require-gpu: only software adapters were found ({available}). {advice}")]
    OnlySoftware {
        /// Names found.
        available: String,
        /// What to do.
        advice: String,
    },
    /// The adapter lacks a limit or feature we cannot do without.
    #[error(
        "adapter `{adapter}` has {name} = {found}, meniscus needs {needed}; choose another with --adapter"
    )]
    Limit {
        /// Adapter name.
        adapter: String,
        /// Limit or feature.
        name: &'static str,
        /// What the adapter has.
        found: u64,
        /// What is needed.
        needed: u64,
    },
    /// The driver refused the device.
    #[error("adapter `{adapter}` did not give a device: {message}")]
    Device {
        /// Adapter name.
        adapter: String,
        /// The driver's words.
        message: String,
    },
    /// A shader does not compose or validate.
    #[error("shader {shader}: {message}")]
    Shader {
        /// `stage/pass`.
        shader: String,
        /// What the compiler said, with the place.
        message: String,
    },
    /// The device's memory is full.
    #[error(
        "{what} needs {bytes} bytes, and the memory of the GPU is full; close other programs that draw, or use a smaller --size"
    )]
    OutOfMemory {
        /// Role of the resource.
        what: String,
        /// Bytes asked for.
        bytes: u64,
    },
    /// A resource is larger than the device allows.
    #[error("{what} needs {bytes} bytes, the device allows {limit}; use a smaller --size")]
    TooLarge {
        /// Role of the resource.
        what: String,
        /// Bytes asked for.
        bytes: u64,
        /// The device's limit.
        limit: u64,
    },
    /// The driver reported an error while the frame ran.
    #[error("the driver reported: {0}")]
    Driver(String),
}

/// Where errors wait that come up while nobody can be told: the first one counts.
#[derive(Clone, Debug, Default)]
pub(crate) struct ErrorSink(Arc<Mutex<Option<String>>>);

impl ErrorSink {
    pub(crate) fn report(&self, message: String) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(message);
    }

    pub(crate) fn take(&self) -> Option<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}
