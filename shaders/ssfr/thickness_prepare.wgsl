// What the reduced thickness image needs to know of the full picture, block by block; empties the sums.
#import meniscus::camera::{Camera, px_per_world}
#import meniscus::thickness::Thickness
#import meniscus::surface::{NO_SURFACE, is_empty}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> thickness: Thickness;
@group(0) @binding(2) var scene_distance: texture_2d<f32>;
@group(0) @binding(3) var<storage, read> distance: array<f32>;
@group(0) @binding(4) var<storage, read> radius: array<f32>;
// Farthest the fluid is seen in a block.
@group(0) @binding(5) var<storage, read_write> limit: array<f32>;
// Nearest surface in a block.
@group(0) @binding(6) var<storage, read_write> nearest: array<f32>;
// Part of a block that shows fluid, of what the scene does not hide.
@group(0) @binding(7) var<storage, read_write> covered: array<f32>;
// Standard deviation of the smoothing in blocks; 0 where there is no surface.
@group(0) @binding(8) var<storage, read_write> sigma: array<f32>;
@group(0) @binding(9) var<storage, read_write> sum: array<u32>;

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= thickness.size_px) {
        return;
    }
    let first = id.xy * thickness.scale;
    let end = min(first + thickness.scale, camera.size_px);
    var farthest = 0.0;
    var surface = NO_SURFACE;
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            farthest = max(farthest, textureLoad(scene_distance, vec2(x, y), 0).x);
            surface = min(surface, distance[y * camera.size_px.x + x]);
        }
    }
    var fluid = 0.0;
    var open = 0.0;
    var widest = 0.0;
    if !is_empty(surface) {
        for (var y = first.y; y < end.y; y++) {
            for (var x = first.x; x < end.x; x++) {
                widest = max(widest, radius[y * camera.size_px.x + x]);
                let is_fluid = !is_empty(distance[y * camera.size_px.x + x]);
                let is_open = is_fluid || textureLoad(scene_distance, vec2(x, y), 0).x > surface;
                fluid += f32(is_fluid);
                open += f32(is_open);
            }
        }
    }
    let pixel = id.y * thickness.size_px.x + id.x;
    limit[pixel] = farthest;
    nearest[pixel] = surface;
    covered[pixel] = fluid / max(open, 1.0);
    let spacing_px = widest * thickness.spacing_per_radius * px_per_world(camera, surface) / f32(thickness.scale);
    sigma[pixel] = thickness.sigma_spacings * spacing_px;
    sum[pixel] = 0u;
}
