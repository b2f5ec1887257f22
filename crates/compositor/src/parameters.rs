use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::CompositorError;

/// How linear radiance becomes display brightness.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ToneCurve {
    /// Khronos PBR neutral: colours are kept, only highlights are compressed.
    #[default]
    Neutral,
    /// Filmic: more contrast, softer highlights (Narkowicz 2015).
    Filmic,
    /// None: what exceeds 1 is cut.
    Clip,
}

/// Parameters of composition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CompositorParameters {
    /// Exposure in stops, -20 to 20: each one more doubles the light. None: metered ([`Meter`](crate::Meter)).
    #[schemars(range(min = -20.0, max = 20.0))]
    pub exposure: Option<f32>,
    /// Factor per channel that makes the light neutral, each 0 to 10.
    pub white_balance: [f32; 3],
    /// Contrast around middle grey, 0.1 to 4.
    #[schemars(range(min = 0.1, max = 4.0))]
    pub contrast: f32,
    /// Saturation, 0 (grey) to 4.
    #[schemars(range(min = 0.0, max = 4.0))]
    pub saturation: f32,
    /// Bloom: share of the light that the lens scatters around what is bright, 0 (none) to 1. Of pictures, not of linear `.exr` files.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub bloom: f32,
    /// Tone curve.
    pub tone_curve: ToneCurve,
    /// Whether edges are smoothed.
    pub anti_aliasing: bool,
    /// Whether alpha is the coverage by water and objects, for a picture to be laid over another; else it is 1.
    pub transparent: bool,
}

impl Default for CompositorParameters {
    fn default() -> Self {
        Self {
            exposure: Some(0.0),
            white_balance: [1.0; 3],
            contrast: 1.0,
            saturation: 1.0,
            bloom: 0.0,
            tone_curve: ToneCurve::Neutral,
            anti_aliasing: true,
            transparent: false,
        }
    }
}

impl CompositorParameters {
    /// Least and greatest exposure in stops.
    pub const EXPOSURE_RANGE: [f32; 2] = [-20.0, 20.0];

    /// Exposure in stops; 0 as long as it is not metered.
    pub fn stops(&self) -> f32 {
        self.exposure.unwrap_or(0.0)
    }

    /// Checks every range.
    ///
    /// # Errors
    /// [`CompositorError::OutOfRange`] for the first value that does not fit (NaN never fits).
    pub fn validate(&self) -> Result<(), CompositorError> {
        let [red, green, blue] = self.white_balance;
        let [least, most] = Self::EXPOSURE_RANGE;
        for (name, found, range, expected) in [
            ("exposure", self.stops(), least..=most, "-20 to 20 stops"),
            ("white_balance (red)", red, 0.0..=10.0, "0 to 10"),
            ("white_balance (green)", green, 0.0..=10.0, "0 to 10"),
            ("white_balance (blue)", blue, 0.0..=10.0, "0 to 10"),
            ("contrast", self.contrast, 0.1..=4.0, "0.1 to 4"),
            ("saturation", self.saturation, 0.0..=4.0, "0 to 4"),
            ("bloom", self.bloom, 0.0..=1.0, "0 to 1"),
        ] {
            if !range.contains(&found) {
                return Err(CompositorError::OutOfRange { name, found, expected });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_checked_and_named() {
        CompositorParameters::default().validate().unwrap();
        let bad = CompositorParameters { contrast: f32::NAN, ..Default::default() };
        assert!(bad.validate().unwrap_err().to_string().contains("contrast"));
        let bad = CompositorParameters { white_balance: [1.0, 1.0, 11.0], ..Default::default() };
        assert!(bad.validate().unwrap_err().to_string().contains("blue"));
        assert!(serde_json::from_str::<CompositorParameters>(r#"{"exposur": 1}"#).is_err());
    }
}
