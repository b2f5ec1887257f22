#define_import_path meniscus::surroundings

#import meniscus::environment::{EnvironmentSize, environment_radiance}
#import meniscus::sky::{Sky, sky_radiance, sky_and_ground_radiance}
#import meniscus::surface::NO_SURFACE
#import meniscus::material::Material

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
    // Radiance of the lit floor, averaged over its pattern and all directions.
    floor_radiance: vec3<f32>,
    pad: f32,
    // A picture in place of the sky.
    environment: EnvironmentSize,
}

// Length along the unit direction to the floor; NO_SURFACE if it is not met from above.
fn trace_floor(s: Surroundings, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let height = dot(s.sky.up, origin) - s.floor_height_world;
    let descent = -dot(s.sky.up, direction);
    let is_met = (s.has_floor != 0u) & (height >= 0.0) & (descent * NO_SURFACE * 1e-9 > height);
    return select(NO_SURFACE, height / descent, is_met);
}

// What haze leaves of the light of something `length` away.
fn clear_share(s: Surroundings, length: f32) -> f32 {
    return exp2(-1.44269504 * length * s.haze_per_world);
}

// What is far away in the unit direction, seen in a mirror of this perceptual roughness: the picture of the surroundings, or
// sky and the ground that stands for it where there is no floor. Passes are compiled once with and once without the
// picture: software drivers run through both branches of a choice.
fn blurred_far_radiance(s: Surroundings, direction: vec3<f32>, roughness: f32) -> vec3<f32> {
#ifdef PICTURED
    var local = vec3(dot(direction, s.east), dot(direction, s.north), dot(direction, s.sky.up));
    // The floor hides what lies below the horizon, and fades into what lies at it.
    local.z = select(local.z, max(local.z, 0.0), s.has_floor != 0u);
    return environment_radiance(s.environment, local / max(length(local), 1e-6), roughness);
#else
    let sky = sky_radiance(s.sky, direction);
    return select(sky_and_ground_radiance(s.sky, direction, sky), sky, s.has_floor != 0u);
#endif
}

// The same without blur.
fn far_radiance(s: Surroundings, direction: vec3<f32>) -> vec3<f32> {
    return blurred_far_radiance(s, direction, 0.0);
}

// Radiance that arrives at `origin` (world) against the unit `direction`, with the floor's pattern averaged out: for what is
// seen in the moving mirror of the water.
fn surroundings_radiance(s: Surroundings, origin: vec3<f32>, direction: vec3<f32>, roughness: f32) -> vec3<f32> {
    let length = trace_floor(s, origin, direction);
    let clear = select(0.0, clear_share(s, length), length < NO_SURFACE);
    return mix(blurred_far_radiance(s, direction, roughness), s.floor_radiance, clear);
}
