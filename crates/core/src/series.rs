use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// Drawn radius per spacing: 1.25 times half the spacing, the value the filters' literature is tuned for.
pub const DEFAULT_RADIUS_PER_SPACING: f64 = 0.625;

/// Drawn radius per spacing of random particles: in their gaps, surfaces of smaller spheres are pitted.
pub const UNEVEN_RADIUS_PER_SPACING: f64 = 1.0;

/// Which axis of the file points up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UpAxis {
    /// x
    X,
    /// y
    Y,
    /// z
    Z,
}

impl UpAxis {
    /// Unit vector along the axis.
    pub fn vector(self) -> Vec3 {
        Vec3::AXES[self.index()]
    }

    /// 0, 1 or 2.
    pub fn index(self) -> usize {
        self as usize
    }

    /// `x`, `y` or `z`.
    pub fn letter(self) -> char {
        ['x', 'y', 'z'][self.index()]
    }
}

/// Where the spacing comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SpacingSource {
    /// The user gave it.
    User,
    /// Particle mass over a robust rest density.
    MassAndDensity,
    /// Robust local density of sampled particles.
    Estimate,
}

/// Where the drawn radius comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RadiusChoice {
    /// The user gave it.
    User,
    /// [`DEFAULT_RADIUS_PER_SPACING`] times the spacing, or more where particles lie unevenly, up to [`UNEVEN_RADIUS_PER_SPACING`].
    FromSpacing,
}

/// What is fixed once for a whole series (from its first readable frame) and shared by data and scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SeriesSpace {
    /// Subtracted from every coordinate before rounding to `f32`; file space.
    pub origin: DVec3,
    /// Physical distance of neighbouring particles, file units; a particle stands for `spacing^3` of volume.
    pub spacing: f64,
    /// How the spacing was found.
    pub spacing_source: SpacingSource,
    /// Radius drawn, file units. Changing it must not change the mean thickness.
    pub radius: f64,
    /// How the radius was found.
    pub radius_choice: RadiusChoice,
    /// Which file axis points up.
    pub up: UpAxis,
    /// Metres per file unit.
    pub metres_per_unit: f64,
}
