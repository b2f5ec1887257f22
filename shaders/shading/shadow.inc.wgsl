#define_import_path meniscus::shadow

#import meniscus::lighting_inputs::{sunlight, surroundings}
#import meniscus::medium::Medium
#import meniscus::sky::Sky
#import meniscus::sunlight::{focus_of, share_of}

// The shadows that the water throws on the scene, and those that the scene throws on the water.

// Pixels per side of a block of `sunlight`.
const BLOCK_PX: u32 = 2u;

fn block_at(block: vec2<i32>) -> vec2<u32> {
    return textureLoad(sunlight, clamp(block, vec2(0), vec2<i32>(textureDimensions(sunlight)) - 1), 0).xy;
}

// Length of water that the light on the scene seen at `px` crosses, and how it is focused there; bilinear.
fn through_water(px: vec2<f32>) -> vec2<f32> {
    let corner = px / f32(BLOCK_PX) - 0.5;
    let base = vec2<i32>(floor(corner));
    let f = fract(corner);
    var values: array<vec2<f32>, 4>;
    for (var k = 0; k < 4; k++) {
        let packed = block_at(base + vec2(k & 1, k >> 1u));
        values[k] = vec2(bitcast<f32>(packed.x), focus_of(packed.y));
    }
    return mix(mix(values[0], values[1], f.x), mix(values[2], values[3], f.x), f.y);
}

// Sun and sky as the water's surface sees them in a pixel.
fn sky_at(pixel: vec2<u32>) -> Sky {
    var sky = surroundings.sky;
#ifndef NO_SUNLIGHT
    sky.sun_irradiance *= share_of(block_at(vec2<i32>(pixel / BLOCK_PX)).y);
#endif
    return sky;
}

// How much of the water's tint its shadow has.
const SHADOW_TINT: f32 = 0.7;

// Most of what water scatters only leaves its way a little: that takes no light, but blurs what is seen by it. As a multiple of
// the extinction.
const BLURRING: f32 = 1.5;

// What the water between scene and sun makes of the light on the scene seen at `px`, through so much water. `bent_away`
// (1 / world unit) is what the surface directs elsewhere, on top of what the medium takes; `deepest` is the share of sunlight
// that the deepest shadow takes. The scene was lit by sun and sky together; the sun's share is taken as that on level ground.
fn shadow(px: vec2<f32>, seen_through_world: f32, medium: Medium, bent_away: f32, deepest: f32) -> vec3<f32> {
#ifdef NO_SUNLIGHT
    return vec3(1.0);
#else
    let light = through_water(px);
    let sky = surroundings.sky;
    let sun = sky.sun_irradiance * max(dot(sky.sun_direction, sky.up), 0.0);
    let share = sun / max(sun + sky.irradiance_up, vec3(1e-30));
    let grey = dot(medium.absorption, vec3(1.0 / 3.0));
    let extinction = mix(vec3(grey), medium.absorption, SHADOW_TINT) + medium.scattering + bent_away;
    let left = 1.0 - deepest * (1.0 - exp2(-1.44269504 * extinction * light.x));
    let blurring = BLURRING * (grey + medium.scattering);
    let clarity = exp2(-1.44269504 * blurring * (light.x + seen_through_world));
    return 1.0 + share * (mix(1.0, light.y, clarity) * left - 1.0);
#endif
}
