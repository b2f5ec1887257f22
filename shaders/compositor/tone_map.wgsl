// Linear radiance to display colour: exposure, contrast, saturation, tone curve, sRGB transfer, 8 bits with dither. Compiled for one
// curve, with or without contrast and saturation (GRADED), alpha, bloom and anti-aliasing: software drivers run through both branches of a
// choice.
//
// Four neighbours of a row are a texel of what is written, and their brightness is one word for anti-aliasing.
#import meniscus::light::{MAX_RADIANCE, finite}
#ifndef HARDWARE
#import meniscus::picture::corner
#endif
#ifdef SMOOTHED
#import meniscus::luma::luma_byte
#endif

struct ToneMap {
    // Exposure times white balance, per channel.
    gain: vec3<f32>,
    contrast: f32,
    size_px: vec2<u32>,
    saturation: f32,
    pad: u32,
    // Per channel, as in the gain.
    white_balance: vec3<f32>,
    // Share of the light that bloom scatters.
    bloom: f32,
}

@group(0) @binding(0) var<uniform> tone: ToneMap;
@group(0) @binding(1) var radiance: texture_2d<f32>;
#ifdef BLOOM
@group(0) @binding(2) var bloom: texture_2d<f32>;
#endif

const MIDDLE_GREY: f32 = 0.18;

// Khronos PBR Neutral tone mapper, specification 1.0: colours below 0.8 - f90 are kept, highlights compress and desaturate.
fn pbr_neutral(input: vec3<f32>) -> vec3<f32> {
    let start = 0.8 - 0.04;
    let desaturation = 0.15;
    let low = min(input.r, min(input.g, input.b));
    let offset = select(0.04, low - 6.25 * low * low, low < 0.08);
    let color = input - offset;
    let peak = max(color.r, max(color.g, color.b));
    let d = 1.0 - start;
    // Below the start nothing is compressed; held there, the formula stays finite.
    let new_peak = 1.0 - d * d / (max(peak, start) + d - start);
    let g = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
    let compressed = mix(color * (new_peak / peak), vec3(new_peak), g);
    return select(compressed, color, peak < start);
}

// Filmic curve: Narkowicz's rational fit of the ACES reference rendering (2015), at his exposure.
fn filmic(input: vec3<f32>) -> vec3<f32> {
    let x = 0.6 * input;
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
}

// The transfer of IEC 61966-2-1. Its power is a polynomial of the fourth root, least-maximum fit over [0.0031308, 1]: off by at most
// 3.5e-5, a hundredth of a step of 8 bits, and a third of the work of `pow` on a processor.
fn srgb(linear: vec3<f32>) -> vec3<f32> {
    let t = sqrt(sqrt(linear));
    let high = -0.06461135 + t * (0.19613487 + t * (1.12268317 + t * (-0.33550205 + t * 0.0813297)));
    return select(high, 12.92 * linear, linear <= vec3(0.0031308));
}

#ifdef BLOOM
// What bloom makes of the light at this pixel, between the middles of its finest level, half as wide and high.
fn scattered(pixel: vec2<u32>) -> vec3<f32> {
    let last = vec2<i32>(textureDimensions(bloom)) - 1;
    let near = min(vec2<i32>(pixel) / 2, last);
    let far = clamp(near + 2 * vec2<i32>(pixel & vec2(1u)) - 1, vec2(0), last);
    let row = 3.0 * textureLoad(bloom, near, 0) + textureLoad(bloom, vec2(far.x, near.y), 0);
    let other = 3.0 * textureLoad(bloom, vec2(near.x, far.y), 0) + textureLoad(bloom, far, 0);
    return (3.0 * row + other).rgb / 16.0;
}
#endif

// Display colour in [0, 1] of exposed light.
fn display_color(light: vec3<f32>) -> vec3<f32> {
    var color = light;
#ifdef GRADED
    color = MIDDLE_GREY * pow(max(color, vec3(1e-6)) / MIDDLE_GREY, vec3(tone.contrast));
    let grey = dot(color, vec3(0.2126, 0.7152, 0.0722));
    color = clamp(mix(vec3(grey), color, tone.saturation), vec3(0.0), vec3(MAX_RADIANCE));
#endif
#ifdef NEUTRAL
    color = pbr_neutral(color);
#else ifdef FILMIC
    color = filmic(color);
#endif
    return srgb(clamp(color, vec3(0.0), vec3(1.0)));
}

struct Target {
    // Four pixels, red in the lowest byte.
    @location(0) mapped: vec4<u32>,
#ifdef SMOOTHED
    @location(1) lumas: u32,
#endif
}

struct Mapped {
    // Red in the lowest byte.
    pixel: u32,
    luma: u32,
}

fn mapped_pixel(at: vec2<u32>) -> Mapped {
    // At the end of a row the last pixel is done again.
    let pixel = vec2(min(at.x, tone.size_px.x - 1u), at.y);
    let input = finite(textureLoad(radiance, pixel, 0));
    var light = input.rgb * tone.gain;
#ifdef BLOOM
    light = mix(light, tone.white_balance * scattered(pixel), tone.bloom);
#endif
    let color = display_color(light);
#ifdef TRANSPARENT
    let alpha = min(input.a, 1.0);
#else
    let alpha = 1.0;
#endif
    // Interleaved gradient noise (Jimenez 2014) of one step hides the steps of smooth gradients.
    let at_px = vec2<f32>(pixel & vec2(1023u));
    let dither = fract(52.9829189 * fract(dot(at_px, vec2(0.06711056, 0.00583715))));
    let steps = vec3<u32>(min(255.0 * color + dither, vec3(255.0)));
    var mapped: Mapped;
    mapped.pixel = steps.r | (steps.g << 8u) | (steps.b << 16u) | (u32(255.0 * alpha + 0.5) << 24u);
#ifdef SMOOTHED
    mapped.luma = luma_byte(color, alpha);
#endif
    return mapped;
}

fn mapped_at(texel: vec2<u32>) -> Target {
    let first = vec2(4u * texel.x, texel.y);
    let a = mapped_pixel(first);
    let b = mapped_pixel(first + vec2(1u, 0u));
    let c = mapped_pixel(first + vec2(2u, 0u));
    let d = mapped_pixel(first + vec2(3u, 0u));
    var four: Target;
    four.mapped = vec4(a.pixel, b.pixel, c.pixel, d.pixel);
#ifdef SMOOTHED
    four.lumas = a.luma | (b.luma << 8u) | (c.luma << 16u) | (d.luma << 24u);
#endif
    return four;
}

#ifdef HARDWARE
@group(0) @binding(3) var mapped: texture_storage_2d<rgba32uint, write>;
#ifdef SMOOTHED
@group(0) @binding(4) var lumas: texture_storage_2d<r32uint, write>;
#endif

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= textureDimensions(mapped)) {
        return;
    }
    let four = mapped_at(id.xy);
    textureStore(mapped, id.xy, four.mapped);
#ifdef SMOOTHED
    textureStore(lumas, id.xy, vec4(four.lumas));
#endif
}
#else
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return corner(index);
}

@fragment
fn fragment(@builtin(position) at_px: vec4<f32>) -> Target {
    return mapped_at(vec2<u32>(at_px.xy));
}
#endif
