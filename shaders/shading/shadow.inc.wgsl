#define_import_path meniscus::shadow

#import meniscus::lighting_inputs::{camera, shows_water, sun_paths, surroundings}
#import meniscus::medium::Medium

// The shadow that the water throws on the scene.

// Pixels per side of a block of `sun_paths`.
const BLOCK_PX: f32 = 4.0;

// Whether the middle of a block shows water.
fn block_shows_water(block: vec2<i32>) -> bool {
    let px = min((vec2<f32>(block) + 0.5) * BLOCK_PX, vec2<f32>(camera.size_px) - 0.5);
    return shows_water(vec2<u32>(px));
}

// Length of water between the scene seen at `px` and the sun, bilinear. Beside the water, blocks that see the scene through it
// do not count if there are others: the scene under the water lies in a shadow that ends where the water does.
fn sun_path(px: vec2<f32>) -> f32 {
    let size = vec2<i32>((camera.size_px + 3u) / 4u);
    let corner = px / BLOCK_PX - 0.5;
    let base = floor(corner);
    let f = corner - base;
    var paths: array<f32, 4>;
    var blocks: array<vec2<i32>, 4>;
    var deepest = 0.0;
    for (var k = 0; k < 4; k++) {
        blocks[k] = clamp(vec2<i32>(base) + vec2(k & 1, k >> 1u), vec2(0), size - 1);
        paths[k] = sun_paths[blocks[k].y * size.x + blocks[k].x];
        deepest = max(deepest, paths[k]);
    }
    if deepest <= 0.0 {
        return 0.0;
    }
    let weights = vec4((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);
    let all = dot(weights, vec4(paths[0], paths[1], paths[2], paths[3]));
    if shows_water(vec2<u32>(clamp(px, vec2(0.0), vec2<f32>(camera.size_px) - 0.5))) {
        return all;
    }
    var sum = 0.0;
    var beside = 0.0;
    for (var k = 0; k < 4; k++) {
        if !block_shows_water(blocks[k]) {
            sum += weights[k] * paths[k];
            beside += weights[k];
        }
    }
    return select(all, sum / max(beside, 1e-6), beside > 1e-3);
}

// How much of the water's tint its shadow has.
const SHADOW_TINT: f32 = 0.7;

// What the water between scene and sun leaves of the light on the scene seen at `px`. `bent_away` (1 / world unit) is what
// the surface directs elsewhere, on top of what the medium takes; `deepest` is the share of sunlight that the deepest shadow
// takes. The scene was lit by sun and sky together; the sun's share is taken as that on level ground.
fn shadow(px: vec2<f32>, medium: Medium, bent_away: f32, deepest: f32) -> vec3<f32> {
    let path = sun_path(px);
    if path <= 0.0 {
        return vec3(1.0);
    }
    let sky = surroundings.sky;
    let sun = sky.sun_irradiance * max(dot(sky.sun_direction, sky.up), 0.0);
    let share = sun / max(sun + sky.irradiance_up, vec3(1e-30));
    let grey = dot(medium.absorption, vec3(1.0 / 3.0));
    let extinction = mix(vec3(grey), medium.absorption, SHADOW_TINT) + medium.scattering + bent_away;
    return 1.0 - deepest * share * (1.0 - exp2(-1.44269504 * extinction * path));
}
