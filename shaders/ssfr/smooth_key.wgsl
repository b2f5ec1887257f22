// Distances to keys, on which the smoothing passes work; with PAPER they are the distances themselves. Gaps are there already.
#import meniscus::camera::Camera
#import meniscus::key::{is_surface, key_of}
#ifdef HARDWARE
#import meniscus::covered::{CoveredPixels, unpack_pixel}
#else
#import meniscus::picture::corner
#endif
#ifdef PAPER
#import meniscus::surface::NO_SURFACE
#endif

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var front: texture_2d<f32>;

fn key_at(pixel: vec2<u32>) -> f32 {
    let distance = textureLoad(front, pixel, 0).x;
#ifdef PAPER
    return select(NO_SURFACE, distance, is_surface(distance));
#else
    return key_of(camera, distance);
#endif
}

#ifdef HARDWARE
@group(0) @binding(2) var key: texture_storage_2d<r32float, write>;
@group(0) @binding(3) var<storage, read> covered: CoveredPixels;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let end = covered.count;
    for (var i = id.x; i < end; i += groups.x * 64u) {
        let pixel = unpack_pixel(covered.packed[i]);
        textureStore(key, pixel, vec4(key_at(pixel)));
    }
}
#else
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return corner(index);
}

@fragment
fn fragment(@builtin(position) at_px: vec4<f32>) -> @location(0) f32 {
    return key_at(vec2<u32>(at_px.xy));
}
#endif
