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

use meniscus_gpu::role::{EyeDistance, FilterStep, FrontSphere, Scratch};
use meniscus_gpu::{
    Binding, Buffer, CameraUniform, Covered, Dispatch, Gpu, Recorder, Shader, Texture, shader,
};

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

/// Counter of the samples that a filter weighs besides the pixel's own, for the `counts` of its pipelines. A filter whose
/// passes do not count has no figure in reports.
pub const TAPS: &str = "filter_taps";

/// Includes for passes of filters, besides the common ones: `meniscus::covered`, the list of pixels to work on, and
/// `meniscus::key`, on which planes are affine (`shaders/ssfr/`).
pub const INCLUDES: &[Shader] = &[shader!(include "ssfr/key")];

/// Images of one run of a filter, all of one size.
#[derive(Clone, Copy, Debug)]
pub struct FilterImages<'a> {
    /// Distance to smooth, and drawn radius of the particle visible in a pixel.
    pub front: &'a Texture<FrontSphere>,
    /// Where the smoothed distance goes: [`NO_SURFACE`](meniscus_gpu::role::NO_SURFACE) exactly where `front` has it. It
    /// is there already, so that only the covered pixels need to be written.
    pub target: &'a Texture<EyeDistance>,
    /// The pixels that show fluid; their list is `meniscus::covered::CoveredPixels` of `shaders/common/covered.inc.wgsl`: their number,
    /// then x + 65536 y for each, in no particular order.
    pub covered: &'a Covered,
    /// Room for what a pass leaves for the next one; contents do not matter, before or after. Software drivers read textures
    /// several times faster than buffers.
    pub steps: [&'a Texture<FilterStep>; 2],
    /// The same in buffers of [`scratch_len`] numbers, for what passes add up.
    pub scratch: [&'a Buffer<Scratch>; 2],
    /// Distance of neighbouring particles per drawn radius: the bumps to remove are `radius * spacing_per_radius` long.
    pub spacing_per_radius: f32,
    /// Pixels that the radius of no sphere exceeds at its point nearest to the eye; infinite where that is not known.
    pub most_radius_px: f32,
    /// Pixels that radii have in the root of the mean square; may be anything, and decides about speed only.
    pub typical_radius_px: f32,
}

/// Numbers in a scratch buffer of a filter for pictures of `size` pixels: one a pixel, and room for two.
pub fn scratch_len(size: [u32; 2]) -> usize {
    (size[0] as usize * size[1] as usize).max(2)
}

impl FilterImages<'_> {
    /// Dispatch of a pass over [`Self::covered`], with workgroups of 64.
    pub fn over_covered(&self) -> Dispatch {
        self.covered.dispatch()
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
