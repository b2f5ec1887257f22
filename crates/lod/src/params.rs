use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Identity, LodError};

/// How the keep probability of a chunk follows from its importance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Policy {
    /// Proportional to importance, scaled so that the threshold is the kept fraction; what can be seen goes before what is
    /// buried, and spray is spared. The volume of what is left out is kept by stand-ins.
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

/// What decides how much is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// The kept fraction that the user gives.
    #[default]
    Threshold,
    /// The errors that the user tolerates; the defaults are meant not to be seen.
    ErrorBound,
}

/// What the user chooses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LodParams {
    /// What decides: the threshold or the error bound.
    pub mode: Mode,
    /// Fraction of the particles in view that is kept, 0..=1; 1 is the picture without level of detail, bit for bit.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub threshold: f32,
    /// How detail is spread over the picture.
    pub policy: Policy,
    /// How far the surface may move, pixels, >= 0. Ripples that stand-ins cause in the thickness may be eight of these long.
    #[schemars(range(min = 0.0))]
    pub error_px: f32,
    /// How much the colour may change for what stand-ins do to the thickness, 0..=1 of the display's range: an estimate, no
    /// bound; at shores of distant water single pixels differ by some ten times the default. Also holds below threshold 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub error_color: f32,
    /// Distance from the eye along the view axis beyond which chunks are left out, world units, > 0; none: no limit.
    pub far: Option<f32>,
}

impl Default for LodParams {
    fn default() -> Self {
        Self {
            mode: Mode::Threshold,
            threshold: 1.0,
            policy: Policy::Default,
            error_px: 0.5,
            error_color: 1.0 / 255.0,
            far: None,
        }
    }
}

impl LodParams {
    /// Whether every particle in view is drawn as it is.
    pub fn is_full(&self) -> bool {
        self.mode == Mode::Threshold && self.threshold >= 1.0
    }

    /// Checks the ranges.
    ///
    /// # Errors
    /// [`LodError::Threshold`] or [`LodError::Parameter`].
    pub fn validate(&self) -> Result<(), LodError> {
        if !(0.0..=1.0).contains(&self.threshold) {
            return Err(LodError::Threshold(self.threshold));
        }
        if !(self.error_px >= 0.0 && self.error_px.is_finite()) {
            return Err(LodError::Parameter {
                name: "error_px",
                found: self.error_px,
                expected: "0 or more pixels",
            });
        }
        if !(0.0..=1.0).contains(&self.error_color) {
            return Err(LodError::Parameter {
                name: "error_color",
                found: self.error_color,
                expected: "0 to 1",
            });
        }
        match self.far {
            Some(far) if far.is_nan() || far <= 0.0 => {
                Err(LodError::Parameter { name: "far", found: far, expected: "a positive length" })
            }
            _ => Ok(()),
        }
    }
}
