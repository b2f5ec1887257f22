// Turns the depth image into distances, and tells which pixels show fluid: computed, it lists them; drawn, it gives them a depth of 1. In
// the others every image has the values that stand for "no surface" already.
#import meniscus::camera::Camera
#ifdef HARDWARE
#import meniscus::covered::{Filling, pack_pixel}
#else
#import meniscus::picture::corner
#import meniscus::surface::NO_SURFACE
#endif
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

// Distance and radius of the sphere in a pixel, and whether there is one.
struct Front {
    sphere: vec2<f32>,
    shows: bool,
}

fn front_at(at: vec2<u32>) -> Front {
    let pixel = at.y * camera.size_px.x + at.x;
    let found = nearest[pixel];
    if found >= textureLoad(scene_distance, at, 0).x {
        return Front(vec2(0.0), false);
    }
    if surface.radius_world <= 0.0 {
        return Front(vec2(found, radius[pixel]), true);
    }
    if surface.is_graded == 0u {
        return Front(vec2(found, surface.radius_world), true);
    }
    let bits = bitcast<u32>(found);
    let distance_world = bitcast<f32>(bits & ~GRADE_BITS);
    return Front(vec2(distance_world, surface.radius_world * radius_of_grade(bits & GRADE_BITS)), true);
}

#ifdef HARDWARE
@group(0) @binding(5) var front: texture_storage_2d<rg32float, write>;
@group(0) @binding(6) var<storage, read_write> covered: Filling;

@compute @workgroup_size(64, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= camera.size_px) {
        return;
    }
    let seen = front_at(id.xy);
    if seen.shows {
        textureStore(front, id.xy, vec4(seen.sphere, 0.0, 0.0));
        covered.packed[atomicAdd(&covered.count, 1u)] = pack_pixel(id.xy);
    }
}
#else
struct Target {
    @location(0) front: vec2<f32>,
    @builtin(frag_depth) mask: f32,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return corner(index);
}

@fragment
fn fragment(@builtin(position) at_px: vec4<f32>) -> Target {
    let seen = front_at(vec2<u32>(at_px.xy));
    return Target(select(vec2(NO_SURFACE, 0.0), seen.sphere, seen.shows), select(0.0, 1.0, seen.shows));
}
#endif
