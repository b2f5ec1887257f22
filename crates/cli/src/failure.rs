use meniscus_core::{CameraError, FrameError, FrameErrorKind};
use meniscus_export::ExportError;
use meniscus_gpu::GpuError;
use meniscus_pipeline::{PipelineError, ShadingError, SsfrError};

/// Everything that ends a command early; its message is one readable paragraph.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The command line does not fit the data or itself.
    #[error("{0}")]
    Usage(String),
    /// The input cannot be read.
    #[error(transparent)]
    Input(#[from] FrameError),
    /// The GPU or its driver failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The picture cannot be made.
    #[error(transparent)]
    Pipeline(PipelineError),
    /// Reading ahead cannot start.
    #[error(transparent)]
    Prefetch(#[from] meniscus_prefetch::PrefetchError),
    /// The output cannot be written.
    #[error(transparent)]
    Output(#[from] ExportError),
    /// The output cannot be written any further; what was written is kept.
    #[error("{error}; {kept}")]
    Unfinished {
        /// Why.
        error: ExportError,
        /// What is there and what is missing.
        kept: String,
    },
    /// Some frames of a sequence could not be read; the others were written.
    #[error("{failed} of {wanted} frames could not be read and are missing; the first: {first}")]
    FramesMissing {
        /// How many are missing.
        failed: usize,
        /// How many were asked for.
        wanted: usize,
        /// The first one's error.
        first: String,
    },
    /// Ctrl-C.
    #[error("interrupted; what was finished is kept")]
    Interrupted,
    /// Ctrl-C, on the way through a sequence or film.
    #[error("interrupted; {kept}")]
    InterruptedOutput {
        /// What is there.
        kept: String,
    },
}

impl Failure {
    /// The process's exit code (see `--help`).
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) => 2,
            Self::Input(error) => match error.kind {
                FrameErrorKind::Usage => 2,
                FrameErrorKind::Cancelled => 130,
                _ => 3,
            },
            Self::Gpu(
                GpuError::NoAdapter | GpuError::NoSuchAdapter { .. } | GpuError::OnlySoftware { .. },
            ) => 4,
            Self::Gpu(_) | Self::Pipeline(_) | Self::Prefetch(_) => 1,
            Self::FramesMissing { .. } => 3,
            Self::Output(_) | Self::Unfinished { .. } => 5,
            Self::Interrupted | Self::InterruptedOutput { .. } => 130,
        }
    }

    /// Name of the class, as in the error JSON.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Usage(_) => FrameErrorKind::Usage.as_str(),
            Self::Input(error) => error.kind.as_str(),
            Self::Gpu(_) => "gpu",
            Self::Pipeline(_) => "pipeline",
            Self::Prefetch(_) => "prefetch",
            Self::Output(_) | Self::Unfinished { .. } => "output",
            Self::FramesMissing { .. } => "frames_missing",
            Self::Interrupted | Self::InterruptedOutput { .. } => "interrupted",
        }
    }

    /// The file at fault, where there is one.
    pub fn file(&self) -> Option<String> {
        match self {
            Self::Input(error) => error.file.as_ref().map(|f| f.display().to_string()),
            Self::Output(error) | Self::Unfinished { error, .. } => Some(error.path().display().to_string()),
            _ => None,
        }
    }
}

impl From<meniscus_io::Error> for Failure {
    fn from(error: meniscus_io::Error) -> Self {
        Self::Input(error.into())
    }
}

impl From<PipelineError> for Failure {
    /// What a stage refuses about its parameters is the command line's; what it passes through keeps its own exit code.
    fn from(error: PipelineError) -> Self {
        let malformed =
            |file, message| Self::Input(FrameError { kind: FrameErrorKind::Malformed, file, message });
        match error {
            PipelineError::Gpu(error)
            | PipelineError::Surface(SsfrError::Gpu(error))
            | PipelineError::Shading(ShadingError::Gpu(error)) => Self::Gpu(error),
            PipelineError::Frame(error) => Self::Input(error),
            PipelineError::Camera(error) => Self::from(error),
            PipelineError::SceneFile { path, source } => {
                let kind = match source.kind() {
                    std::io::ErrorKind::NotFound => FrameErrorKind::NotFound,
                    _ => FrameErrorKind::Io,
                };
                Self::Input(FrameError {
                    kind,
                    file: Some(path),
                    message: format!("the scene file cannot be read: {source}"),
                })
            }
            PipelineError::Scene(error) => malformed(None, error.to_string()),
            PipelineError::Settings(_)
            | PipelineError::Color(_)
            | PipelineError::NothingToColor { .. }
            | PipelineError::Lod(_)
            | PipelineError::Surface(_)
            | PipelineError::Shading(_) => Self::Usage(error.to_string()),
            PipelineError::Compositor(_) => Self::Pipeline(error),
        }
    }
}

impl From<CameraError> for Failure {
    fn from(error: CameraError) -> Self {
        Self::Usage(error.to_string())
    }
}
