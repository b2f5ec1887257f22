#define_import_path meniscus::reflection

#import meniscus::brdf::{fresnel_dielectric, ggx}
#import meniscus::lighting_inputs::surroundings
#import meniscus::sky::Sky
#import meniscus::surroundings::surroundings_radiance

// Where the mirror of the water looks.
fn mirrored(normal: vec3<f32>, to_eye: vec3<f32>) -> vec3<f32> {
    let direction = reflect(-to_eye, normal);
    // A ray that leaves the upper side downwards meets the next wave, which in turn shows sky: reflect it upwards. From the
    // sides it meets the floor.
    let up = surroundings.sky.up;
    let level = smoothstep(0.15, 0.5, dot(normal, up));
    return normalize(direction - 2.0 * level * min(dot(direction, up), 0.0) * up);
}

// Brightest glint, enough to come out white.
const MAX_GLINT: f32 = 6.0;

// The sun in a rough mirror of GGX width `alpha`. Unit vectors, world; `n_v` is the cosine between normal and eye, > 0.
fn sun_glint(sky: Sky, normal: vec3<f32>, to_eye: vec3<f32>, n_v: f32, alpha: f32, refractive_index: f32) -> vec3<f32> {
    let n_l = dot(normal, sky.sun_direction);
    // Sun and eye opposite each other leave no half way; the lobe is then zero.
    let between = sky.sun_direction + to_eye;
    let half_way = between / max(length(between), 1e-6);
    let lobe = ggx(max(n_l, 1e-3), n_v, max(dot(normal, half_way), 0.0), alpha) * max(n_l, 0.0);
    let glint = fresnel_dielectric(dot(to_eye, half_way), refractive_index) * lobe * sky.sun_irradiance;
    return min(glint, vec3(MAX_GLINT));
}

// What a mirror of GGX width `alpha` shows, seen from `position` (world).
fn environment(position: vec3<f32>, direction: vec3<f32>, alpha: f32) -> vec3<f32> {
    return surroundings_radiance(surroundings, position, direction, sqrt(alpha));
}
