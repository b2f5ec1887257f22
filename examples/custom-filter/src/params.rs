use meniscus_ssfr::SsfrError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of [`PlaneFit`](crate::PlaneFit); each is a flag, `--param filter.sigma=1.2`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PlaneFitParams {
    /// Standard deviation in projected particle spacings, all passes together, 0 to 10.
    pub sigma: f32,
    /// Depth range in drawn radii, 0.1 to 1000: what is further in front or behind is another surface.
    pub range: f32,
    /// Passes, 2 to 4, each half as wide as the one before; their variances add up to that of `sigma`. The wide ones sample
    /// every few pixels only, the narrow ones smooth out what that leaves.
    pub passes: u32,
}

impl Default for PlaneFitParams {
    fn default() -> Self {
        Self { sigma: 1.0, range: 6.0, passes: 3 }
    }
}

impl PlaneFitParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`SsfrError::Parameter`] for the first number out of range (NaN is in none).
    pub fn validate(&self) -> Result<(), SsfrError> {
        for (name, found, range, expected) in [
            ("filter.sigma", self.sigma, 0.0..=10.0, "0 to 10"),
            ("filter.range", self.range, 0.1..=1000.0, "0.1 to 1000"),
            ("filter.passes", self.passes as f32, 2.0..=4.0, "2 to 4"),
        ] {
            if !range.contains(&found) {
                return Err(SsfrError::Parameter { name, found: found.to_string(), expected });
            }
        }
        Ok(())
    }

    /// Standard deviation of each pass in drawn radii, for particles `spacing_per_radius` drawn radii apart.
    pub(crate) fn pass_sigmas_radii(&self, spacing_per_radius: f32) -> impl Iterator<Item = f32> {
        let width = |pass: u32| 0.5f32.powi(pass as i32);
        let all = (0..self.passes).map(|pass| width(pass).powi(2)).sum::<f32>().sqrt();
        let sigma_radii = self.sigma * spacing_per_radius;
        (0..self.passes).map(move |pass| sigma_radii * width(pass) / all)
    }
}
