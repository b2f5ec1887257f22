// The filter that leaves the surface as it is.
#import meniscus::covered::{CoveredPixels, unpack_pixel}

@group(0) @binding(0) var front: texture_2d<f32>;
@group(0) @binding(1) var distance: texture_storage_2d<r32float, write>;
@group(0) @binding(2) var<storage, read> covered: CoveredPixels;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let end = covered.count;
    for (var i = id.x; i < end; i += groups.x * 64u) {
        let pixel = unpack_pixel(covered.packed[i]);
        textureStore(distance, pixel, vec4(textureLoad(front, pixel, 0).x));
    }
}
