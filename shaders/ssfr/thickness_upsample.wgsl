// Joint upsampling of the reduced thickness: bilinear between the blocks that show the same surface as the pixel.
#import meniscus::covered::{CoveredPixels, unpack_pixel}
#import meniscus::camera::Camera
#import meniscus::thickness::Thickness

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> thickness: Thickness;
@group(0) @binding(2) var<storage, read> distance: array<f32>;
@group(0) @binding(3) var<storage, read> radius: array<f32>;
@group(0) @binding(4) var<storage, read> nearest: array<f32>;
@group(0) @binding(5) var<storage, read> covered: array<f32>;
@group(0) @binding(6) var<storage, read> smoothed: array<vec2<f32>>;
@group(0) @binding(7) var<storage, read_write> length_world: array<f32>;
@group(0) @binding(8) var<storage, read> covered_pixels: CoveredPixels;

// Distance, in radii, at which a block counts half as much.
const SAME_SURFACE_RADII: f32 = 4.0;
// What a block of another surface still counts, so that there is always an answer.
const LEAST: f32 = 1e-4;

fn upsample(id: vec2<u32>) {
    let pixel = id.y * camera.size_px.x + id.x;
    let d = distance[pixel];
    let corner = (vec2<f32>(id) + 0.5) / f32(thickness.scale) - 0.5;
    let base = floor(corner);
    let part = corner - base;
    let last = vec2<i32>(thickness.size_px) - 1;
    let tolerance = 1.0 / (SAME_SURFACE_RADII * radius[pixel]);
    var total = 0.0;
    var weights = 0.0;
    for (var tap = 0; tap < 4; tap++) {
        let offset = vec2(tap & 1, tap >> 1u);
        let at = vec2<u32>(clamp(vec2<i32>(base) + offset, vec2(0), last));
        let block = at.y * thickness.size_px.x + at.x;
        if covered[block] > 0.0 {
            let bilinear = select(1.0 - part, part, offset == vec2(1));
            let e = (nearest[block] - d) * tolerance;
            let weight = bilinear.x * bilinear.y * (1.0 / (1.0 + e * e) + LEAST);
            let value = smoothed[block];
            total += weight * value.x / value.y;
            weights += weight;
        }
    }
    // A surface is at least one step thick.
    length_world[pixel] = max(total / max(weights, 1e-20), thickness.world_per_step);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    for (var i = id.x; i < covered_pixels.count; i += groups.x * 64u) {
        upsample(unpack_pixel(covered_pixels.packed[i]));
    }
}
