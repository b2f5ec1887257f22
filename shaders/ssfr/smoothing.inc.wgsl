#define_import_path meniscus::smoothing
#import meniscus::camera::{Camera, px_per_world}

// What the filters that average along rows and columns share: how wide, and at which taps.

struct Smoothing {
    // Pixels per step along the direction of the pass: (1, 0) or (0, 1).
    direction: vec2<u32>,
    // Standard deviation of the whole filter in spacings.
    sigma_spacings: f32,
    spacing_per_radius: f32,
    // Fraction of the variance of all passes along rows (or columns) that is this one's.
    share: f32,
    // In radii: the range to the front and back beyond which another surface begins, and where what lies further back is
    // taken to be.
    range_radii: f32,
    clamp_radii: f32,
    // Taps to each side, at most; a wider kernel is sampled in larger steps, which the smoothness of the splats allows.
    most_taps: f32,
}

// A pixel after a pass.
struct Smoothed {
    // Its key, or what the pass works on in place of it.
    value: f32,
    // Samples read besides the pixel's own.
    taps: u32,
}

struct Sigmas {
    // Of one pass along a direction, pixels.
    pass_px: f32,
    // Of the clean-up in two dimensions, in its gaps.
    square_px: f32,
}

// What taps along lines leave for the clean-up to even out.
struct Pattern {
    // Pixels between places that the taps treat alike: what repeats by that comes through them unsmoothed.
    period: f32,
    // How far it is from one pixel to two: 0 where all taps count the same, 1 where every other one is gone.
    gaps: f32,
}

// Wider than any picture; also keeps taps from running over where a radius is absurd.
const MOST_SIGMA_PX: f32 = 1e5;

// Standard deviation in pixels of a filter over `sigma_radii` drawn radii. A radius that is no number, or none that a particle
// could have, smooths nothing.
fn sigma_in_px(camera: Camera, sigma_radii: f32, distance: f32, radius: f32) -> f32 {
    let px = sigma_radii * radius * px_per_world(camera, distance);
    return select(0.0, min(px, MOST_SIGMA_PX), px > 0.0 && px < 1e30);
}

// Pixels from one tap to the next, a power of two, of a kernel that reaches so far.
fn step_of(reach_px: f32, most: f32) -> f32 {
    var step = 1.0;
    while reach_px > most * step {
        step *= 2.0;
    }
    return step;
}

// The variances of all passes add up to the square of the filter's sigma.
fn sigmas(camera: Camera, smoothing: Smoothing, distance: f32, radius: f32) -> Sigmas {
    let total_px = sigma_in_px(camera, smoothing.sigma_spacings * smoothing.spacing_per_radius, distance, radius);
    let square_px = min(0.5 * total_px, 1.0);
    let pass_px = sqrt((total_px * total_px - square_px * square_px) * smoothing.share);
    return Sigmas(pass_px, square_px);
}

fn pattern_of(smoothing: Smoothing, pass_px: f32) -> Pattern {
    let reach_px = REACH * WIDENED * pass_px;
    // Of every other tap more than half is gone from three quarters of the most taps on.
    let period = step_of(reach_px, 0.75 * smoothing.most_taps);
    return Pattern(period, 1.0 - odd_weight(reach_px, smoothing.most_taps));
}

// Kernels are a Gaussian less its value at 2.5 of its standard deviations, where they end: nothing jumps as one more tap fits,
// and little is left of waves that taps further apart might mistake for others. It has 0.8928 of the Gaussian's standard
// deviation; this one has the nominal value. At the picture's border kernels end earlier.
const WIDENED: f32 = 1.0 / 0.8928;
const REACH: f32 = 2.5;
// Standard deviations of a Gaussian, in lengths of the kernel, beyond which its shape does not change by half a percent.
const MOST_WIDTH: f32 = 8.0;
// Below this the nearest neighbours weigh less than half a percent.
const LEAST_SIGMA_PX: f32 = 0.3;

// Weight of every other tap of a kernel that takes so many to each side, beginning with the first: fades before the step doubles, so
// that no ring shows where it does.
fn odd_weight(taps: f32, most: f32) -> f32 {
    return 1.0 - smoothstep(0.5 * most, most, taps);
}

// The taps of a kernel along a line.
struct Taps {
    // Pixels from one to the next, a power of two.
    step: i32,
    // To each side.
    count: i32,
    falloff: f32,
    // The Gaussian where the kernel ends.
    at_end: f32,
    // `odd_weight`.
    odd: f32,
}

// `room`: pixels to the nearer border.
fn taps_of(smoothing: Smoothing, sigma_px: f32, room: i32) -> Taps {
    let most = smoothing.most_taps;
    let reach_px = min(REACH * sigma_px, f32(room) + 1.0);
    // Whole pixels and even: uneven steps leave ripples.
    let step = step_of(reach_px, most);
    let end = reach_px / step;
    // Of a much wider Gaussian the border cuts out a parabola, whatever its width; in single precision its own values near the
    // middle could not be told from 1.
    let shape_px = min(sigma_px, MOST_WIDTH * reach_px);
    let falloff = -0.5 / (shape_px * shape_px);
    return Taps(i32(step), min(i32(end), room / i32(step)), falloff, exp(falloff * reach_px * reach_px), odd_weight(end, most));
}

// Weight of the `k`-th tap to either side, relative to the middle.
fn tap_weight(taps: Taps, k: i32) -> f32 {
    let offset = f32(k * taps.step);
    let weight = max(exp(taps.falloff * offset * offset) - taps.at_end, 0.0) / (1.0 - taps.at_end);
    return weight * select(1.0, taps.odd, (k & 1) == 1);
}
