//! Surface filters: what they are given, what they promise, and how they are found by name.

mod narrow_range;
mod none;
mod registry;

use meniscus_gpu::role::{EffectiveRadius, EyeDistance, Scratch};
use meniscus_gpu::{Binding, Buffer, CameraUniform, Gpu, Image, Recorder};

pub(crate) use narrow_range::directions;
pub use narrow_range::{NarrowRange, NarrowRangeParams, NarrowRangeVariant};
pub use none::NoFilter;
pub use registry::{DEFAULT, FilterEntry, FilterRegistry};

/// Counter of the samples that a filter reads besides the pixel's own, for the `counts` of its pipelines. A filter whose
/// passes do not count has no figure in reports.
pub const TAPS: &str = "filter_taps";

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
    /// The pixels that show fluid, as `meniscus::covered::CoveredPixels` of `shaders/ssfr/covered.inc.wgsl`: their number,
    /// then x + 65536 y for each, in no particular order.
    pub covered: &'a Buffer<Scratch>,
    /// Room for intermediate results; contents do not matter, before or after.
    pub scratch: [&'a Image<Scratch>; 2],
    /// Distance of neighbouring particles per drawn radius: the bumps to remove are `radius * spacing_per_radius` long.
    pub spacing_per_radius: f32,
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
/// Made once with its parameters; [`Self::record`] runs every frame, allocates nothing and cannot fail.
pub trait SurfaceFilter: Send + Sync {
    /// Name as registered.
    fn name(&self) -> &'static str;

    /// Records the passes that smooth `images.source` into `images.target`. `camera` is a [`CameraUniform`] for pictures
    /// of that size.
    fn record(&self, recorder: &mut Recorder, gpu: &Gpu, camera: &Binding, images: &FilterImages<'_>);

    /// The same on the CPU, after the formulas: what the passes are tested against.
    fn filter_on_cpu(&self, camera: &CameraUniform, surface: &HostSurface<'_>) -> Vec<f32>;

    /// Standard deviation, in projected spacings, of the response to a small bump on a plane, if the filter declares one.
    fn nominal_sigma(&self) -> Option<f32> {
        None
    }
}
