use meniscus_gpu::GpuError;

/// What can go wrong with the surface stage.
#[derive(Debug, thiserror::Error)]
pub enum SsfrError {
    /// A parameter out of its range.
    #[error("surface parameter {name} is {found}, expected {expected}; change it with --param")]
    Parameter {
        /// Name as in the parameters.
        name: &'static str,
        /// What was given.
        found: String,
        /// What is allowed.
        expected: &'static str,
    },
    /// `--filter` names no filter.
    #[error("there is no surface filter `{wanted}`; there are: {available}")]
    NoSuchFilter {
        /// What was asked for.
        wanted: String,
        /// The registered names.
        available: String,
    },
    /// The parameters of a filter do not have the shape that it describes.
    #[error("parameters of the surface filter `{filter}`: {message}")]
    FilterParameters {
        /// Name of the filter.
        filter: &'static str,
        /// What does not fit.
        message: String,
    },
    /// The GPU refused.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}
