#define_import_path meniscus::narrow_range
#import meniscus::camera::{Camera, px_per_world}

struct NarrowRange {
    // Pixels per step along the direction of the pass: (1, 0) or (0, 1).
    direction: vec2<u32>,
    // Standard deviation of the whole filter in spacings.
    sigma_spacings: f32,
    spacing_per_radius: f32,
    // Passes per direction.
    iterations: f32,
    // In radii: the range to the front and back beyond which another surface begins, and where what lies further back is
    // taken to be.
    range_radii: f32,
    clamp_radii: f32,
    pad: f32,
}

struct Sigmas {
    // Of one pass along a direction, pixels.
    pass_px: f32,
    // Of the clean-up in two dimensions, pixels.
    clean_px: f32,
}

// The variances of all passes add up to the square of the filter's sigma.
fn sigmas(camera: Camera, narrow: NarrowRange, distance: f32, radius: f32) -> Sigmas {
    let total_px = narrow.sigma_spacings * narrow.spacing_per_radius * radius * px_per_world(camera, distance);
    let clean_px = min(0.5 * total_px, 1.0);
    return Sigmas(sqrt((total_px * total_px - clean_px * clean_px) / narrow.iterations), clean_px);
}

// Both tests of the range are faded over its outer half: a sample that crosses a hard threshold from one row to the next
// would leave a streak.

// What a deviation counts as: itself, and further behind than the range `clamped`. `range` is > 0.
fn clamp_behind(deviation: f32, range: f32, clamped: f32) -> f32 {
    let e = max(deviation, -range);
    return e + (clamped - e) * clamp(-2.0 * e / range - 1.0, 0.0, 1.0);
}

// How far a pair counts whose nearer sample deviates by `deviation`: not at all in front of the range.
fn keep_in_front(deviation: f32, range: f32) -> f32 {
    return clamp(2.0 - 2.0 * deviation / range, 0.0, 1.0);
}

// A Gaussian cut at 2.5 of its standard deviations has 0.954 of it left; this one has the nominal value after the cut.
const WIDENED: f32 = 1.0 / 0.954;
const REACH: f32 = 2.5;
// Taps to each side; a wider Gaussian is sampled in larger steps, which the smoothness of the splats allows. The steps are
// whole pixels and even: uneven ones leave ripples.
const MAX_TAPS: f32 = 24.0;
// Below this the nearest neighbours weigh less than half a percent.
const LEAST_SIGMA_PX: f32 = 0.3;
