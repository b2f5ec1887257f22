use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::SetFrame;

/// Asks a running read to stop; cheap to clone and to check.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// Requests the stop.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the stop was requested.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// What of a frame is wanted besides the positions. What is not asked for is neither read nor decoded.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FrameRequest {
    /// Names of attributes to deliver.
    pub attributes: Vec<String>,
}

/// Broad class of a read error; the error JSON's `kind` and the basis of the exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameErrorKind {
    /// The file is not there.
    NotFound,
    /// The system refused: permission, not a regular file, disk error.
    Io,
    /// The bytes are not what the format says.
    Malformed,
    /// A valid file of a kind that is not supported.
    Unsupported,
    /// There is nothing to draw in it.
    Empty,
    /// What the user asked for does not fit the file (unknown attribute, frame out of range, bad expression).
    Usage,
    /// Stopped on request.
    Cancelled,
}

impl FrameErrorKind {
    /// Name as used in JSON.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::NotFound => "not_found",
            Self::Io => "io",
            Self::Malformed => "malformed",
            Self::Unsupported => "unsupported",
            Self::Empty => "empty",
            Self::Usage => "usage",
            Self::Cancelled => "cancelled",
        }
    }
}

/// A frame that could not be delivered: what went wrong, in words for the user, and with which file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FrameError {
    /// Broad class.
    pub kind: FrameErrorKind,
    /// The file at fault, where there is one.
    pub file: Option<PathBuf>,
    /// Place in the file, what was expected, what was found, what to do. Does not repeat the file name.
    pub message: String,
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.file {
            Some(file) => write!(f, "{}: {}", file.display(), self.message),
            None => f.write_str(&self.message),
        }
    }
}

impl std::error::Error for FrameError {}

/// A series of frames: what readers give and prefetching wants.
pub trait FrameSource: Send + Sync {
    /// Number of frames. May grow at the end while the source is in use, where a solver still adds to the series; never
    /// shrinks.
    fn frame_count(&self) -> usize;

    /// Simulation time of frame `index`, where the series states one without reading the frame.
    fn time(&self, index: usize) -> Option<f64>;

    /// Bytes that the delivered frame will take in memory, as well as that is known before reading.
    fn estimated_bytes(&self, index: usize) -> u64;

    /// Reads frame `index`. Safe to call from several threads.
    ///
    /// # Errors
    /// [`FrameError`] when the frame cannot be delivered; other frames may still be readable.
    fn read(&self, index: usize, request: &FrameRequest, cancel: &Cancel) -> Result<SetFrame, FrameError>;

    /// A number that changes when the files of frame `index` do, which is when it is worth being read again;
    /// `None` where nothing can change. Asks the file system, and so may take as long as that likes.
    fn version(&self, _index: usize) -> Option<u64> {
        None
    }

    /// A first impression of frame `index` at about a `share`-th of the cost: particles spread evenly over it. `None` where a
    /// part costs as much as the whole.
    ///
    /// # Errors
    /// As [`Self::read`].
    fn read_coarse(
        &self,
        _index: usize,
        _share: u32,
        _request: &FrameRequest,
        _cancel: &Cancel,
    ) -> Result<Option<SetFrame>, FrameError> {
        Ok(None)
    }
}
