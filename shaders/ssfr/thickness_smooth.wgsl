// Smooths the reduced thickness and its coverage alike; their quotient is the mean over what is covered, without a dark seam at
// silhouettes. Along rows, then, with COLUMNS, along columns. A Gaussian; with TENT, after each where its taps may lie apart, what evens
// out their pattern. With LAST the quotient is taken.
#import meniscus::thickness::{Thickness, block_of}

@group(0) @binding(0) var<uniform> thickness: Thickness;
@group(0) @binding(1) var reduced: texture_2d<f32>;
// Thickness and coverage; of later passes than the first also the standard deviation.
@group(0) @binding(2) var source: texture_2d<f32>;
@group(0) @binding(3) var smoothed: texture_storage_2d<rgba32float, write>;

// Beyond this many taps to a side they are spread out, evenly: uneven gaps would leave ripples.
const MAX_TAPS: f32 = 24.0;
// Where the Gaussian ends, in standard deviations.
const REACH: f32 = 2.5;

// Blocks from one tap to the next.
fn step_of(sigma_px: f32) -> i32 {
    return max(1, i32(ceil(REACH * sigma_px / MAX_TAPS)));
}

fn sigma_of(at: vec2<i32>) -> f32 {
    return block_of(textureLoad(reduced, at, 0)).sigma;
}

// Blocks next to the surface hold what small splats left outside; they are smoothed like the surface beside them.
fn sigma_at(at: vec2<i32>, last: vec2<i32>) -> f32 {
    let own = sigma_of(at);
    if own > 0.0 {
        return own;
    }
    let low = max(at - 1, vec2(0));
    let high = min(at + 1, last);
    let beside = max(sigma_of(vec2(low.x, at.y)), sigma_of(vec2(high.x, at.y)));
    return max(beside, max(sigma_of(vec2(at.x, low.y)), sigma_of(vec2(at.x, high.y))));
}

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= thickness.size_px) {
        return;
    }
    let at = vec2<i32>(id.xy);
    let last = vec2<i32>(thickness.size_px) - 1;
    let own = textureLoad(source, at, 0);
    var total = own.xy;
#ifdef FIRST
    let sigma_px = sigma_at(at, last);
#else
    let sigma_px = own.z;
#endif
    if sigma_px > 0.0 {
#ifdef COLUMNS
        let direction = vec2(0, 1);
#else
        let direction = vec2(1, 0);
#endif
        let place = dot(at, direction);
        let end = dot(last, direction);
#ifdef TENT
        // Taps of the Gaussian treat blocks alike that lie a step apart: what repeats by that comes through. The mean over a step, taken
        // twice, has nothing of it.
        let step = 1;
        let taps = step_of(sigma_px) - 1;
        let share = 1.0 / f32(taps + 1);
#else
        let step = step_of(sigma_px);
        let taps = i32(ceil(REACH * sigma_px / f32(step)));
        let falloff = -0.5 / (sigma_px * sigma_px);
        // As much as of blocks that take all taps, with which these are averaged along the columns.
        let share = f32(step);
#endif
        for (var k = 1; k <= taps; k++) {
            let offset = k * step;
#ifdef TENT
            let weight = 1.0 - share * f32(offset);
#else
            let weight = exp(falloff * f32(offset * offset));
#endif
            if place >= offset {
                total += weight * textureLoad(source, at - offset * direction, 0).xy;
            }
            if place + offset <= end {
                total += weight * textureLoad(source, at + offset * direction, 0).xy;
            }
        }
        total *= share;
    }
#ifdef LAST
    let block = block_of(textureLoad(reduced, at, 0));
    // As `smoothed_block_of` reads it.
    textureStore(smoothed, at, vec4(total.x / max(total.y, 1e-20), block.nearest, block.covered, 0.0));
#else
    textureStore(smoothed, at, vec4(total, sigma_px, 0.0));
#endif
}
