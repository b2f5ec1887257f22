// The water as a chart: colour by the length of water behind a pixel, contour lines at equal steps of it, relief.
#define_import_path meniscus::model

#import meniscus::lighting_inputs::{camera, surroundings, distance_at, thickness_at, normal_at, scene_color, to_world}
#import meniscus::surface::is_empty

struct Chart {
    // Linear radiance from no water to the end of the map.
    map: array<vec4<f32>, 9>,
    // World units.
    depth_world: f32,
    // Between contour lines, world units; 0 = no lines.
    step_world: f32,
    line_px: f32,
    relief: f32,
}

@group(0) @binding(2) var<uniform> model: Chart;

const LAST_STOP: f32 = 8.0;
// Contours closer than this many line widths fade, and at a quarter of it are gone: a patch of lines tells nothing.
const ROOM_PER_LINE: f32 = 4.0;
// Light of a contour line relative to the surface, and of a slope that faces away from the sun.
const INK: f32 = 0.25;
const SHADE: f32 = 0.25;

fn is_water(at: vec2<i32>) -> bool {
    if any(at < vec2(0)) || any(at >= vec2<i32>(camera.size_px)) {
        return false;
    }
    return !is_empty(distance_at(vec2<u32>(at)));
}

// Change of thickness per pixel along an axis: over both neighbours, or the one that is water.
fn slope(at: vec2<i32>, axis: vec2<i32>) -> f32 {
    var after = at;
    var before = at;
    if is_water(at + axis) {
        after += axis;
    }
    if is_water(at - axis) {
        before -= axis;
    }
    let apart = dot(after - before, axis);
    return (thickness_at(vec2<u32>(after)) - thickness_at(vec2<u32>(before))) / f32(max(apart, 1));
}

fn map_color(thickness: f32) -> vec3<f32> {
    let place = clamp(thickness / model.depth_world, 0.0, 1.0) * LAST_STOP;
    let stop = min(floor(place), LAST_STOP - 1.0);
    return mix(model.map[u32(stop)].rgb, model.map[u32(stop) + 1u].rgb, place - stop);
}

// How much of a pixel a contour line covers.
fn contour(at: vec2<i32>, thickness: f32) -> f32 {
    let per_px = length(vec2(slope(at, vec2(1, 0)), slope(at, vec2(0, 1))));
    if model.step_world <= 0.0 || per_px < 1e-6 * model.step_world {
        return 0.0;
    }
    // No line where there is no water.
    let nearest = max(round(thickness / model.step_world), 1.0) * model.step_world;
    let off_px = abs(thickness - nearest) / per_px;
    let room = model.step_world / (per_px * model.line_px * ROOM_PER_LINE);
    return clamp(0.5 * model.line_px + 0.5 - off_px, 0.0, 1.0) * smoothstep(0.25, 1.0, room);
}

// Where there is no water.
fn scene_radiance(pixel: vec2<u32>) -> vec4<f32> {
    return textureLoad(scene_color, pixel, 0);
}

fn water_radiance(pixel: vec2<u32>) -> vec4<f32> {
    let thickness = thickness_at(pixel);
    let normal = to_world(normal_at(pixel));
    let light = mix(SHADE, 1.0, 0.5 + 0.5 * dot(normal, surroundings.sky.sun_direction));
    let ink = mix(1.0, INK, contour(vec2<i32>(pixel), thickness));
    return vec4(map_color(thickness) * mix(1.0, light, model.relief) * ink, 1.0);
}
