#define_import_path meniscus::smoothing
#import meniscus::camera::{Camera, px_per_world}

// What the filters that average along rows and columns share: how wide, and at which taps. Four pixels beside each other at a time,
// to which neighbours are common.

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
    // Taps to each side from which on they are spread out, up to `MOST_SPREAD` pixels apart; and at most: still wider kernels are
    // sampled in larger steps, which the smoothness of the splats allows.
    close_taps: f32,
    most_taps: f32,
    // Of a coarse pass of the clean-up: pixels from one tap to the next, at most.
    most_gap: i32,
}

struct Sigmas {
    // Of one pass along a direction, pixels.
    pass_px: vec4<f32>,
    // Of the clean-up in two dimensions, in its gaps.
    square_px: vec4<f32>,
}

// What taps along lines leave for the clean-up to even out.
struct Pattern {
    // Pixels between places that the taps treat alike: what repeats by that comes through them unsmoothed.
    period: vec4<f32>,
    // How far it is from one pixel to two: 0 where all taps count the same, 1 where every other one is gone.
    gaps: vec4<f32>,
}

// Wider than any picture; also keeps taps from running over where a radius is absurd.
const MOST_SIGMA_PX: f32 = 1e5;

// Standard deviation in pixels of a filter over `sigma_radii` drawn radii. A radius that is no number, or none that a particle
// could have, smooths nothing.
fn sigma_in_px(camera: Camera, sigma_radii: f32, distance: f32, radius: f32) -> f32 {
    let px = sigma_radii * radius * px_per_world(camera, distance);
    return select(0.0, min(px, MOST_SIGMA_PX), px > 0.0 && px < 1e30);
}

const MOST_SPREAD: f32 = 4.0;

// The least power of two, of those from 1 on, that is not less.
fn power_of_two(least: vec4<f32>) -> vec4<f32> {
    // Carried into the exponent unless it is one.
    let bits = bitcast<vec4<u32>>(max(least, vec4(1.0))) + 0x7fffffu;
    return bitcast<vec4<f32>>(bits & vec4(0xff800000u));
}

// The variances of all passes add up to the square of the filter's sigma.
fn sigmas(camera: Camera, smoothing: Smoothing, distance: vec4<f32>, radius: vec4<f32>) -> Sigmas {
    let radii = smoothing.sigma_spacings * smoothing.spacing_per_radius;
    let total_px = vec4(
        sigma_in_px(camera, radii, distance.x, radius.x),
        sigma_in_px(camera, radii, distance.y, radius.y),
        sigma_in_px(camera, radii, distance.z, radius.z),
        sigma_in_px(camera, radii, distance.w, radius.w),
    );
    let square_px = min(0.5 * total_px, vec4(1.0));
    let pass_px = sqrt((total_px * total_px - square_px * square_px) * smoothing.share);
    return Sigmas(pass_px, square_px);
}

fn pattern_of(smoothing: Smoothing, pass_px: vec4<f32>) -> Pattern {
    let reach_px = REACH * WIDENED * pass_px;
    // Of every other tap more than half is gone from three quarters of the most taps on.
    let period = power_of_two(reach_px / (0.75 * smoothing.most_taps));
    return Pattern(period, 1.0 - odd_weight(reach_px, vec4(smoothing.most_taps)));
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
fn odd_weight(taps: vec4<f32>, most: vec4<f32>) -> vec4<f32> {
    return 1.0 - smoothstep(0.5 * most, most, taps);
}

// The taps of kernels along a line.
struct Taps {
    // Pixels from one to the next, a power of two.
    step: vec4<f32>,
    // To each side, whole.
    count: vec4<f32>,
    falloff: vec4<f32>,
    // The Gaussian where the kernel ends, and one over its height above that.
    at_end: vec4<f32>,
    scale: vec4<f32>,
    // `odd_weight`.
    odd: vec4<f32>,
}

// `room`: pixels to the nearer border. Below `LEAST_SIGMA_PX` there are no taps.
fn taps_of(smoothing: Smoothing, sigma_px: vec4<f32>, room: vec4<f32>) -> Taps {
    let wide_px = max(sigma_px, vec4(LEAST_SIGMA_PX));
    let reach_px = min(REACH * wide_px, room + 1.0);
#ifdef STEPS_OF_ONE
    let step = vec4(1.0);
#else
    // Whole pixels and even: uneven steps leave ripples.
    let spread = min(power_of_two(reach_px / smoothing.close_taps), vec4(MOST_SPREAD));
    let step = max(spread, power_of_two(reach_px / smoothing.most_taps));
#endif
    let most = select(vec4(smoothing.most_taps), vec4(smoothing.close_taps), step < vec4(MOST_SPREAD));
    let end = reach_px / step;
    let count = floor(min(end, room / step));
    // Of a much wider Gaussian the border cuts out a parabola, whatever its width; in single precision its own values near the
    // middle could not be told from 1.
    let shape_px = min(wide_px, MOST_WIDTH * reach_px);
    let falloff = -0.5 / (shape_px * shape_px);
    let at_end = exp(falloff * reach_px * reach_px);
    let used = select(vec4(0.0), count, sigma_px >= vec4(LEAST_SIGMA_PX));
    return Taps(step, used, falloff, at_end, 1.0 / (1.0 - at_end), odd_weight(end, most));
}

// Weights of the `k`-th taps to either side, relative to the middle.
fn tap_weight(taps: Taps, k: i32) -> vec4<f32> {
    let odd = select(vec4(1.0), taps.odd, (k & 1) == 1);
    return weight_at(taps, f32(k) * taps.step) * odd;
}

// The kernel `offset` pixels away.
fn weight_at(taps: Taps, offset: vec4<f32>) -> vec4<f32> {
    let weight = max(exp(taps.falloff * offset * offset) - taps.at_end, vec4(0.0)) * taps.scale;
    return select(vec4(0.0), weight, offset <= taps.count * taps.step);
}

// Weights `offset` pixels to either side: 0 between taps.
fn weight_beside(taps: Taps, offset: i32) -> vec4<f32> {
    let step = vec4<i32>(taps.step);
    let is_tap = (vec4(offset) & (step - 1)) == vec4(0);
    let is_odd = (vec4(offset) & step) != vec4(0);
    let weight = weight_at(taps, vec4(f32(offset))) * select(vec4(1.0), taps.odd, is_odd);
    return select(vec4(0.0), weight, is_tap);
}
