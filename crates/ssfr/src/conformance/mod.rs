//! What every surface filter keeps to, and what it declares of itself, as checks that any filter runs through: those of this
//! crate in its tests, a team's own in the tests of its crate.
//!
//! ```no_run
//! use meniscus_gpu::{AdapterChoice, Gpu};
//! use meniscus_ssfr::{FilterRegistry, conformance};
//!
//! let gpu = Gpu::new(&AdapterChoice::default())?;
//! let registry = FilterRegistry::builtin(); // .with_filter(MyFilter::entry())
//! conformance::assert_conforms(&gpu, &registry, "narrow-range", &[r#"{"sigma": 2.0}"#]);
//! # Ok::<(), meniscus_gpu::GpuError>(())
//! ```

mod checks;
mod pictures;
mod run;

use std::fmt;

use meniscus_gpu::Gpu;

use crate::{FilterChoice, FilterRegistry, SurfaceFilter};

/// One thing that is checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Check {
    /// The passes give what the twin on the CPU gives, in pictures of several kinds and sizes.
    Twin,
    /// Pixels without a surface are left as they are, and a picture without any stays empty.
    EmptyStaysEmpty,
    /// Only pixels with a surface cost samples, for filters that count them
    /// ([`TAPS`](crate::filter::TAPS)).
    OnlyFluidCosts,
    /// Where the radius is 0 nothing changes.
    ZeroRadiusIsIdentity,
    /// A plane that faces the viewer stays what it is, up to the picture's border.
    ConstantPlanes,
    /// The same for planes of 60 degrees, in the projections for which the filter declares it.
    TiltedPlanes,
    /// Planes stay what they are up to ragged silhouettes, for filters that declare it.
    Silhouettes,
    /// Noise in the distances does not grow: whatever is repeated in the filter is stable.
    NoiseDoesNotGrow,
    /// A mirrored picture gives the mirrored result.
    Mirror,
    /// All lengths times a factor give the result times that factor.
    Scaling,
    /// What is no distance (NaN, infinite, negative, zero) is as good as no surface, and a radius that is none as good as 0.
    NanNeverSpreads,
    /// The picture's borders let nothing in from the other side or from outside.
    Borders,
    /// Pictures of one pixel, of one row, of 4097 columns.
    TinyAndHuge,
    /// A smoothly growing radius changes the picture smoothly: no rings where a kernel takes one more tap.
    NoRings,
    /// Kernels of a hundred pixels smooth as those of ten do, for filters that declare a sigma of 0.8 to 3 spacings, and leave no
    /// pattern of their taps, for filters that declare that.
    CloseUps,
    /// The response to an impulse of a hundredth of the range has the standard deviation that the filter declares, within
    /// 5 % (`algorithms.md` 14.4).
    NominalSigma,
    /// Surfaces further apart than the range that the filter declares do not mix.
    Range,
}

impl Check {
    /// All of them.
    pub const ALL: [Self; 17] = [
        Self::Twin,
        Self::EmptyStaysEmpty,
        Self::OnlyFluidCosts,
        Self::ZeroRadiusIsIdentity,
        Self::ConstantPlanes,
        Self::TiltedPlanes,
        Self::Silhouettes,
        Self::NoiseDoesNotGrow,
        Self::Mirror,
        Self::Scaling,
        Self::NanNeverSpreads,
        Self::Borders,
        Self::TinyAndHuge,
        Self::NoRings,
        Self::CloseUps,
        Self::NominalSigma,
        Self::Range,
    ];

    /// Holds `filter` to this check. What the filter does not declare is not asked of it.
    ///
    /// # Errors
    /// What the filter did and what was expected, with the place.
    pub fn run(self, gpu: &Gpu, filter: &dyn SurfaceFilter) -> Result<(), String> {
        let run = run::Run { gpu, filter };
        match self {
            Self::Twin => checks::twin(&run),
            Self::EmptyStaysEmpty => checks::empty_stays_empty(&run),
            Self::OnlyFluidCosts => checks::only_fluid_costs(&run),
            Self::ZeroRadiusIsIdentity => checks::zero_radius_is_identity(&run),
            Self::ConstantPlanes => checks::constant_planes(&run),
            Self::TiltedPlanes => checks::tilted_planes(&run),
            Self::Silhouettes => checks::silhouettes(&run),
            Self::NoiseDoesNotGrow => checks::noise_does_not_grow(&run),
            Self::Mirror => checks::mirror(&run),
            Self::Scaling => checks::scaling(&run),
            Self::NanNeverSpreads => checks::nan_never_spreads(&run),
            Self::Borders => checks::borders(&run),
            Self::TinyAndHuge => checks::tiny_and_huge(&run),
            Self::NoRings => checks::no_rings(&run),
            Self::CloseUps => checks::close_ups(&run),
            Self::NominalSigma => checks::nominal_sigma(&run),
            Self::Range => checks::range(&run),
        }
    }
}

/// A check that a filter failed.
#[derive(Clone, Debug, PartialEq)]
pub struct Violation {
    /// Which.
    pub check: Check,
    /// What the filter did, and what was expected.
    pub message: String,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}: {}", self.check, self.message)
    }
}

/// Runs `filter` through every check; what it failed.
pub fn violations(gpu: &Gpu, filter: &dyn SurfaceFilter) -> Vec<Violation> {
    let failed = |check: Check| check.run(gpu, filter).err().map(|message| Violation { check, message });
    Check::ALL.into_iter().filter_map(failed).collect()
}

/// Runs the filter that `registry` calls `name` through every check, with its default parameters and with each of
/// `parameters`, JSON objects as the filter's schema describes them.
///
/// # Panics
/// When there is no such filter, parameters do not fit, or a check fails; the message lists all that failed.
pub fn assert_conforms(gpu: &Gpu, registry: &FilterRegistry, name: &str, parameters: &[&str]) {
    let mut failed = Vec::new();
    for parameters in ["{}"].iter().chain(parameters) {
        let choice = FilterChoice {
            name: name.to_owned(),
            parameters: serde_json::from_str(parameters)
                .unwrap_or_else(|e| panic!("parameters of {name}: {parameters} is no JSON object: {e}")),
        };
        let filter = registry.create(gpu, &choice).unwrap_or_else(|e| panic!("{e}"));
        failed.extend(
            violations(gpu, &*filter).into_iter().map(|violation| format!("{name} {parameters} {violation}")),
        );
    }
    assert!(failed.is_empty(), "{} checks failed:\n{}", failed.len(), failed.join("\n"));
}
