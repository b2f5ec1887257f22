use meniscus_gpu::GpuError;

/// What can go wrong with light.
#[derive(Clone, Debug, thiserror::Error)]
pub enum ShadingError {
    /// No lighting model of that name.
    #[error("there is no lighting model `{found}`; there are: {available}")]
    UnknownModel {
        /// The name found.
        found: String,
        /// All names, in order.
        available: String,
    },
    /// Parameters that the model does not have or that are of another type.
    #[error("lighting model {model}: {message}")]
    Parameters {
        /// Name of the model.
        model: &'static str,
        /// What does not fit, with the names that exist.
        message: String,
    },
    /// A parameter outside of its range.
    #[error("lighting model {model}: {name} is {found}, expected {expected}")]
    OutOfRange {
        /// Name of the model.
        model: &'static str,
        /// Name of the parameter.
        name: String,
        /// The value found.
        found: f32,
        /// What is allowed.
        expected: String,
    },
    /// The GPU refused a resource or a shader.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}
