// Sky and floor, ray cast: what the objects of the scene are drawn over.

#import meniscus::camera::Camera
#import meniscus::scene_point::{storable, surface_radiance, world_ray}
#import meniscus::surface::NO_SURFACE
#import meniscus::surroundings::{Surroundings, trace_floor, far_radiance}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> surroundings: Surroundings;
@group(0) @binding(2) var scene_color: texture_storage_2d<rgba16float, write>;
@group(0) @binding(3) var scene_distance: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= camera.size_px) {
        return;
    }
    let ray = world_ray(camera, vec2<f32>(id.xy) + 0.5);
    let reach = trace_floor(surroundings, ray.origin, ray.direction);
    var color = vec4(storable(far_radiance(surroundings, ray.direction)), 0.0);
    var distance = NO_SURFACE;
    if reach < NO_SURFACE {
        distance = reach / ray.per_distance;
        color = vec4(surface_radiance(camera, surroundings, ray, distance, surroundings.sky.up, surroundings.floor), 1.0);
    }
    textureStore(scene_color, id.xy, color);
    textureStore(scene_distance, id.xy, vec4(distance, 0.0, 0.0, 0.0));
}
