// Distances to keys, on which the smoothing passes work; with PAPER the distances themselves. Both images that the passes
// alternate between get the gaps, and what is no distance is one.
#import meniscus::camera::Camera
#import meniscus::key::{key_of, is_surface}
#import meniscus::surface::NO_SURFACE

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var front: texture_2d<f32>;
@group(0) @binding(2) var key: texture_storage_2d<r32float, write>;
@group(0) @binding(3) var other: texture_storage_2d<r32float, write>;

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= camera.size_px) {
        return;
    }
    let distance = textureLoad(front, id.xy, 0).x;
#ifdef PAPER
    let found = select(NO_SURFACE, distance, is_surface(distance));
#else
    let found = key_of(camera, distance);
#endif
    textureStore(key, id.xy, vec4(found));
    textureStore(other, id.xy, vec4(found));
}
