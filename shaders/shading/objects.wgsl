// The objects of the scene over sky and floor. Every fragment writes the exact distance along the view axis; depth is
// near / distance, reversed.

#import meniscus::camera::Camera
#import meniscus::material::Material
#import meniscus::scene_point::{surface_radiance, world_ray}
#import meniscus::surroundings::{Surroundings, trace_floor}

struct SceneVertex {
    position_world: vec3<f32>,
    material: u32,
    normal_world: vec3<f32>,
    // 1: only the side that the normal points to.
    front_only: u32,
}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> surroundings: Surroundings;
@group(0) @binding(2) var<storage, read> vertices: array<SceneVertex>;
@group(0) @binding(4) var<storage, read> materials: array<Material>;

struct Varying {
    @builtin(position) clip: vec4<f32>,
    @location(0) normal_world: vec3<f32>,
    @location(1) position_world: vec3<f32>,
    @location(2) distance: f32,
    @location(3) @interpolate(flat) material: u32,
    @location(4) @interpolate(flat) front_only: u32,
}

struct Target {
    @location(0) color: vec4<f32>,
    @location(1) distance: f32,
    @builtin(frag_depth) depth: f32,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Varying {
    let v = vertices[index];
    let position = (camera.view_from_world * vec4(v.position_world, 1.0)).xyz;
    let w = select(-position.z, 1.0, camera.orthographic != 0u);
    // Depth comes from the fragment; 0.5 keeps the clipper to what lies in front of the eye.
    let clip = vec4(position.xy / camera.half_extent, 0.5 * w, w);
    return Varying(clip, v.normal_world, v.position_world, -position.z, v.material, v.front_only);
}

@fragment
fn fragment(in: Varying) -> Target {
    let ray = world_ray(camera, in.clip.xy);
    // By the triangle: at silhouettes of what is smooth, normals face away while the surface faces the eye.
    let face = cross(dpdx(in.position_world), dpdy(in.position_world));
    let faces_eye = dot(in.normal_world, face) * dot(ray.direction, face) < 0.0;
    let floor_reach = trace_floor(surroundings, ray.origin, ray.direction);
    let below_floor = in.distance * ray.per_distance > floor_reach;
    if in.distance < camera.near_world || (in.front_only != 0u && !faces_eye) || below_floor {
        discard;
    }
    let normal = normalize(select(-in.normal_world, in.normal_world, faces_eye));
    let color = surface_radiance(camera, surroundings, ray, in.distance, normal, materials[in.material]);
    return Target(vec4(color, 1.0), in.distance, min(camera.near_world / in.distance, 1.0));
}
