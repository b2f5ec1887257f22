// Turns the depth image into distances with the agreed value for "no surface", and fills the radius image where every
// splat has the same radius.
#import meniscus::camera::Camera
#import meniscus::surface::NO_SURFACE

struct Surface {
    // The radius of every splat; 0: the radius image is filled by the radius pass.
    uniform_radius_world: f32,
}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> surface: Surface;
@group(0) @binding(2) var scene_distance: texture_2d<f32>;
@group(0) @binding(3) var<storage, read> nearest: array<f32>;
@group(0) @binding(4) var<storage, read_write> distance: array<f32>;
@group(0) @binding(5) var<storage, read_write> radius: array<f32>;

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= camera.size_px) {
        return;
    }
    let pixel = id.y * camera.size_px.x + id.x;
    let found = nearest[pixel];
    let is_fluid = found < textureLoad(scene_distance, id.xy, 0).x;
    distance[pixel] = select(NO_SURFACE, found, is_fluid);
    if !is_fluid {
        radius[pixel] = 0.0;
    } else if surface.uniform_radius_world > 0.0 {
        radius[pixel] = surface.uniform_radius_world;
    }
}
