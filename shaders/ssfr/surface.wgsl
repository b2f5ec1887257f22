// Turns the depth image into distances and lists the pixels that show fluid; the others get the values that stand for "no
// surface" in every image. Fills the radius image where every splat has the same radius.
#import meniscus::camera::Camera
#import meniscus::covered::pack_pixel
#import meniscus::surface::NO_SURFACE

struct Surface {
    // The radius of every splat; 0: the radius image is filled by the radius pass.
    uniform_radius_world: f32,
}

// `CoveredPixels` while it is filled.
struct Filling {
    count: atomic<u32>,
    packed: array<u32>,
}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> surface: Surface;
@group(0) @binding(2) var scene_distance: texture_2d<f32>;
@group(0) @binding(3) var<storage, read> nearest: array<f32>;
@group(0) @binding(4) var<storage, read_write> unfiltered: array<f32>;
@group(0) @binding(5) var<storage, read_write> radius: array<f32>;
@group(0) @binding(6) var<storage, read_write> distance: array<f32>;
@group(0) @binding(7) var<storage, read_write> length_world: array<f32>;
@group(0) @binding(8) var<storage, read_write> normal: array<u32>;
@group(0) @binding(9) var<storage, read_write> covered: Filling;

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= camera.size_px) {
        return;
    }
    let pixel = id.y * camera.size_px.x + id.x;
    let found = nearest[pixel];
    if found < textureLoad(scene_distance, id.xy, 0).x {
        unfiltered[pixel] = found;
        if surface.uniform_radius_world > 0.0 {
            radius[pixel] = surface.uniform_radius_world;
        }
        covered.packed[atomicAdd(&covered.count, 1u)] = pack_pixel(id.xy);
    } else {
        unfiltered[pixel] = NO_SURFACE;
        distance[pixel] = NO_SURFACE;
        radius[pixel] = 0.0;
        length_world[pixel] = 0.0;
        normal[pixel] = 0u;
    }
}
