#define_import_path meniscus::light

// Brighter than anything that is told apart; keeps what follows away from overflow, also of half floats.
const MAX_RADIANCE: f32 = 6e4;
const MAX_RADIANCE_BITS: i32 = 0x476a6000;
const INFINITY_BITS: i32 = 0x7f800000;

// NaN compares false with everything; WGSL may assume there is none, so look at the bits, which as integers have the order of
// the numbers that are not negative.
fn finite(x: vec4<f32>) -> vec4<f32> {
    let bits = max(bitcast<vec4<i32>>(x), vec4(0));
    return bitcast<vec4<f32>>(select(min(bits, vec4(MAX_RADIANCE_BITS)), vec4(0), bits > vec4(INFINITY_BITS)));
}
