// Joint upsampling of the reduced thickness: bilinear between the blocks that show the same surface as the pixel.
#ifdef HARDWARE
#import meniscus::covered::{CoveredPixels, unpack_pixel}
#else
#import meniscus::picture::corner
#endif
#import meniscus::thickness::{Thickness, smoothed_block_of}

@group(0) @binding(0) var<uniform> thickness: Thickness;
@group(0) @binding(1) var front: texture_2d<f32>;
@group(0) @binding(2) var smoothed: texture_2d<f32>;

// Distance, in radii, at which a block counts half as much.
const SAME_SURFACE_RADII: f32 = 4.0;
// What a block of another surface still counts, so that there is always an answer.
const LEAST: f32 = 1e-4;

// World units along the ray.
fn length_at(id: vec2<u32>) -> f32 {
    let own = textureLoad(front, id, 0);
    let corner = (vec2<f32>(id) + 0.5) / f32(thickness.scale) - 0.5;
    let base = floor(corner);
    let part = corner - base;
    let last = vec2<i32>(thickness.size_px) - 1;
    let tolerance = 1.0 / (SAME_SURFACE_RADII * own.y);
    var total = 0.0;
    var weights = 0.0;
    for (var tap = 0; tap < 4; tap++) {
        let offset = vec2(tap & 1, tap >> 1u);
        let at = clamp(vec2<i32>(base) + offset, vec2(0), last);
        let block = smoothed_block_of(textureLoad(smoothed, at, 0));
        if block.covered > 0.0 {
            let bilinear = select(1.0 - part, part, offset == vec2(1));
            let e = (block.nearest - own.x) * tolerance;
            let weight = bilinear.x * bilinear.y * (1.0 / (1.0 + e * e) + LEAST);
            total += weight * block.thickness_world;
            weights += weight;
        }
    }
    // A surface is at least one step thick.
    return max(total / max(weights, 1e-20), thickness.world_per_step);
}

#ifdef HARDWARE
@group(0) @binding(3) var<storage, read> covered: CoveredPixels;
@group(0) @binding(4) var length_world: texture_storage_2d<r32float, write>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let end = covered.count;
    for (var i = id.x; i < end; i += groups.x * 64u) {
        let pixel = unpack_pixel(covered.packed[i]);
        textureStore(length_world, pixel, vec4(length_at(pixel)));
    }
}
#else
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return corner(index);
}

@fragment
fn fragment(@builtin(position) at_px: vec4<f32>) -> @location(0) f32 {
    return length_at(vec2<u32>(at_px.xy));
}
#endif
