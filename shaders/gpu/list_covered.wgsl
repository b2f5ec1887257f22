// Lists the pixels that a mask says show fluid.
#import meniscus::covered::{Filling, pack_pixel}

@group(0) @binding(0) var mask: texture_depth_2d;
// Its length is 0 before.
@group(0) @binding(1) var<storage, read_write> covered: Filling;

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if all(id.xy < textureDimensions(mask)) && textureLoad(mask, id.xy, 0) > 0.0 {
        covered.packed[atomicAdd(&covered.count, 1u)] = pack_pixel(id.xy);
    }
}
