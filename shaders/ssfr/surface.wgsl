// Turns the depth image into distances and lists the pixels that show fluid. In the others every image has the values that stand for
// "no surface" already.
#import meniscus::camera::Camera
#import meniscus::covered::{Filling, pack_pixel}
#import meniscus::splat::{GRADE_BITS, radius_of_grade}

struct Surface {
    // The radius of every splat, or what grades are relative to; 0: the radius pass found that of the visible ones.
    radius_world: f32,
    // Whether distances end in grades of radii.
    is_graded: u32,
}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> surface: Surface;
@group(0) @binding(2) var scene_distance: texture_2d<f32>;
// Distances as the depth pass left them.
@group(0) @binding(3) var<storage, read> nearest: array<f32>;
// Of the radius pass, where there was one.
@group(0) @binding(4) var<storage, read> radius: array<f32>;
@group(0) @binding(5) var front: texture_storage_2d<rg32float, write>;
@group(0) @binding(6) var<storage, read_write> covered: Filling;

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= camera.size_px) {
        return;
    }
    let pixel = id.y * camera.size_px.x + id.x;
    let found = nearest[pixel];
    if found < textureLoad(scene_distance, id.xy, 0).x {
        var distance_world = found;
        var radius_world = surface.radius_world;
        if radius_world <= 0.0 {
            radius_world = radius[pixel];
        } else if surface.is_graded != 0u {
            let bits = bitcast<u32>(found);
            distance_world = bitcast<f32>(bits & ~GRADE_BITS);
            radius_world *= radius_of_grade(bits & GRADE_BITS);
        }
        textureStore(front, id.xy, vec4(distance_world, radius_world, 0.0, 0.0));
        covered.packed[atomicAdd(&covered.count, 1u)] = pack_pixel(id.xy);
    }
}
