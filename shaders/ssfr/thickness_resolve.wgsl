// From the fixed-point sums to what is smoothed: thickness in world units and coverage.
#import meniscus::thickness::{Thickness, SATURATED, block_of}

@group(0) @binding(0) var<uniform> thickness: Thickness;
@group(0) @binding(1) var reduced: texture_2d<f32>;
#ifdef PAIRS
// Of each block, and a part of the next one's.
@group(0) @binding(2) var<storage, read> sum: array<vec2<u32>>;
#else
@group(0) @binding(2) var<storage, read> sum: array<u32>;
#endif
@group(0) @binding(3) var resolved: texture_storage_2d<rg32float, write>;

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= thickness.size_px) {
        return;
    }
    let pixel = id.y * thickness.size_px.x + id.x;
#ifdef PAIRS
    let steps = sum[pixel].x + select(0u, sum[max(pixel, 1u) - 1u].y, id.x > 0u);
#else
    let steps = min(sum[pixel], SATURATED);
#endif
    let length_world = f32(steps) * thickness.world_per_step;
    let covered = block_of(textureLoad(reduced, id.xy, 0)).covered;
    textureStore(resolved, id.xy, vec4(length_world, covered, 0.0, 0.0));
}
