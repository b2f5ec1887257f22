// Particle sets that are drawn opaque become part of the scene: every covered pixel writes its lit colour and distance over
// what is there. The splats were already cut off behind the scene, so no depth test is needed.

#import meniscus::camera::Camera
#import meniscus::lit::lit
#import meniscus::material::Material
#import meniscus::scene_point::{storable, sunlit, world_ray}
#import meniscus::surface::{is_empty, unpack_normal}
#import meniscus::surroundings::{Surroundings, clear_share, far_radiance}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> surroundings: Surroundings;
@group(0) @binding(2) var<uniform> material: Material;
@group(0) @binding(3) var distances: texture_2d<f32>;
@group(0) @binding(4) var normals: texture_2d<u32>;
// A single pixel without colour where no attribute colours the surface.
@group(0) @binding(5) var surface_colors: texture_2d<f32>;

struct Target {
    @location(0) color: vec4<f32>,
    @location(1) distance: f32,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0;
    return vec4(corner, 0.5, 1.0);
}

@fragment
fn fragment(@builtin(position) place: vec4<f32>) -> Target {
    let pixel = vec2<u32>(place.xy);
    let distance = textureLoad(distances, pixel, 0).x;
    if is_empty(distance) {
        discard;
    }
    let ray = world_ray(camera, place.xy);
    let normal = (camera.world_from_view * vec4(unpack_normal(textureLoad(normals, pixel, 0).x), 0.0)).xyz;
    let reach = distance * ray.per_distance;
    let sun = sunlit(ray.origin + reach * ray.direction, normal);
    let tint = textureLoad(surface_colors, min(pixel, textureDimensions(surface_colors) - 1u), 0);
    var tinted = material;
    tinted.color = mix(material.color, tint.rgb, tint.a);
    let near = lit(surroundings.sky, sun, tinted, 1.0, normal, -ray.direction);
    let color = mix(far_radiance(surroundings, ray.direction), near, clear_share(surroundings, reach));
    return Target(vec4(storable(color), 1.0), distance);
}
