// The water as a chart: colour by the length of water behind a pixel, contour lines at equal steps of it, relief.
#import meniscus::camera::Camera
#import meniscus::surface::{is_empty, unpack_normal}
#import meniscus::surroundings::Surroundings

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

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> surroundings: Surroundings;
@group(0) @binding(2) var<uniform> chart: Chart;
@group(0) @binding(3) var<storage, read> distances: array<f32>;
@group(0) @binding(4) var<storage, read> thicknesses: array<f32>;
@group(0) @binding(5) var<storage, read> normals: array<u32>;
@group(0) @binding(6) var scene_color: texture_2d<f32>;
@group(0) @binding(7) var scene_distance: texture_2d<f32>;
@group(0) @binding(8) var<storage, read_write> radiance: array<vec4<f32>>;

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
    return !is_empty(distances[at.y * i32(camera.size_px.x) + at.x]);
}

fn thickness_at(at: vec2<i32>) -> f32 {
    return thicknesses[at.y * i32(camera.size_px.x) + at.x];
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
    return (thickness_at(after) - thickness_at(before)) / f32(max(apart, 1));
}

fn map_color(thickness: f32) -> vec3<f32> {
    let place = clamp(thickness / chart.depth_world, 0.0, 1.0) * LAST_STOP;
    let stop = min(floor(place), LAST_STOP - 1.0);
    return mix(chart.map[u32(stop)].rgb, chart.map[u32(stop) + 1u].rgb, place - stop);
}

// How much of a pixel a contour line covers.
fn contour(at: vec2<i32>, thickness: f32) -> f32 {
    let per_px = length(vec2(slope(at, vec2(1, 0)), slope(at, vec2(0, 1))));
    if chart.step_world <= 0.0 || per_px < 1e-6 * chart.step_world {
        return 0.0;
    }
    // No line where there is no water.
    let nearest = max(round(thickness / chart.step_world), 1.0) * chart.step_world;
    let off_px = abs(thickness - nearest) / per_px;
    let room = chart.step_world / (per_px * chart.line_px * ROOM_PER_LINE);
    return clamp(0.5 * chart.line_px + 0.5 - off_px, 0.0, 1.0) * smoothstep(0.25, 1.0, room);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= camera.size_px) {
        return;
    }
    let pixel = id.y * camera.size_px.x + id.x;
    let at = vec2<i32>(id.xy);
    let distance = distances[pixel];
    if is_empty(distance) || distance >= textureLoad(scene_distance, at, 0).x {
        radiance[pixel] = textureLoad(scene_color, at, 0);
        return;
    }
    let thickness = max(thicknesses[pixel], 0.0);
    let normal = (camera.world_from_view * vec4(unpack_normal(normals[pixel]), 0.0)).xyz;
    let light = mix(SHADE, 1.0, 0.5 + 0.5 * dot(normal, surroundings.sky.sun_direction));
    let ink = mix(1.0, INK, contour(at, thickness));
    radiance[pixel] = vec4(map_color(thickness) * mix(1.0, light, chart.relief) * ink, 1.0);
}
