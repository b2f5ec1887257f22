use meniscus_gpu::Gpu;
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
    /// Pixels per side that share one sample, 1, 2 or 4; the pipeline takes [`Self::coarsened`] ones where that cannot be seen.
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

    /// With twice as many pixels per sample, at most [`Self::MAX_SCALE`], where particles are `spacing_px` apart and that still is
    /// `samples` of them. Less than 0.75 would show as stripes, which the smoothing over a spacing leaves; from 2 on no
    /// difference is left to be seen.
    pub fn coarsened(&self, spacing_px: f32, samples: f32) -> Self {
        let scale = 2 * self.scale;
        let is_fine = scale <= Self::MAX_SCALE && spacing_px >= samples * scale as f32;
        Self { scale: if is_fine { scale } else { self.scale }, ..self.clone() }
    }

    /// Half size of a splat, in samples, from which its profile is drawn, where particles are `spacing_per_radius` drawn radii
    /// apart. Sampled profiles depend on where between the samples the centre lies, by up to 7 % at 2, so that smaller splats
    /// are shared out between the four nearest samples. A smoothing over half a drawn radius or more levels what is shared
    /// out by far larger splats too, as long as it looks at every sample: which saves most of the cost of this pass.
    pub fn profile_half_px(&self, spacing_per_radius: f32) -> f32 {
        let sigma_radii = self.smoothing * spacing_per_radius;
        if sigma_radii >= 0.5 { (MOST_EVEN_SIGMA / sigma_radii).max(2.0) } else { 2.0 }
    }

    /// Whether the smoothing has a tap for each sample all over a picture of spheres of radii up to `most_radius_px`.
    pub(crate) fn is_even(&self, spacing_per_radius: f32, most_radius_px: f32) -> bool {
        self.smoothing * spacing_per_radius * most_radius_px / self.scale as f32 <= MOST_EVEN_SIGMA
    }
}

/// Standard deviation in samples up to which the smoothing (`shaders/ssfr/thickness_smooth.wgsl`) has a tap for each: 24 of
/// them are 2.5 standard deviations.
const MOST_EVEN_SIGMA: f32 = 24.0 / 2.5;

/// How splats are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SplatParams {
    /// Half size in pixels, at least 0, of what is drawn first (root of the mean square) from which on it is drawn as triangles, one for
    /// each splat, and not by compute passes. The picture is the same. `None` for what suits the adapter: [`Self::TRIANGLES_FROM_PX`] on
    /// software drivers, never on GPUs: an NVIDIA H100 draws no size faster so, and of others nothing is known
    /// (`cargo bench -p bench-raster` tells).
    pub triangles_from_px: Option<f32>,
}

impl SplatParams {
    /// For software drivers: between 10 px, where triangles take a tenth to a fifth longer, and 14 px, where they take as much less
    /// (`cargo bench -p bench-raster`, benches/RESULTS.md).
    pub const TRIANGLES_FROM_PX: f32 = 12.0;

    /// What holds on the adapter of `gpu`; `None` for never.
    pub(crate) fn triangles_from_px_on(&self, gpu: &Gpu) -> Option<f32> {
        let of_adapter = gpu.summary().is_software().then_some(Self::TRIANGLES_FROM_PX);
        self.triangles_from_px.or(of_adapter)
    }
}

/// What particles of the shell are drawn as.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Anisotropy {
    /// Spheres.
    #[default]
    None,
    /// Ellipsoids whose half-axes go with the variances of the neighbourhood (Yu and Turk 2013), normalised to the volume of the
    /// particle's sphere, so that the bulk is made of spheres whatever the unit.
    YuTurk,
    /// Ellipsoids whose half-axes go with its standard deviations (\[Z\] 2.2), whatever the radius of the spheres.
    Zju,
}

/// Ellipsoids in place of the spheres that may be seen, each after how its neighbours lie (`main-renderer.md` 5.6). They leave less to
/// smooth: narrow-range with a sigma of 0.8 in one iteration does, which the pipeline takes at full detail where nothing is said of it.
/// Shapes are found anew in every frame of particles, which takes software drivers longer than a picture where there are many.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AnisotropyParams {
    /// Which ellipsoids; `None` for what [`Self::resolved`] says, and spheres to a stage that is not told how many particles there are.
    pub form: Option<Anisotropy>,
    /// Most particles of a frame that are drawn as ellipsoids where `form` is open. So few are large enough in a picture for bumps of
    /// spheres to show along outlines; of more, shapes may take longer than bumps of a few pixels are worth.
    /// `None` for what suits the adapter: [`Self::AUTO_PARTICLES`], or [`Self::AUTO_PARTICLES_DISCRETE`] where that is known.
    pub auto_particles: Option<usize>,
    /// Reach of the neighbourhood in spacings, 1.5 to 4: with 2, a particle in a flat surface has too few neighbours to be flat.
    pub support: f32,
    /// How far ellipsoids are from spheres, 0 (spheres) to 1.
    pub strength: f32,
    /// Largest ratio of the variances that make two axes of an ellipsoid, 1 to 8.
    pub ratio: f32,
    /// How far centres are moved towards the middle of their neighbours, 0 (not at all) to 1.
    pub smoothing: f32,
    /// Factor c on the axes of `zju`, 1 to 2.
    pub zju_scale: f32,
}

impl Default for AnisotropyParams {
    fn default() -> Self {
        Self {
            form: None,
            auto_particles: None,
            support: 2.5,
            strength: 1.0,
            ratio: 4.0,
            smoothing: 0.9,
            zju_scale: 1.2,
        }
    }
}

impl AnisotropyParams {
    /// Most that half-axes of `zju` may be of the drawn radius.
    pub(crate) const MAX_ZJU_AXIS: f32 = 2.5;
    /// Farthest that a centre is moved, in spacings.
    pub(crate) const MAX_SHIFT_SPACINGS: f32 = 0.5;

    /// For software drivers, which find shapes of so many in half a second, and where nothing is known of the adapter.
    pub const AUTO_PARTICLES: usize = 400_000;

    /// For discrete GPUs: an NVIDIA H100 finds the shapes of 1.13 million particles in 1.4 ms (benches/RESULTS.md).
    pub const AUTO_PARTICLES_DISCRETE: usize = 20_000_000;

    /// With the form, if it is open, decided for frames of up to `particles` particles.
    pub fn resolved(&self, particles: usize) -> Self {
        let few = if particles <= self.most_ellipsoids() { Anisotropy::YuTurk } else { Anisotropy::None };
        Self { form: Some(self.form.unwrap_or(few)), ..*self }
    }

    /// Most particles of a frame that are drawn as ellipsoids where the form is open.
    pub fn most_ellipsoids(&self) -> usize {
        self.auto_particles.unwrap_or(Self::AUTO_PARTICLES)
    }

    /// What particles are drawn as.
    pub(crate) fn form(&self) -> Anisotropy {
        self.form.unwrap_or_default()
    }

    /// Whether anything is drawn but spheres.
    pub fn is_on(&self) -> bool {
        self.form() != Anisotropy::None
    }

    /// Most that a half-axis may be of the drawn radius; 1 for spheres.
    pub(crate) fn longest_axis(&self) -> f32 {
        let longest = match self.form() {
            Anisotropy::None => return 1.0,
            // One axis as long, two as short as may be, of volume 1.
            Anisotropy::YuTurk => self.ratio.powf(2.0 / 3.0),
            Anisotropy::Zju => Self::MAX_ZJU_AXIS,
        };
        // Axes are stored in steps of a ten-thousandth.
        1.001 * longest
    }

    /// How far from a particle of radius 1, which is `spacing_per_radius` apart from its neighbours, what is drawn for it may reach;
    /// 1 for spheres.
    pub fn reach_radii(&self, spacing_per_radius: f32) -> f32 {
        let shift = if self.is_on() { Self::MAX_SHIFT_SPACINGS * spacing_per_radius } else { 0.0 };
        self.longest_axis() + shift
    }

    fn validate(&self) -> Result<(), SsfrError> {
        check_range("anisotropy.support", self.support, 1.5..=4.0, "1.5 to 4")?;
        check_range("anisotropy.strength", self.strength, 0.0..=1.0, "0 to 1")?;
        check_range("anisotropy.ratio", self.ratio, 1.0..=8.0, "1 to 8")?;
        check_range("anisotropy.smoothing", self.smoothing, 0.0..=1.0, "0 to 1")?;
        check_range("anisotropy.zju_scale", self.zju_scale, 1.0..=2.0, "1 to 2")
    }
}

/// Parameters of the surface stage.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SsfrParams {
    /// Drawing of splats.
    pub splats: SplatParams,
    /// Smoothing of the surface.
    pub filter: FilterChoice,
    /// Thickness.
    pub thickness: ThicknessParams,
    /// Shapes of particles.
    pub anisotropy: AnisotropyParams,
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
        check_range("thickness.smoothing", self.thickness.smoothing, 0.0..=10.0, "0 to 10")?;
        if let Some(from_px) = self.splats.triangles_from_px {
            check_range("splats.triangles_from_px", from_px, 0.0..=f32::MAX, "at least 0")?;
        }
        self.anisotropy.validate()
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
    fn samples_are_coarsened_no_further_than_particles_are_apart() {
        let params = |scale| ThicknessParams { scale, smoothing: 1.0 };
        let scale = |scale, spacing_px| params(scale).coarsened(spacing_px, 0.75).scale;
        assert_eq!([7.9, 8.0].map(|spacing_px| params(2).coarsened(spacing_px, 2.0).scale), [2, 4]);
        assert_eq!([scale(2, 2.9), scale(2, 3.0), scale(2, 100.0)], [2, 4, 4]);
        assert_eq!([scale(1, 1.4), scale(1, 1.5), scale(4, 100.0)], [1, 2, 4]);
        assert_eq!([scale(2, f32::NAN), scale(2, f32::INFINITY)], [2, 4]);
    }

    #[test]
    fn few_particles_are_ellipsoids_unless_something_else_is_asked_for() {
        let limit = AnisotropyParams::AUTO_PARTICLES;
        let form =
            |form, particles| AnisotropyParams { form, ..Default::default() }.resolved(particles).form();
        assert_eq!([form(None, 0), form(None, limit)], [Anisotropy::YuTurk; 2]);
        assert_eq!(form(None, limit + 1), Anisotropy::None);
        for asked in [Anisotropy::None, Anisotropy::YuTurk, Anisotropy::Zju] {
            assert_eq!([form(Some(asked), 1), form(Some(asked), usize::MAX)], [asked; 2]);
        }
    }

    #[test]
    fn numbers_out_of_range_are_named() {
        assert!(SsfrParams::default().validate().is_ok());
        let mut params = SsfrParams::default();
        params.thickness.scale = 3;
        assert!(params.validate().unwrap_err().to_string().contains("thickness.scale is 3"));
        params.thickness = ThicknessParams { scale: 1, smoothing: f32::NAN };
        assert!(params.validate().unwrap_err().to_string().contains("thickness.smoothing"));
        params = SsfrParams::default();
        params.splats.triangles_from_px = Some(-1.0);
        assert!(params.validate().unwrap_err().to_string().contains("splats.triangles_from_px is -1"));
        params = SsfrParams::default();
        params.anisotropy.ratio = 0.5;
        assert!(params.validate().unwrap_err().to_string().contains("anisotropy.ratio is 0.5"));
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
