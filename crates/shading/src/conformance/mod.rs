//! What every lighting model keeps to, and what it promises of itself, as checks that any model runs through: those of this
//! crate in its tests, a team's own in the tests of its crate.
//!
//! ```no_run
//! use meniscus_gpu::{AdapterChoice, Gpu};
//! use meniscus_shading::{LightingRegistry, conformance};
//!
//! let gpu = Gpu::new(&AdapterChoice::default())?;
//! let registry = LightingRegistry::builtin(); // .with(MyModel::NAME, MyModel::make)
//! conformance::assert_conforms(&gpu, &registry, "fluid", &[r#"{"turbidity": 2.0}"#]);
//! # Ok::<(), meniscus_gpu::GpuError>(())
//! ```

mod checks;
mod frame;
mod run;
mod water;

use std::fmt;

use meniscus_gpu::Gpu;

use crate::{LightingChoice, LightingRegistry, ShadingError};

pub use frame::{Frame, Water, cast, pack_normal};
use run::Run;

/// One thing that is checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Check {
    /// The pass gives what the twin on the CPU gives, over waves and a drop, in both projections, with and without an
    /// attribute's colour, beside an object and without one.
    Twin,
    /// Where there is no water in the whole picture, it is the scene, bit for bit.
    NoWaterIsTheScene,
    /// Water behind an object is not seen.
    ObjectsHideWater,
    /// Alpha is 1 where there is water thicker than a spacing, the scene's where there is none, and never outside of 0 to 1.
    AlphaIsCoverage,
    /// Distances, thicknesses, normals, colours and scales that make no sense give finite radiance that is not negative.
    AbsurdInputs,
    /// The same frame gives the same bits.
    Deterministic,
    /// Pictures of one pixel, of one row, of sizes that are no multiple of anything.
    OddSizes,
    /// Parameters that the pass refuses leave it as it was, and its own parameters are taken back.
    Parameters,
    /// [`fades_with_thickness`](crate::Promises::fades_with_thickness).
    FadesWithThickness,
    /// [`makes_no_light`](crate::Promises::makes_no_light) (`algorithms.md` 14.7).
    MakesNoLight,
    /// [`reflects_by_fresnel`](crate::Promises::reflects_by_fresnel), from 0 degrees to grazing.
    Fresnel,
    /// [`absorbs_by_beer_lambert`](crate::Promises::absorbs_by_beer_lambert) (`algorithms.md` 14.8).
    BeerLambert,
    /// [`shows_attributes`](crate::Promises::shows_attributes).
    ShowsAttributes,
}

impl Check {
    /// All checks.
    pub const ALL: [Self; 13] = [
        Self::Twin,
        Self::NoWaterIsTheScene,
        Self::ObjectsHideWater,
        Self::AlphaIsCoverage,
        Self::AbsurdInputs,
        Self::Deterministic,
        Self::OddSizes,
        Self::Parameters,
        Self::FadesWithThickness,
        Self::MakesNoLight,
        Self::Fresnel,
        Self::BeerLambert,
        Self::ShowsAttributes,
    ];

    fn run(self, run: &Run<'_>) -> Result<(), String> {
        match self {
            Self::Twin => checks::twin(run),
            Self::NoWaterIsTheScene => checks::no_water_is_the_scene(run),
            Self::ObjectsHideWater => checks::objects_hide_water(run),
            Self::AlphaIsCoverage => checks::alpha_is_coverage(run),
            Self::AbsurdInputs => checks::absurd_inputs(run),
            Self::Deterministic => checks::deterministic(run),
            Self::OddSizes => checks::odd_sizes(run),
            Self::Parameters => checks::parameters(run),
            Self::FadesWithThickness => checks::fades_with_thickness(run),
            Self::MakesNoLight => checks::makes_no_light(run),
            Self::Fresnel => checks::fresnel(run),
            Self::BeerLambert => checks::beer_lambert(run),
            Self::ShowsAttributes => checks::shows_attributes(run),
        }
    }
}

/// A check that a model failed.
#[derive(Clone, Debug, PartialEq)]
pub struct Violation {
    /// Which.
    pub check: Check,
    /// What the model did, and what was expected.
    pub message: String,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}: {}", self.check, self.message)
    }
}

/// Runs the chosen model of `registry` through every check; what it failed.
///
/// # Errors
/// There is no such model, its parameters do not fit, or it does not compile.
pub fn violations(
    gpu: &Gpu,
    registry: &LightingRegistry,
    choice: &LightingChoice,
) -> Result<Vec<Violation>, ShadingError> {
    let run = Run::new(gpu, registry, choice)?;
    let failed = |check: Check| check.run(&run).err().map(|message| Violation { check, message });
    Ok(Check::ALL.into_iter().filter_map(failed).collect())
}

/// Runs the model that `registry` calls `name` through every check, with its default parameters and with each of
/// `parameters`, JSON objects as the model's schema describes them.
///
/// # Panics
/// When there is no such model, parameters do not fit, or a check fails; the message lists all that failed.
pub fn assert_conforms(gpu: &Gpu, registry: &LightingRegistry, name: &str, parameters: &[&str]) {
    let mut failed = Vec::new();
    for parameters in ["{}"].iter().chain(parameters) {
        let choice = LightingChoice {
            name: name.to_owned(),
            parameters: serde_json::from_str(parameters)
                .unwrap_or_else(|e| panic!("parameters of {name}: {parameters} is no JSON object: {e}")),
        };
        let found = violations(gpu, registry, &choice).unwrap_or_else(|e| panic!("{e}"));
        failed.extend(found.into_iter().map(|violation| format!("{name} {parameters} {violation}")));
    }
    assert!(failed.is_empty(), "{} checks failed:\n{}", failed.len(), failed.join("\n"));
}
