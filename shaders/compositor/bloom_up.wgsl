// Adds what a level of the pyramid of bloom has scattered further to the level above, which is twice as wide and high: enlarged by a
// tent of three texels (Jimenez 2014) on bilinear samples.

struct BloomUp {
    coarse_px: vec2<u32>,
    // Share of the light that is scattered further than this level does.
    spread: f32,
    pad: f32,
}

@group(0) @binding(0) var<uniform> up: BloomUp;
@group(0) @binding(1) var fine: texture_2d<f32>;
@group(0) @binding(2) var coarse: texture_2d<f32>;

fn at(texel: vec2<i32>) -> vec3<f32> {
    return textureLoad(coarse, vec2<u32>(clamp(texel, vec2(0), vec2<i32>(up.coarse_px) - 1)), 0).rgb;
}

// Along one row, at the quarter of a texel that lies towards `side`.
fn along(texel: vec2<i32>, side: i32) -> vec3<f32> {
    let x = vec2(side, 0);
    return (at(texel + 2 * x) + 5.0 * at(texel + x) + 7.0 * at(texel) + 3.0 * at(texel - x)) / 16.0;
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return vec4(vec2(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0, 0.5, 1.0);
}

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(position.xy);
    let texel = pixel / 2;
    let side = 2 * (pixel & vec2(1)) - 1;
    let y = vec2(0, side.y);
    let enlarged = (along(texel + 2 * y, side.x) + 5.0 * along(texel + y, side.x) + 7.0 * along(texel, side.x)
        + 3.0 * along(texel - y, side.x)) / 16.0;
    return vec4(mix(textureLoad(fine, vec2<u32>(pixel), 0).rgb, enlarged, up.spread), 1.0);
}
