// Linear radiance to display colour: exposure, contrast, saturation, tone curve, sRGB transfer, 8 bits with dither.

struct ToneMap {
    // Exposure times white balance, per channel.
    gain: vec3<f32>,
    contrast: f32,
    size_px: vec2<u32>,
    saturation: f32,
    // 0 = Khronos PBR neutral, 1 = filmic, 2 = none.
    curve: u32,
    // 1: alpha is coverage; 0: opaque.
    transparent: u32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(0) @binding(0) var<uniform> tone: ToneMap;
@group(0) @binding(1) var<storage, read> radiance: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> mapped: array<u32>;

// Brighter than anything that is told apart; keeps the curves away from overflow.
const MAX_RADIANCE: f32 = 6e4;
const MIDDLE_GREY: f32 = 0.18;

// Khronos PBR Neutral tone mapper, specification 1.0: colours below 0.8 - f90 are kept, highlights compress and desaturate.
fn pbr_neutral(input: vec3<f32>) -> vec3<f32> {
    let start = 0.8 - 0.04;
    let desaturation = 0.15;
    let low = min(input.r, min(input.g, input.b));
    let offset = select(0.04, low - 6.25 * low * low, low < 0.08);
    let color = input - offset;
    let peak = max(color.r, max(color.g, color.b));
    if peak < start {
        return color;
    }
    let d = 1.0 - start;
    let new_peak = 1.0 - d * d / (peak + d - start);
    let g = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
    return mix(color * (new_peak / peak), vec3(new_peak), g);
}

// Filmic curve: Narkowicz's rational fit of the ACES reference rendering (2015), at his exposure.
fn filmic(input: vec3<f32>) -> vec3<f32> {
    let x = 0.6 * input;
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
}

fn srgb(linear: vec3<f32>) -> vec3<f32> {
    let low = 12.92 * linear;
    let high = 1.055 * pow(max(linear, vec3(1e-6)), vec3(1.0 / 2.4)) - 0.055;
    return select(high, low, linear <= vec3(0.0031308));
}

// NaN compares false with everything; WGSL may assume there is none, so look at the bits.
fn finite(x: f32) -> f32 {
    let bits = bitcast<u32>(x);
    if (bits & 0x7f800000u) != 0x7f800000u {
        return clamp(x, 0.0, MAX_RADIANCE);
    }
    return select(0.0, MAX_RADIANCE, bits == 0x7f800000u);
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let index = (group.y * groups.x + group.x) * 64u + lane;
    if index >= tone.size_px.x * tone.size_px.y {
        return;
    }
    let input = radiance[index];
    var color = vec3(finite(input.r), finite(input.g), finite(input.b)) * tone.gain;
    if tone.contrast != 1.0 {
        color = MIDDLE_GREY * pow(max(color, vec3(1e-6)) / MIDDLE_GREY, vec3(tone.contrast));
    }
    let grey = dot(color, vec3(0.2126, 0.7152, 0.0722));
    color = clamp(mix(vec3(grey), color, tone.saturation), vec3(0.0), vec3(MAX_RADIANCE));
    if tone.curve == 0u {
        color = pbr_neutral(color);
    } else if tone.curve == 1u {
        color = filmic(color);
    }
    let display = srgb(clamp(color, vec3(0.0), vec3(1.0)));
    // Interleaved gradient noise (Jimenez 2014) of one step hides the steps of smooth gradients.
    let pixel = vec2<f32>(vec2(index % tone.size_px.x, index / tone.size_px.x) % vec2(1024u));
    let dither = fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715)))) - 0.5;
    let alpha = select(1.0, clamp(finite(input.a), 0.0, 1.0), tone.transparent != 0u);
    mapped[index] = pack4x8unorm(vec4(display + dither / 255.0, alpha));
}
