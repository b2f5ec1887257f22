use std::path::PathBuf;

use meniscus_core::{CameraError, FrameError};
use meniscus_gpu::GpuError;
use meniscus_scene::SceneError;

use crate::SettingsError;

/// Why a picture cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum PipelineError {
    /// The GPU or its driver failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The camera defines no picture.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// The colour scale is none.
    #[error(transparent)]
    Color(#[from] meniscus_color::ColorError),
    /// No particle has a value of what the particles are to be coloured by.
    #[error(
        "--color-by: no particle that is drawn has a {of} as `{quantity}` in the first, middle and last frame; give --color-range"
    )]
    NothingToColor {
        /// The attribute, and its component.
        quantity: String,
        /// What was looked for.
        of: &'static str,
    },
    /// No frame to measure the series by.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// Level of detail refuses its parameters.
    #[error(transparent)]
    Lod(#[from] meniscus_lod::LodError),
    /// The surface stage failed.
    #[error(transparent)]
    Surface(#[from] meniscus_ssfr::SsfrError),
    /// The shading stage failed.
    #[error(transparent)]
    Shading(#[from] meniscus_shading::ShadingError),
    /// The compositor failed.
    #[error(transparent)]
    Compositor(#[from] meniscus_compositor::CompositorError),
    /// A setting is out of range or unknown.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The scene file is not right.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene file cannot be read.
    #[error("{}: the scene file cannot be read: {source}", path.display())]
    SceneFile {
        /// The file.
        path: PathBuf,
        /// The system's words.
        source: std::io::Error,
    },
}
