//! Water and other sets coloured by an attribute.

use std::collections::BTreeSet;

use meniscus_color::{ColorError, ColorMap, ColorScale, Quantity, range_of};
use meniscus_core::{Attribute, Choice, FrameRequest, Look, ParticleFrame, SetFrame};
use meniscus_gpu::role::{AttributeValues, SurfaceColor};
use meniscus_gpu::{Binding, Buffer, Gpu, GpuError, Recorder, Texture};
use meniscus_lod::ChunkedSet;
use meniscus_ssfr::{ColoredSet, Coloring, NO_VALUE, ScaleUniform, SurfaceImages};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::PipelineError;

/// Colours of the table that the GPU interpolates in.
const TABLE: u32 = 256;
/// Values of a frame that the automatic range is found from, at least.
const SAMPLED: usize = 1 << 18;

/// Which attribute colours the particles, and how.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ColorSettings {
    /// Name of the attribute; of one with several numbers the magnitude, or a component as `velocity:x`. None: everything
    /// has its own colour.
    pub by: Option<String>,
    /// Colour map.
    pub map: String,
    /// Value at the start of the map; left out: found in the series.
    pub min: Option<f64>,
    /// Value at the end of the map; left out: found in the series.
    pub max: Option<f64>,
    /// Logarithmic.
    pub log: bool,
}

impl Default for ColorSettings {
    fn default() -> Self {
        Self { by: None, map: ColorMap::default().to_string(), min: None, max: None, log: false }
    }
}

impl ColorSettings {
    /// What colours the particles.
    pub(crate) fn quantity(&self) -> Result<Option<Quantity>, ColorError> {
        self.by.as_deref().map(str::parse).transpose()
    }

    /// Checks names and limits.
    pub(crate) fn validate(&self) -> Result<(), ColorError> {
        let map = self.map.parse()?;
        let Some(quantity) = self.quantity()? else { return Ok(()) };
        // What is left out is chosen so that it fits.
        let [min, max] = match (self.min, self.max) {
            (Some(min), Some(max)) => [min, max],
            (Some(only), None) | (None, Some(only)) => [only; 2],
            (None, None) => return Ok(()),
        };
        ColorScale::new(quantity, map, [min, max], self.log).map(drop)
    }

    /// What has to be read besides positions.
    pub(crate) fn request(&self) -> Result<FrameRequest, ColorError> {
        Ok(FrameRequest {
            attributes: self.quantity()?.map(|quantity| quantity.attribute).into_iter().collect(),
        })
    }

    /// The scale for a series with the given values ([`sample`]), and what was chosen; `None` where nothing is coloured.
    pub(crate) fn scale(
        &self,
        mut values: Vec<f32>,
    ) -> Result<Option<(ColorScale, Option<Choice>)>, PipelineError> {
        let Some(quantity) = self.quantity()? else { return Ok(None) };
        let found = range_of(&mut values, self.log);
        let ([min, max], is_chosen) = match (self.min, self.max, found) {
            (Some(min), Some(max), _) => ([min, max], false),
            // A limit that is given holds, whatever lies beyond it.
            (min, max, Some([lowest, highest])) => {
                let max = max.unwrap_or(min.map_or(highest, |min| highest.max(min)));
                ([min.unwrap_or(lowest.min(max)), max], true)
            }
            (_, _, None) => {
                let of = if self.log { "number above 0" } else { "finite number" };
                return Err(PipelineError::NothingToColor { quantity: quantity.to_string(), of });
            }
        };
        let scale = ColorScale::new(quantity, self.map.parse()?, [min, max], self.log)?;
        let choice = is_chosen.then(|| Choice {
            what: "colours".into(),
            value: format!("{} from {} to {} ({})", scale.quantity, short(min), short(max), scale.map),
            reason: "all but a thousandth at either end of the first, middle and last frame".into(),
            flag: "--color-range MIN,MAX".into(),
        });
        Ok(Some((scale, choice)))
    }
}

/// To six digits.
fn short(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// Values of a frame's drawn sets for [`ColorSettings::scale`], spread evenly over each.
pub(crate) fn sample(frame: &SetFrame, quantity: &Quantity) -> Vec<f32> {
    let drawn = frame.sets.iter().filter(|set| set.look != Look::Hidden);
    let values = |particles: &ParticleFrame| -> Vec<f32> {
        let Some(attribute) = attribute_of(particles, quantity) else { return Vec::new() };
        let step = (particles.len() / SAMPLED).max(1);
        attribute
            .values
            .chunks_exact(attribute.components.max(1))
            .step_by(step)
            .map(|v| quantity.of(v))
            .collect()
    };
    drawn.flat_map(|set| values(&set.particles)).collect()
}

/// Names of a frame's drawn sets that do not have the attribute: files beside the water need not.
pub(crate) fn without_values<'a>(frame: &'a SetFrame, quantity: &Quantity) -> impl Iterator<Item = &'a str> {
    let drawn = frame.sets.iter().filter(|set| set.look != Look::Hidden && !set.particles.is_empty());
    drawn.filter(|set| attribute_of(&set.particles, quantity).is_none()).map(|set| set.name.as_str())
}

/// Says that the sets `names` keep their own colour; `None` where there are none.
pub(crate) fn uncolored(names: &BTreeSet<String>, quantity: &Quantity) -> Option<Choice> {
    let (one, reason) = match names.len() {
        0 => return None,
        1 => ("set", "its files have"),
        _ => ("sets", "their files have"),
    };
    Some(Choice {
        what: format!("colours of {one} {}", names.iter().map(String::as_str).collect::<Vec<_>>().join(", ")),
        value: "as without --color-by".into(),
        reason: format!("{reason} no attribute \"{}\"", quantity.attribute),
        flag: "--color-by NAME, one that all have".into(),
    })
}

fn attribute_of<'a>(particles: &'a ParticleFrame, quantity: &Quantity) -> Option<&'a Attribute> {
    particles.attributes.iter().find(|attribute| attribute.name == quantity.attribute)
}

/// The quantity of every particle in the order of `chunked`, [`NO_VALUE`] for what is no number; empty where the set does not have
/// the attribute.
pub(crate) fn values_of(particles: &ParticleFrame, chunked: &ChunkedSet, quantity: &Quantity) -> Vec<f32> {
    let Some(attribute) = attribute_of(particles, quantity) else { return Vec::new() };
    let components = attribute.components.max(1);
    let value = |&index: &u32| {
        let first = index as usize * components;
        let value = quantity.of(attribute.values.get(first..first + components).unwrap_or_default());
        if value.is_finite() { value } else { NO_VALUE }
    };
    chunked.attribute_order.iter().map(value).collect()
}

/// The values of a set on the GPU.
#[derive(Debug, Default)]
pub(crate) struct GpuValues {
    /// One per page of the set; none where it has no values.
    pub(crate) pages: Vec<Buffer<AttributeValues>>,
    serial: Option<u64>,
}

impl GpuValues {
    /// Uploads `values` of `set` unless they are there already.
    pub(crate) fn upload(&mut self, gpu: &Gpu, set: &ChunkedSet, values: &[f32]) -> Result<(), GpuError> {
        if self.serial == Some(set.serial()) {
            return Ok(());
        }
        self.serial = None;
        let pages = if values.is_empty() { 0 } else { set.pages().len() };
        self.pages.truncate(pages);
        for page in 0..pages {
            let values = &values[set.page_slots(page)];
            match self.pages.get_mut(page) {
                Some(buffer) => buffer.write(gpu, values)?,
                None => self.pages.push(Buffer::from_slice(gpu, values)?),
            }
        }
        self.serial = Some(set.serial());
        Ok(())
    }
}

/// Colours surfaces on one scale, one at a time; made for one size of pictures.
#[derive(Debug)]
pub(crate) struct SurfaceColors {
    coloring: Coloring,
    scale: ColorScale,
    /// Colours of the surface that was recorded last.
    pub(crate) image: Texture<SurfaceColor>,
}

impl SurfaceColors {
    pub(crate) fn new(gpu: &Gpu, size: [u32; 2], scale: &ColorScale) -> Result<Self, GpuError> {
        let color = |i| scale.map.linear(f64::from(i) / f64::from(TABLE - 1)).extend(1.0).to_array();
        let table: Vec<[f32; 4]> = (0..TABLE).map(color).collect();
        Ok(Self {
            coloring: Coloring::new(gpu, size, &table)?,
            scale: scale.clone(),
            image: Texture::new(gpu, size)?,
        })
    }

    /// Whether these colours serve pictures of `size` on `scale`.
    pub(crate) fn fit(&self, size: [u32; 2], scale: &ColorScale) -> bool {
        self.image.size() == size && self.scale == *scale
    }

    pub(crate) fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        camera: &Binding,
        sets: &[ColoredSet<'_>],
        images: &SurfaceImages,
    ) {
        let [offset, factor] = self.scale.offset_and_factor();
        let scale = ScaleUniform {
            offset: offset as f32,
            // Of a scale that is shorter than numbers on the GPU can be.
            factor: factor.min(f64::from(f32::MAX)) as f32,
            is_log: self.scale.log.into(),
        };
        self.coloring.record(recorder, gpu, camera, sets, &scale, images, &self.image);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(min: Option<f64>, max: Option<f64>, log: bool) -> ColorSettings {
        ColorSettings { by: Some("p".into()), min, max, log, ..Default::default() }
    }

    #[test]
    fn limits_are_found_given_or_both() {
        let scale = |min, max, values: &[f32]| {
            let (scale, choice) = settings(min, max, false).scale(values.to_vec()).unwrap().unwrap();
            ([scale.min, scale.max], choice.is_some())
        };
        assert_eq!(scale(None, None, &[3.0, f32::NAN, 1.0, 2.0]), ([1.0, 3.0], true));
        assert_eq!(scale(Some(-5.0), None, &[3.0, 1.0]), ([-5.0, 3.0], true));
        assert_eq!(scale(Some(-5.0), Some(9.0), &[]), ([-5.0, 9.0], false));
        // All is beyond the limit that was given: it holds, and everything has the colour of that end.
        assert_eq!(scale(Some(5.0), None, &[3.0, 1.0]), ([5.0, 5.0], true));
        assert_eq!(scale(None, Some(-5.0), &[3.0, 1.0]), ([-5.0, -5.0], true));
        assert!(ColorSettings::default().scale(vec![1.0]).unwrap().is_none());
    }

    #[test]
    fn what_cannot_be_coloured_is_said() {
        let error = settings(None, None, true).scale(vec![-1.0, 0.0]).unwrap_err().to_string();
        assert!(error.contains("`p`") && error.contains("above 0"), "{error}");
        assert!(settings(Some(2.0), Some(1.0), false).validate().is_err());
        assert!(settings(Some(-2.0), None, true).validate().is_err());
        assert!(ColorSettings { map: "mauve".into(), ..Default::default() }.validate().is_err());
        assert!(settings(Some(1.0), None, true).validate().is_ok());
    }
}
