use meniscus_gpu::GpuError;

/// What can go wrong in composition.
#[derive(Clone, Debug, thiserror::Error)]
pub enum CompositorError {
    /// A parameter outside of its range.
    #[error("{name} is {found}, expected {expected}")]
    OutOfRange {
        /// Name of the parameter.
        name: &'static str,
        /// The value found.
        found: f32,
        /// What is allowed.
        expected: &'static str,
    },
    /// The GPU refused a resource or a shader.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}
