// Starts the depth image with the distance of the opaque scene, so that nothing behind it can win.
#import meniscus::camera::Camera

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var scene_distance: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> nearest: array<u32>;

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= camera.size_px) {
        return;
    }
    nearest[id.y * camera.size_px.x + id.x] = bitcast<u32>(textureLoad(scene_distance, id.xy, 0).x);
}
