// Caustics as a map in the sun's picture (Shah, Konttinen & Pattanaik 2007): every pixel of it is a bundle of light, which the
// surface of the water bends and which lands where it meets the scene. Sums are integers, so that they do not depend on the
// order.

#import meniscus::camera::{project_px, view_position}
#import meniscus::sun_view::{sun_camera, sun_scene_distance}
#import meniscus::surface::{is_empty, unpack_normal}

@group(0) @binding(0) var distances: texture_2d<f32>;
@group(0) @binding(1) var normals: texture_2d<u32>;
@group(0) @binding(2) var<storage, read_write> landed: array<atomic<u32>>;

const WATER_TO_AIR: f32 = 1.0 / 1.333;
// Of the bundle that arrives without water.
const ONE: f32 = 4096.0;
// Steps of the fixed point iteration that finds where a ray meets the scene.
const STEPS: i32 = 4;

fn scene_at(px: vec2<f32>) -> f32 {
    let last = vec2<i32>(sun_camera.size_px) - 1;
    return textureLoad(sun_scene_distance, clamp(vec2<i32>(px), vec2(0), last), 0).x;
}

fn land(px: vec2<f32>) {
    let corner = px - 0.5;
    let base = floor(corner);
    let f = corner - base;
    let size = vec2<i32>(sun_camera.size_px);
    for (var k = 0; k < 4; k++) {
        let offset = vec2(k & 1, k >> 1u);
        let at = vec2<i32>(base) + offset;
        let weights = mix(1.0 - f, f, vec2<f32>(offset));
        if all(at >= vec2(0)) && all(at < size) {
            atomicAdd(&landed[at.y * size.x + at.x], u32(round(ONE * weights.x * weights.y)));
        }
    }
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= sun_camera.size_px) {
        return;
    }
    var px = vec2<f32>(id.xy) + 0.5;
    let distance = textureLoad(distances, id.xy, 0).x;
    let below = scene_at(px);
    if is_empty(below) {
        return;
    }
    if !is_empty(distance) && distance < below {
        let entry = view_position(sun_camera, px, distance);
        let bent = refract(vec3(0.0, 0.0, -1.0), unpack_normal(textureLoad(normals, id.xy, 0).x), WATER_TO_AIR);
        let per_distance = 1.0 / max(-bent.z, 0.1);
        for (var i = 0; i < STEPS; i++) {
            let reach = scene_at(px) - distance;
            if reach >= 1e30 {
                return;
            }
            px = project_px(sun_camera, entry + max(reach, 0.0) * per_distance * bent);
        }
    }
    land(px);
}
