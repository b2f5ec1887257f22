// Sky and floor, ray cast: what the objects of the scene are drawn over. FLOORLESS: of scenes without a floor, which software drivers
// would go through in vain.

#import meniscus::camera::Camera
#import meniscus::picture::corner
#import meniscus::scene_point::{storable, surface_radiance, world_ray}
#import meniscus::surface::NO_SURFACE
#import meniscus::surroundings::{Surroundings, trace_floor, far_radiance}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> surroundings: Surroundings;

struct Target {
    @location(0) color: vec4<f32>,
    @location(1) distance: f32,
}

fn seen_in(pixel: vec2<u32>) -> Target {
    let ray = world_ray(camera, vec2<f32>(pixel) + 0.5);
#ifndef FLOORLESS
    let reach = trace_floor(surroundings, ray.origin, ray.direction);
    if reach < NO_SURFACE {
        let distance = reach / ray.per_distance;
        let color = surface_radiance(camera, surroundings, ray, distance, surroundings.sky.up, surroundings.floor);
        return Target(vec4(color, 1.0), distance);
    }
#endif
    return Target(vec4(storable(far_radiance(surroundings, ray.direction)), 0.0), NO_SURFACE);
}

#ifdef HARDWARE
@group(0) @binding(2) var scene_color: texture_storage_2d<rgba16float, write>;
@group(0) @binding(3) var scene_distance: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= camera.size_px) {
        return;
    }
    let seen = seen_in(id.xy);
    textureStore(scene_color, id.xy, seen.color);
    textureStore(scene_distance, id.xy, vec4(seen.distance, 0.0, 0.0, 0.0));
}
#else
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return corner(index);
}

@fragment
fn fragment(@builtin(position) at_px: vec4<f32>) -> Target {
    return seen_in(vec2<u32>(at_px.xy));
}
#endif
