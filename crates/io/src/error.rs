use std::fmt::Display;
use std::path::{Path, PathBuf};

use meniscus_core::{FrameError, FrameErrorKind};

use crate::expression::ExpressionError;

/// Why particles could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Nothing is there.
    #[error("{}: no such file or directory; check the path", .file.display())]
    NotFound {
        /// The path as given.
        file: PathBuf,
    },
    /// The system refused.
    #[error("{}: {message}", .file.display())]
    Io {
        /// The file at fault.
        file: PathBuf,
        /// The system's words.
        message: String,
    },
    /// Somebody wrote to the file while it was read.
    #[error("{}: the file {what} while it was read; read it again when its writer has finished", .file.display())]
    Changed {
        /// The file at fault.
        file: PathBuf,
        /// What happened to it.
        what: String,
    },
    /// The bytes are not what the format says.
    #[error("{}: {place}: {message}", .file.display())]
    Malformed {
        /// The file at fault.
        file: PathBuf,
        /// Byte offset or element in the file.
        place: String,
        /// Expected, found, advice.
        message: String,
    },
    /// A valid file of a kind that is not read.
    #[error("{}: {message}", .file.display())]
    Unsupported {
        /// The file at fault.
        file: PathBuf,
        /// What it is and what is read instead.
        message: String,
    },
    /// There is nothing to read.
    #[error("{}: {message}", .file.display())]
    Empty {
        /// The path at fault.
        file: PathBuf,
        /// What was looked for.
        message: String,
    },
    /// What was asked does not fit the data.
    #[error("{message}")]
    Usage {
        /// What was asked, what there is, what to do.
        message: String,
    },
    /// A selection cannot be understood or does not fit the data.
    #[error("{0}")]
    Expression(#[from] ExpressionError),
    /// Stopped on request.
    #[error("stopped on request")]
    Cancelled,
}

impl Error {
    /// Broad class, as in the error JSON.
    pub fn kind(&self) -> FrameErrorKind {
        match self {
            Self::NotFound { .. } => FrameErrorKind::NotFound,
            Self::Io { .. } | Self::Changed { .. } => FrameErrorKind::Io,
            Self::Malformed { .. } => FrameErrorKind::Malformed,
            Self::Unsupported { .. } => FrameErrorKind::Unsupported,
            Self::Empty { .. } => FrameErrorKind::Empty,
            Self::Usage { .. } | Self::Expression(_) => FrameErrorKind::Usage,
            Self::Cancelled => FrameErrorKind::Cancelled,
        }
    }

    /// The file at fault, where there is one.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::NotFound { file }
            | Self::Io { file, .. }
            | Self::Changed { file, .. }
            | Self::Malformed { file, .. }
            | Self::Unsupported { file, .. }
            | Self::Empty { file, .. } => Some(file),
            Self::Usage { .. } | Self::Expression(_) | Self::Cancelled => None,
        }
    }

    pub(crate) fn io(file: &Path, error: &std::io::Error) -> Self {
        if error.kind() == std::io::ErrorKind::NotFound {
            Self::NotFound { file: file.to_owned() }
        } else {
            Self::Io { file: file.to_owned(), message: error.to_string() }
        }
    }

    pub(crate) fn malformed(file: &Path, place: impl Display, message: impl Display) -> Self {
        Self::Malformed { file: file.to_owned(), place: place.to_string(), message: message.to_string() }
    }

    pub(crate) fn unsupported(file: &Path, message: impl Display) -> Self {
        Self::Unsupported { file: file.to_owned(), message: message.to_string() }
    }

    pub(crate) fn usage(message: impl Display) -> Self {
        Self::Usage { message: message.to_string() }
    }

    /// The message without the file name.
    fn detail(&self) -> String {
        match self {
            Self::NotFound { .. } => "no such file or directory; check the path".into(),
            Self::Changed { what, .. } => {
                format!("the file {what} while it was read; read it again when its writer has finished")
            }
            Self::Malformed { place, message, .. } => format!("{place}: {message}"),
            Self::Io { message, .. } | Self::Unsupported { message, .. } | Self::Empty { message, .. } => {
                message.clone()
            }
            Self::Usage { .. } | Self::Expression(_) | Self::Cancelled => self.to_string(),
        }
    }
}

impl From<Error> for FrameError {
    fn from(error: Error) -> Self {
        Self { kind: error.kind(), file: error.file().map(Path::to_owned), message: error.detail() }
    }
}

/// Why bytes are refused by those who do not know whose they are.
#[derive(Debug)]
pub(crate) enum Fault {
    /// What is wrong with them.
    Bytes(String),
    /// They could not be read.
    File(Error),
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        Self::File(error)
    }
}

impl From<String> for Fault {
    fn from(message: String) -> Self {
        Self::Bytes(message)
    }
}

impl From<&str> for Fault {
    fn from(message: &str) -> Self {
        Self::Bytes(message.to_owned())
    }
}
