/// What can be wrong with a colour scale.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ColorError {
    /// A colour map that does not exist.
    #[error("there is no colour map `{found}`; there are: {available}")]
    UnknownMap {
        /// The name found.
        found: String,
        /// All names that would work.
        available: String,
    },
    /// Limits that are none.
    #[error("colours from {min} to {max}: {expected}")]
    Range {
        /// Lower limit.
        min: f64,
        /// Upper limit.
        max: f64,
        /// What is wrong.
        expected: &'static str,
    },
    /// Nothing before the colon.
    #[error("`{found}` names no attribute; expected NAME, NAME:x, NAME:magnitude or NAME:0")]
    NoName {
        /// As given.
        found: String,
    },
}
