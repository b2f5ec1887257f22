use meniscus_shading::ShadingError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Chart;

/// Parameters of [`Chart`]; each is a flag, `--param lighting.depth=0.5`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ChartParams {
    /// Length of water at the end of the colour map, world units; left out: twice the representative depth of the data.
    pub depth: Option<f32>,
    /// Number of contour lines over that length, 0 (none) to 100.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub contours: f32,
    /// Width of contour lines in pixels, 0.5 to 20.
    #[schemars(range(min = 0.5, max = 20.0))]
    pub line_px: f32,
    /// Strength of the relief, 0 (flat colours) to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub relief: f32,
}

impl Default for ChartParams {
    fn default() -> Self {
        Self { depth: None, contours: 10.0, line_px: 1.2, relief: 0.6 }
    }
}

impl ChartParams {
    /// Checks every range.
    ///
    /// # Errors
    /// [`ShadingError::OutOfRange`] for the first value that does not fit (NaN never fits).
    pub fn validate(&self) -> Result<(), ShadingError> {
        for (name, found, range, expected) in [
            ("depth", self.depth.unwrap_or(1.0), 1e-30..=1e30, "a positive length"),
            ("contours", self.contours, 0.0..=100.0, "0 to 100"),
            ("line_px", self.line_px, 0.5..=20.0, "0.5 to 20"),
            ("relief", self.relief, 0.0..=1.0, "0 to 1"),
        ] {
            if !range.contains(&found) {
                return Err(ShadingError::OutOfRange { model: Chart::NAME, name, found, expected });
            }
        }
        Ok(())
    }
}
