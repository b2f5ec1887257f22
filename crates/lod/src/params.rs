use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Identity, LodError};

/// How the keep probability of a chunk follows from its importance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Policy {
    /// Proportional to importance, scaled so that the threshold is the kept fraction; spray is spared.
    #[default]
    Default,
    /// The source's own formula (`main-renderer.md` 3, \[T\] equations 3.1 and 3.2), taken at chunk centres: its level
    /// `l = r w / CLOD`, with `w` the importance `1000 max(1 - 0.7 d_c/d_max, 0.3) / d` and `r` the sine hash of the
    /// position, is mapped to `l / (1 + l)` and kept when that reaches `1 - threshold`. CLOD is the mean `w` of what is
    /// visible, instead of a number tuned by hand. The threshold is not the kept fraction, and spray is thinned like the
    /// rest. Needs a set built with [`Identity::Position`] for the source's random numbers; with another set only the
    /// importance is the source's.
    Thesis,
}

impl Policy {
    /// What the random number of a particle is drawn from under this policy.
    pub fn identity(self) -> Identity {
        match self {
            Self::Default => Identity::Id,
            Self::Thesis => Identity::Position,
        }
    }
}

/// What the user chooses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LodParams {
    /// Fraction of the visible particles that is kept, 0..=1; 1 is the picture without level of detail, bit for bit.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub threshold: f32,
    /// How detail is spread over the picture.
    pub policy: Policy,
}

impl Default for LodParams {
    fn default() -> Self {
        Self { threshold: 1.0, policy: Policy::Default }
    }
}

impl LodParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`LodError::Threshold`].
    pub fn validate(&self) -> Result<(), LodError> {
        if (0.0..=1.0).contains(&self.threshold) { Ok(()) } else { Err(LodError::Threshold(self.threshold)) }
    }
}
