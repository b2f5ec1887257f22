// Distances to keys, on which the smoothing passes work; with PAPER the distances themselves. Both images that the passes
// alternate between get the gaps, and what is no distance is one.
#import meniscus::camera::Camera
#import meniscus::key::{key_of, is_surface}
#import meniscus::surface::NO_SURFACE

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<storage, read> distance: array<f32>;
@group(0) @binding(2) var<storage, read_write> key: array<f32>;
@group(0) @binding(3) var<storage, read_write> other: array<f32>;

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= camera.size_px) {
        return;
    }
    let pixel = id.y * camera.size_px.x + id.x;
#ifdef PAPER
    let found = select(NO_SURFACE, distance[pixel], is_surface(distance[pixel]));
#else
    let found = key_of(camera, distance[pixel]);
#endif
    key[pixel] = found;
    other[pixel] = found;
}
