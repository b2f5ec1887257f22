//! Surface filters: what they are given, what they promise, and how they are found by name.

mod adaptive;
mod bilateral;
mod curvature_flow;
mod gaussian;
mod narrow_range;
mod narrow_range_paper;
mod none;
mod properties;
mod registry;
mod smoothing;

use meniscus_gpu::role::{EffectiveRadius, EyeDistance, Scratch};
use meniscus_gpu::{Binding, Buffer, CameraUniform, Dispatch, Gpu, Image, Recorder, Shader, covered, shader};

pub(crate) use adaptive::TILE;
pub use adaptive::{Adaptive, AdaptiveParams};
pub use bilateral::{Bilateral, BilateralParams};
pub use curvature_flow::{CurvatureFlow, CurvatureFlowParams};
pub use gaussian::{Gaussian, GaussianParams};
pub use narrow_range::{NarrowRange, NarrowRangeParams};
pub use narrow_range_paper::{NarrowRangePaper, NarrowRangePaperParams};
pub use none::NoFilter;
pub use properties::Properties;
pub use registry::{DEFAULT, FilterEntry, FilterRegistry};
pub(crate) use smoothing::{LinePass, Rule, Width};

/// Counter of the samples that a filter reads besides the pixel's own, for the `counts` of its pipelines. A filter whose
/// passes do not count has no figure in reports.
pub const TAPS: &str = "filter_taps";

/// Includes for passes of filters, besides the common ones: `meniscus::covered`, the list of pixels to work on, and
/// `meniscus::key`, on which planes are affine (`shaders/ssfr/`).
pub const INCLUDES: &[Shader] = &[shader!(include "ssfr/key")];

/// Images of one run of a filter, all of one size.
#[derive(Clone, Copy, Debug)]
pub struct FilterImages<'a> {
    /// Distance to smooth.
    pub source: &'a Image<EyeDistance>,
    /// Drawn radius of the particle visible in a pixel.
    pub radius: &'a Image<EffectiveRadius>,
    /// Where the smoothed distance goes: [`NO_SURFACE`](meniscus_gpu::role::NO_SURFACE) exactly where `source` has it. It
    /// is there already, so that only the covered pixels need to be written.
    pub target: &'a Image<EyeDistance>,
    /// The pixels that show fluid, as `meniscus::covered::CoveredPixels` of `shaders/common/covered.inc.wgsl`: their number,
    /// then x + 65536 y for each, in no particular order.
    pub covered: &'a Buffer<Scratch>,
    /// Room for intermediate results; contents do not matter, before or after.
    pub scratch: [&'a Image<Scratch>; 2],
    /// Distance of neighbouring particles per drawn radius: the bumps to remove are `radius * spacing_per_radius` long.
    pub spacing_per_radius: f32,
}

impl FilterImages<'_> {
    /// Dispatch of a pass over [`Self::covered`] with workgroups of 64, each invocation of which walks on through the list:
    /// only the GPU knows how long that is. 65,536 invocations keep every GPU busy and cost a software driver little when
    /// there is less to do.
    pub fn over_covered(&self) -> Dispatch {
        covered::dispatch(self.source.size())
    }
}

/// The same on the host, for [`SurfaceFilter::filter_on_cpu`]; row by row from the top left.
#[derive(Clone, Copy, Debug)]
pub struct HostSurface<'a> {
    /// Distance to smooth.
    pub distance: &'a [f32],
    /// Drawn radius of the particle visible in a pixel.
    pub radius: &'a [f32],
    /// Distance of neighbouring particles per drawn radius.
    pub spacing_per_radius: f32,
}

/// A filter that smooths the distance image of a surface of splats.
///
/// Made once with its parameters; [`Self::record`] runs every frame, allocates nothing and cannot fail. What every filter
/// keeps to is what [`conformance`](crate::conformance) checks.
pub trait SurfaceFilter: Send + Sync {
    /// Name as registered.
    fn name(&self) -> &'static str;

    /// Records the passes that smooth `images.source` into `images.target`. `camera` is a [`CameraUniform`] for pictures
    /// of that size.
    fn record(&self, recorder: &mut Recorder, gpu: &Gpu, camera: &Binding, images: &FilterImages<'_>);

    /// The same on the CPU, after the formulas: what the passes are tested against.
    fn filter_on_cpu(&self, camera: &CameraUniform, surface: &HostSurface<'_>) -> Vec<f32>;

    /// What the filter promises beyond what every filter keeps to; the [`conformance`](crate::conformance) suite holds it
    /// to that. Nothing unless it says so.
    fn properties(&self) -> Properties {
        Properties::default()
    }
}
