#define_import_path meniscus::scene_point

#import meniscus::camera::{Camera, view_ray}
#import meniscus::lit::lit
#import meniscus::material::{Material, pattern_tone}
#import meniscus::surroundings::{Surroundings, clear_share, far_radiance}
#ifdef SHADOWED
#import meniscus::sun_view::sun_visibility
#endif

// Points of the opaque scene as a view ray meets them.

// A view ray in world space.
struct WorldRay {
    origin: vec3<f32>,
    // Unit.
    direction: vec3<f32>,
    // Length along the ray per distance along the view axis.
    per_distance: f32,
}

fn world_ray(camera: Camera, point_px: vec2<f32>) -> WorldRay {
    let ray = view_ray(camera, point_px);
    let origin = (camera.world_from_view * vec4(ray.origin, 1.0)).xyz;
    let step = (camera.world_from_view * vec4(ray.step, 0.0)).xyz;
    let per_distance = length(step);
    return WorldRay(origin, step / per_distance, per_distance);
}

// What half floats hold.
fn storable(radiance: vec3<f32>) -> vec3<f32> {
    return min(radiance, vec3(60000.0));
}

// Tangent of the slope from which on patterns are those of a wall.
const STEEP: f32 = 3.0;

// Share of the sun that a surface sees.
fn sunlit(position: vec3<f32>, normal: vec3<f32>) -> f32 {
#ifdef SHADOWED
    return sun_visibility(position, normal);
#else
    return 1.0;
#endif
}

// Radiance of a surface of `material` that the ray meets at `distance`, with the haze in front of it.
fn surface_radiance(camera: Camera, surroundings: Surroundings, ray: WorldRay, distance: f32, normal: vec3<f32>, material: Material) -> vec3<f32> {
    let reach = distance * ray.per_distance;
    // Pattern coordinates on a plane of the pattern's frame: the level one but for walls, so that the slopes of terrain have no seams.
    let to_frame = mat3x3(surroundings.east, surroundings.north, surroundings.sky.up);
    let position = ray.origin + reach * ray.direction;
    let place = ((position - surroundings.anchor) * to_frame) / material.scale_world;
    let along = ray.direction * to_frame;
    let facing = abs(normal * to_frame);
    var p = place.xy;
    var slope = along.xy;
    if facing.x > max(facing.y, STEEP * facing.z) {
        p = place.yz;
        slope = along.yz;
    } else if facing.y > STEEP * facing.z {
        p = place.xz;
        slope = along.xz;
    }
    // A pixel's cone cuts an ellipse out of the surface: its width across the ray, stretched along it.
    let px_world = select(distance, 1.0, camera.orthographic != 0u) / camera.px_per_world_at_one;
    let slant = max(abs(dot(normal, ray.direction)), 1e-4);
    let footprint = px_world / material.scale_world * sqrt(vec2(1.0) + slope * slope / (slant * slant));

    let tone = pattern_tone(material, p, footprint);
    let near = lit(surroundings.sky, sunlit(position, normal), material, tone, normal, -ray.direction);
    return storable(mix(far_radiance(surroundings, ray.direction), near, clear_share(surroundings, reach)));
}
