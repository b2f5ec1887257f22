use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::SsfrError;

/// Which filter smooths the surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FilterChoice {
    /// Name in the [`FilterRegistry`](crate::FilterRegistry).
    pub name: String,
    /// The filter's own parameters, as its schema describes; what is left out has its default.
    pub parameters: serde_json::Map<String, serde_json::Value>,
}

impl Default for FilterChoice {
    fn default() -> Self {
        Self { name: crate::filter::DEFAULT.to_owned(), parameters: Default::default() }
    }
}

/// How the thickness image is made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ThicknessParams {
    /// Pixels per side that share one sample, 1, 2 or 4; the pipeline takes twice as many, at most 4, below full detail.
    pub scale: u32,
    /// Standard deviation of the smoothing in projected particle spacings, 0 (none) to 10.
    pub smoothing: f32,
}

impl Default for ThicknessParams {
    fn default() -> Self {
        Self { scale: 2, smoothing: 1.0 }
    }
}

impl ThicknessParams {
    /// Most pixels per side of a sample.
    pub const MAX_SCALE: u32 = 4;

    /// Half size of a splat, in samples, from which its profile is drawn. Sampled profiles depend on where between the
    /// samples the centre lies, by up to 7 % at 2, so that smaller splats are shared out between the four nearest samples.
    /// A smoothing of half a spacing or more levels what is shared out by far larger splats too, which saves most of the
    /// cost of this pass.
    pub fn profile_half_px(&self) -> f32 {
        if self.smoothing >= 0.5 { 4.0 } else { 2.0 }
    }
}

/// Parameters of the surface stage.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SsfrParams {
    /// Smoothing of the surface.
    pub filter: FilterChoice,
    /// Thickness.
    pub thickness: ThicknessParams,
}

impl SsfrParams {
    /// Checks what does not depend on the filter; the filter's parameters are checked when it is made.
    ///
    /// # Errors
    /// [`SsfrError::Parameter`] for the first number out of range.
    pub fn validate(&self) -> Result<(), SsfrError> {
        if ![1, 2, 4].contains(&self.thickness.scale) {
            return Err(SsfrError::Parameter {
                name: "thickness.scale",
                found: self.thickness.scale.to_string(),
                expected: "1, 2 or 4",
            });
        }
        check_range("thickness.smoothing", self.thickness.smoothing, 0.0..=10.0, "0 to 10")
    }
}

/// Refuses a number outside of `range` (NaN included); `expected` is the range in words.
pub(crate) fn check_range(
    name: &'static str,
    found: f32,
    range: std::ops::RangeInclusive<f32>,
    expected: &'static str,
) -> Result<(), SsfrError> {
    if range.contains(&found) {
        return Ok(());
    }
    Err(SsfrError::Parameter { name, found: found.to_string(), expected })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_out_of_range_are_named() {
        assert!(SsfrParams::default().validate().is_ok());
        let mut params = SsfrParams::default();
        params.thickness.scale = 3;
        assert!(params.validate().unwrap_err().to_string().contains("thickness.scale is 3"));
        params.thickness = ThicknessParams { scale: 1, smoothing: f32::NAN };
        assert!(params.validate().unwrap_err().to_string().contains("thickness.smoothing"));
    }

    #[test]
    fn parameters_survive_json_and_refuse_what_they_do_not_know() {
        let params = SsfrParams::default();
        let json = serde_json::to_string(&params).unwrap();
        assert_eq!(serde_json::from_str::<SsfrParams>(&json).unwrap(), params);
        assert_eq!(serde_json::from_str::<SsfrParams>("{}").unwrap(), params);
        assert!(serde_json::from_str::<SsfrParams>(r#"{"thicknes":{}}"#).is_err());
    }
}
