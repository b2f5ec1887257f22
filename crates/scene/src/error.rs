/// What can be wrong with a scene file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// Not TOML, an unknown key or a value of the wrong type; the message holds line and column.
    #[error("{file}: {message}")]
    Toml {
        /// The scene file.
        file: String,
        /// The parser's words with the place.
        message: String,
    },
    /// A number outside of its range, or not finite.
    #[error("{file}: {key} is {found}, expected {expected}")]
    OutOfRange {
        /// The scene file.
        file: String,
        /// Path of the key, e.g. `sun.elevation_deg`.
        key: String,
        /// The value found.
        found: String,
        /// What is allowed.
        expected: &'static str,
    },
    /// A material that is neither built in nor defined under `[materials]`.
    #[error("{file}: {key} names the material `{found}`; there are: {available}")]
    UnknownMaterial {
        /// The scene file.
        file: String,
        /// Path of the key.
        key: String,
        /// The name found.
        found: String,
        /// All names that would work.
        available: String,
    },
    /// A picture of the surroundings that cannot be used.
    #[error("environment {file}: {message}")]
    Environment {
        /// The picture.
        file: String,
        /// What is wrong and what to do.
        message: String,
    },
    /// An elevation grid that cannot be used.
    #[error("terrain {file}: {message}")]
    Terrain {
        /// The grid.
        file: String,
        /// Where in it, what is wrong and what to do.
        message: String,
    },
    /// A view name that does not exist.
    #[error("there is no view `{found}`; use front, back, left, right, top or iso")]
    UnknownView {
        /// The name found.
        found: String,
    },
}
