// The opaque scene: a triangle over the whole picture for sky and floor, which are ray cast, then the objects' triangles.
// Every fragment writes the exact distance along the view axis; depth is near / distance, reversed.

#import meniscus::camera::{Camera, view_ray, px_per_world}
#import meniscus::material::{Material, pattern_tone}
#import meniscus::sky::sky_radiance
#import meniscus::surface::NO_SURFACE
#import meniscus::surroundings::{Surroundings, Cone, trace_floor, surroundings_radiance, opaque_radiance}

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
@group(0) @binding(3) var<storage, read> triangles: array<u32>;
@group(0) @binding(4) var<storage, read> materials: array<Material>;

const BACKGROUND: u32 = 0xffffffffu;

struct Varying {
    @builtin(position) clip: vec4<f32>,
    @location(0) position_world: vec3<f32>,
    @location(1) normal_world: vec3<f32>,
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
    if index < 3u {
        let corner = vec2(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0;
        return Varying(vec4(corner, 0.5, 1.0), vec3(0.0), vec3(0.0), 0.0, BACKGROUND, 0u);
    }
    let v = vertices[triangles[index - 3u]];
    let position = (camera.view_from_world * vec4(v.position_world, 1.0)).xyz;
    let w = select(-position.z, 1.0, camera.orthographic != 0u);
    // Depth comes from the fragment; 0.5 keeps the clipper to what lies in front of the eye.
    let clip = vec4(position.xy / camera.half_extent, 0.5 * w, w);
    return Varying(clip, v.position_world, v.normal_world, -position.z, v.material, v.front_only);
}

@fragment
fn fragment(in: Varying) -> Target {
    let ray = view_ray(camera, in.clip.xy);
    let origin = (camera.world_from_view * vec4(ray.origin, 1.0)).xyz;
    let step = (camera.world_from_view * vec4(ray.step, 0.0)).xyz;
    let per_step = length(step);
    let direction = step / per_step;
    if in.material == BACKGROUND {
        let px_at_one = 1.0 / camera.px_per_world_at_one;
        // The cone of a pixel: constant width in parallel projection, none at the eye otherwise.
        let orthographic = camera.orthographic != 0u;
        let cone = Cone(select(0.0, px_at_one, orthographic), select(px_at_one / per_step, 0.0, orthographic));
        let color = min(surroundings_radiance(surroundings, origin, direction, cone), vec3(60000.0));
        let reach = trace_floor(surroundings, origin, direction);
        if reach == NO_SURFACE {
            return Target(vec4(color, 0.0), NO_SURFACE, 0.0);
        }
        let distance = reach / per_step;
        return Target(vec4(color, 1.0), distance, min(camera.near_world / distance, 1.0));
    }

    let faces_eye = dot(in.normal_world, direction) < 0.0;
    if in.distance < camera.near_world || (in.front_only != 0u && !faces_eye) {
        discard;
    }
    let normal = normalize(select(-in.normal_world, in.normal_world, faces_eye));
    let material = materials[in.material];
    // Pattern coordinates on the plane that the normal is closest to, measured from the floor's pattern.
    let local = in.position_world - surroundings.anchor;
    let frame = vec3(dot(local, surroundings.east), dot(local, surroundings.north), dot(local, surroundings.sky.up)) / material.scale_world;
    let facing = abs(vec3(dot(normal, surroundings.east), dot(normal, surroundings.north), dot(normal, surroundings.sky.up)));
    var p = frame.xy;
    if facing.x > max(facing.y, facing.z) {
        p = frame.yz;
    } else if facing.y > facing.z {
        p = frame.xz;
    }
    let slant = max(abs(dot(normal, direction)), 0.05);
    let footprint = 1.0 / (px_per_world(camera, in.distance) * material.scale_world * slant);
    let tone = pattern_tone(material.pattern, p, vec2(footprint));
    let lit = opaque_radiance(surroundings.sky, material, tone, normal, -direction);
    let clear = exp2(-1.44269504 * in.distance * per_step * surroundings.haze_per_world);
    let color = mix(sky_radiance(surroundings.sky, direction), lit, clear);
    return Target(vec4(color, 1.0), in.distance, min(camera.near_world / in.distance, 1.0));
}
