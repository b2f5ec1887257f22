// One direction of the Gaussian over the reduced thickness, for the thickness and its coverage alike; their quotient is
// the mean over what is covered, without a dark seam at silhouettes. FIRST: from the sums, else from the first's output.
#import meniscus::thickness::{Thickness, SATURATED}

@group(0) @binding(0) var<uniform> thickness: Thickness;
@group(0) @binding(1) var<storage, read> sigma: array<f32>;
#ifdef FIRST
@group(0) @binding(2) var<storage, read> covered: array<f32>;
@group(0) @binding(3) var<storage, read> sum: array<u32>;
#else
@group(0) @binding(2) var<storage, read> rows: array<vec2<f32>>;
#endif
// Thickness and coverage, smoothed.
@group(0) @binding(4) var<storage, read_write> smoothed: array<vec2<f32>>;

// Beyond this many taps to a side they are spread out, evenly: at 24 the gaps are a sixth of the radius of the splats, which
// hold nothing finer. Uneven gaps would leave ripples.
const MAX_TAPS: f32 = 24.0;
// Where the Gaussian ends, in standard deviations.
const REACH: f32 = 2.5;

fn value(pixel: u32) -> vec2<f32> {
#ifdef FIRST
    return vec2(f32(min(sum[pixel], SATURATED)) * thickness.world_per_step, covered[pixel]);
#else
    return rows[pixel];
#endif
}

// Blocks next to the surface hold what small splats left outside; they are smoothed like the surface beside them.
fn sigma_at(at: vec2<i32>, pixel: u32) -> f32 {
    let own = sigma[pixel];
    if own > 0.0 {
        return own;
    }
    let width = thickness.size_px.x;
    let last = vec2<i32>(thickness.size_px) - 1;
    let left = sigma[select(pixel, pixel - 1u, at.x > 0)];
    let right = sigma[select(pixel, pixel + 1u, at.x < last.x)];
    let above = sigma[select(pixel, pixel - width, at.y > 0)];
    let below = sigma[select(pixel, pixel + width, at.y < last.y)];
    return max(max(left, right), max(above, below));
}

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= thickness.size_px) {
        return;
    }
    let pixel = id.y * thickness.size_px.x + id.x;
    let at = vec2<i32>(id.xy);
    var total = value(pixel);
    let sigma_px = sigma_at(at, pixel);
    if sigma_px > 0.0 {
#ifdef FIRST
        let place = at.x;
        let last = i32(thickness.size_px.x) - 1;
        let stride = 1;
#else
        let place = at.y;
        let last = i32(thickness.size_px.y) - 1;
        let stride = i32(thickness.size_px.x);
#endif
        let reach_px = REACH * sigma_px;
        let step = max(1, i32(ceil(reach_px / MAX_TAPS)));
        let taps = i32(ceil(reach_px / f32(step)));
        let falloff = -0.5 / (sigma_px * sigma_px);
        for (var k = 1; k <= taps; k++) {
            let offset = k * step;
            let weight = exp(falloff * f32(offset * offset));
            if place >= offset {
                total += weight * value(u32(i32(pixel) - offset * stride));
            }
            if place + offset <= last {
                total += weight * value(u32(i32(pixel) + offset * stride));
            }
        }
    }
    smoothed[pixel] = total;
}
