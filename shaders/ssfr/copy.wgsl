// The filter that leaves the surface as it is.
#import meniscus::camera::Camera
#import meniscus::covered::{CoveredPixels, unpack_pixel}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<storage, read> source: array<f32>;
@group(0) @binding(2) var<storage, read_write> destination: array<f32>;
@group(0) @binding(3) var<storage, read> covered: CoveredPixels;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    for (var i = id.x; i < covered.count; i += groups.x * 64u) {
        let at = unpack_pixel(covered.packed[i]);
        let pixel = at.y * camera.size_px.x + at.x;
        destination[pixel] = source[pixel];
    }
}
