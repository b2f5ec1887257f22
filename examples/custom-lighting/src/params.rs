use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of [`Chart`](crate::Chart); each is a flag, `--param lighting.depth=0.5`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChartParams {
    /// Length of water at the end of the colour map, world units; left out: twice the representative depth of the data.
    #[schemars(range(min = 1e-30, max = 1e30))]
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
