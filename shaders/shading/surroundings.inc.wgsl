#define_import_path meniscus::surroundings

#import meniscus::brdf::{ggx, burley_diffuse, fifth_power}
#import meniscus::material::{Material, pattern_tone}
#import meniscus::sky::{Sky, sky_radiance, sky_and_ground_radiance}
#import meniscus::surface::NO_SURFACE

// What a ray meets that meets neither water nor an object: the endless floor, its haze, the sky.

struct Surroundings {
    sky: Sky,
    floor: Material,
    // Ground directions of the floor's pattern, unit, world.
    east: vec3<f32>,
    // dot(up, p) on the floor.
    floor_height_world: f32,
    north: vec3<f32>,
    // 1 / distance over which haze takes over.
    haze_per_world: f32,
    // Where the floor's pattern starts, world.
    anchor: vec3<f32>,
    // 1 if there is a floor.
    has_floor: u32,
}

// Width of a pixel's cone: at the origin of the ray and per unit of length.
struct Cone {
    width_world: f32,
    growth: f32,
}

// Length along the unit direction to the floor; NO_SURFACE if it is not met from above.
fn trace_floor(s: Surroundings, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let height = dot(s.sky.up, origin) - s.floor_height_world;
    let descent = -dot(s.sky.up, direction);
    if s.has_floor == 0u || height < 0.0 || descent * NO_SURFACE * 1e-9 <= height {
        return NO_SURFACE;
    }
    return height / descent;
}

// Radiance of an opaque surface under sun and sky towards `to_eye` (unit).
fn opaque_radiance(sky: Sky, material: Material, tone: f32, normal: vec3<f32>, to_eye: vec3<f32>) -> vec3<f32> {
    let base = material.color * tone;
    let f0 = mix(vec3(0.04), base, material.metallic);
    let diffuse = base * (1.0 - material.metallic);
    let n_v = max(dot(normal, to_eye), 1e-3);
    let alpha = max(material.roughness * material.roughness, 2e-3);

    let n_l = dot(normal, sky.sun_direction);
    var sun = vec3(0.0);
    if n_l > 0.0 {
        let half_way = normalize(sky.sun_direction + to_eye);
        let l_h = max(dot(sky.sun_direction, half_way), 0.0);
        let fresnel = f0 + (1.0 - f0) * fifth_power(1.0 - l_h);
        let specular = fresnel * ggx(n_l, n_v, max(dot(normal, half_way), 0.0), alpha);
        sun = (diffuse * burley_diffuse(n_l, n_v, l_h, material.roughness) + specular) * n_l * sky.sun_irradiance;
    }

    let facing_up = 0.5 + 0.5 * dot(normal, sky.up);
    let ambient = mix(sky.irradiance_down, sky.irradiance_up, facing_up);
    // Environment specular: the analytic fit of the GGX split sum by Karis 2014, with the ambient as environment.
    let c0 = vec4(-1.0, -0.0275, -0.572, 0.022) * material.roughness + vec4(1.0, 0.0425, 1.04, -0.04);
    let a004 = min(c0.x * c0.x, exp2(-9.28 * n_v)) * c0.x + c0.y;
    let scale_bias = vec2(-1.04, 1.04) * a004 + c0.zw;
    return sun + (diffuse + f0 * scale_bias.x + scale_bias.y) * ambient * 0.318309886;
}

// Radiance of the floor met by the ray after `length`, with haze.
fn floor_radiance(s: Surroundings, origin: vec3<f32>, direction: vec3<f32>, length: f32, cone: Cone) -> vec3<f32> {
    let hit = origin + length * direction - s.anchor;
    let per_pattern = 1.0 / s.floor.scale_world;
    let p = vec2(dot(hit, s.east), dot(hit, s.north)) * per_pattern;
    // The cone's ellipse on the ground: its width across the ray's azimuth, stretched along it.
    let width = (cone.width_world + cone.growth * length) * per_pattern;
    let descent = max(-dot(s.sky.up, direction), 1e-4);
    let along = vec2(dot(direction, s.east), dot(direction, s.north));
    let footprint = width * sqrt(vec2(1.0) + along * along / (descent * descent));
    let tone = pattern_tone(s.floor.pattern, p, footprint);
    let lit = opaque_radiance(s.sky, s.floor, tone, s.sky.up, -direction);
    let clear = exp2(-1.44269504 * length * s.haze_per_world);
    return mix(sky_radiance(s.sky, direction), lit, clear);
}

// Radiance that arrives at `origin` (world) against the unit `direction`.
fn surroundings_radiance(s: Surroundings, origin: vec3<f32>, direction: vec3<f32>, cone: Cone) -> vec3<f32> {
    let length = trace_floor(s, origin, direction);
    if length < NO_SURFACE {
        return floor_radiance(s, origin, direction, length, cone);
    }
    if s.has_floor != 0u {
        return sky_radiance(s.sky, direction);
    }
    return sky_and_ground_radiance(s.sky, direction);
}
