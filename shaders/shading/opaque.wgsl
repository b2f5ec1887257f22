// The opaque scene: a triangle over the whole picture for sky and floor, which are ray cast, then the objects' triangles.
// Every fragment writes the exact distance along the view axis; depth is near / distance, reversed.

#import meniscus::camera::{Camera, view_ray}
#import meniscus::lit::lit
#import meniscus::material::{Material, pattern_tone}
#import meniscus::surface::NO_SURFACE
#import meniscus::surroundings::{Surroundings, trace_floor, clear_share, far_radiance}

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

    let is_object = in.material != BACKGROUND;
    let faces_eye = dot(in.normal_world, direction) < 0.0;
    if is_object && (in.distance < camera.near_world || (in.front_only != 0u && !faces_eye)) {
        discard;
    }
    // One surface, the floor's or the object's, so that all fragments run through the same code once.
    var material = surroundings.floor;
    var normal = surroundings.sky.up;
    var reach = trace_floor(surroundings, origin, direction);
    if is_object {
        material = materials[in.material];
        normal = normalize(select(-in.normal_world, in.normal_world, faces_eye));
        reach = in.distance * per_step;
    }
    let far = far_radiance(surroundings, direction);
    if reach == NO_SURFACE {
        return Target(vec4(min(far, vec3(60000.0)), 0.0), NO_SURFACE, 0.0);
    }

    // Pattern coordinates on the plane of the pattern's frame that the normal is closest to.
    let to_frame = mat3x3(surroundings.east, surroundings.north, surroundings.sky.up);
    let place = ((origin + reach * direction - surroundings.anchor) * to_frame) / material.scale_world;
    let along = direction * to_frame;
    let facing = abs(normal * to_frame);
    var p = place.xy;
    var slope = along.xy;
    if facing.x > max(facing.y, facing.z) {
        p = place.yz;
        slope = along.yz;
    } else if facing.y > facing.z {
        p = place.xz;
        slope = along.xz;
    }
    // A pixel's cone cuts an ellipse out of the surface: its width across the ray, stretched along it.
    let px_world = select(reach / per_step, 1.0, camera.orthographic != 0u) / camera.px_per_world_at_one;
    let slant = max(abs(dot(normal, direction)), 1e-4);
    let footprint = px_world / material.scale_world * sqrt(vec2(1.0) + slope * slope / (slant * slant));

    let tone = pattern_tone(material, p, footprint);
    let near = lit(surroundings.sky, material, tone, normal, -direction);
    let color = min(mix(far, near, clear_share(surroundings, reach)), vec3(60000.0));
    let distance = reach / per_step;
    return Target(vec4(color, 1.0), distance, min(camera.near_world / distance, 1.0));
}
