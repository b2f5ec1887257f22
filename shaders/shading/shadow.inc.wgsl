#define_import_path meniscus::shadow

#import meniscus::lighting_inputs::{camera, sun_paths, surroundings}
#import meniscus::medium::Medium

// The shadow that the water throws on the scene.

// Pixels per side of a block of `sun_paths`.
const BLOCK_PX: f32 = 4.0;

// Length of water between the scene seen at `px` and the sun, bilinear.
fn sun_path(px: vec2<f32>) -> f32 {
    let size = vec2<i32>((camera.size_px + 3u) / 4u);
    let corner = px / BLOCK_PX - 0.5;
    let base = floor(corner);
    let f = corner - base;
    let low = clamp(vec2<i32>(base), vec2(0), size - 1);
    let high = clamp(vec2<i32>(base) + 1, vec2(0), size - 1);
    let top = mix(sun_paths[low.y * size.x + low.x], sun_paths[low.y * size.x + high.x], f.x);
    let bottom = mix(sun_paths[high.y * size.x + low.x], sun_paths[high.y * size.x + high.x], f.x);
    return mix(top, bottom, f.y);
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
