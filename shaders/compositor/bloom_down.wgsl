// Halves a level of the pyramid that bloom is made of: 13 taps, each the mean of four pixels (Jimenez 2014, Next Generation Post
// Processing in Call of Duty: Advanced Warfare). The first level takes the radiance of the picture, exposed, and lets single
// bright pixels count less, so that they do not flicker.
#ifdef FIRST
#import meniscus::light::{MAX_RADIANCE, finite}
#endif

struct BloomDown {
    source_px: vec2<u32>,
    // Factor on radiance, in the first level.
    exposure: f32,
    pad: u32,
}

@group(0) @binding(0) var<uniform> down: BloomDown;
@group(0) @binding(1) var source: texture_2d<f32>;

// Beyond the border the picture goes on as it ends.
fn at(pixel: vec2<i32>) -> vec3<f32> {
    let p = vec2<u32>(clamp(pixel, vec2(0), vec2<i32>(down.source_px) - 1));
#ifdef FIRST
    let light = finite(textureLoad(source, p, 0));
    return min(down.exposure * light.rgb, vec3(MAX_RADIANCE));
#else
    return textureLoad(source, p, 0).rgb;
#endif
}

fn tap(corner: vec2<i32>) -> vec3<f32> {
    return 0.25 * (at(corner) + at(corner + vec2(1, 0)) + at(corner + vec2(0, 1)) + at(corner + vec2(1, 1)));
}

// Mean of four taps; of the first level, after Karis 2013, weighted against brightness.
fn mean(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, d: vec3<f32>) -> vec3<f32> {
#ifdef FIRST
    let luminance = vec3(0.2126, 0.7152, 0.0722);
    let weights = 1.0 / (1.0 + vec4(dot(a, luminance), dot(b, luminance), dot(c, luminance), dot(d, luminance)));
    return (weights.x * a + weights.y * b + weights.z * c + weights.w * d) / dot(weights, vec4(1.0));
#else
    return 0.25 * (a + b + c + d);
#endif
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return vec4(vec2(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0, 0.5, 1.0);
}

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let o = 2 * vec2<i32>(position.xy);
    let nw = tap(o + vec2(-2, -2));
    let n = tap(o + vec2(0, -2));
    let ne = tap(o + vec2(2, -2));
    let w = tap(o + vec2(-2, 0));
    let m = tap(o);
    let e = tap(o + vec2(2, 0));
    let sw = tap(o + vec2(-2, 2));
    let s = tap(o + vec2(0, 2));
    let se = tap(o + vec2(2, 2));
    let center = mean(tap(o + vec2(-1, -1)), tap(o + vec2(1, -1)), tap(o + vec2(-1, 1)), tap(o + vec2(1, 1)));
    let around = mean(nw, n, w, m) + mean(n, ne, m, e) + mean(w, m, sw, s) + mean(m, e, s, se);
    return vec4(0.5 * center + 0.125 * around, 1.0);
}
