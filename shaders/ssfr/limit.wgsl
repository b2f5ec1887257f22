// Starts the depth image with the distance of the opaque scene, so that nothing behind it can win. Empties the list of
// covered pixels.
#import meniscus::camera::Camera

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var scene_distance: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> nearest: array<u32>;
// The first word is the list's length.
@group(0) @binding(3) var<storage, read_write> covered: array<u32>;

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= camera.size_px) {
        return;
    }
    let pixel = id.y * camera.size_px.x + id.x;
    nearest[pixel] = bitcast<u32>(textureLoad(scene_distance, id.xy, 0).x);
    if pixel == 0u {
        covered[0] = 0u;
    }
}
