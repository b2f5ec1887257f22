// Length of water between the opaque scene and the sun, one value per block of pixels: marches towards the sun through the
// water as this view knows it, from the surface and as deep as the thickness says. Exact for water that a view ray crosses
// once; what lies outside of the picture throws no shadow.

#import meniscus::camera::{Camera, project_px, view_position}
#import meniscus::surface::is_empty

struct WaterShadow {
    // Unit, towards the sun.
    sun_direction_view: vec3<f32>,
    // How far the march goes, world units.
    reach_world: f32,
    size_blocks: vec2<u32>,
    pad_a: u32,
    pad_b: u32,
}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> shadow: WaterShadow;
@group(0) @binding(2) var<storage, read> distances: array<f32>;
@group(0) @binding(3) var<storage, read> thicknesses: array<f32>;
@group(0) @binding(4) var scene_distance: texture_2d<f32>;
@group(0) @binding(5) var<storage, read_write> sun_paths: array<f32>;

// Pixels per side of a block: shadows through water are soft.
const BLOCK_PX: f32 = 4.0;
const STEPS: i32 = 32;

fn sun_path(start_view: vec3<f32>) -> f32 {
    let step_world = shadow.reach_world / f32(STEPS);
    var path = 0.0;
    for (var i = 0; i < STEPS; i++) {
        let position = start_view + (f32(i) + 0.5) * step_world * shadow.sun_direction_view;
        let px = project_px(camera, position);
        if position.z >= 0.0 || any(px < vec2(0.0)) || any(px >= vec2<f32>(camera.size_px)) {
            break;
        }
        let index = u32(px.y) * camera.size_px.x + u32(px.x);
        let distance = distances[index];
        if !is_empty(distance) {
            // Depth below the surface along the view ray, softened by the step so that the samples leave no bands.
            let per_distance = select(length(position) / -position.z, 1.0, camera.orthographic != 0u);
            let depth = (-position.z - distance) * per_distance;
            let thickness = thicknesses[index];
            let soft = min(step_world, thickness) + 1e-30;
            path += step_world * clamp(depth / soft + 0.5, 0.0, 1.0) * clamp((thickness - depth) / soft + 0.5, 0.0, 1.0);
        }
    }
    return path;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= shadow.size_blocks) {
        return;
    }
    let px = min((vec2<f32>(id.xy) + 0.5) * BLOCK_PX, vec2<f32>(camera.size_px) - 0.5);
    let scene = textureLoad(scene_distance, vec2<i32>(px), 0).x;
    var path = 0.0;
    if !is_empty(scene) && shadow.reach_world > 0.0 {
        path = sun_path(view_position(camera, px, scene));
    }
    sun_paths[id.y * shadow.size_blocks.x + id.x] = path;
}
