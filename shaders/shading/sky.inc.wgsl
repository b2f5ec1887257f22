#define_import_path meniscus::sky

// An analytic clear sky: exponential change from haze to zenith and a glow around the sun. The disc itself is left to the
// sun's specular lobes. Radiance, linear Rec. 709.

struct Sky {
    // Unit, towards the sun, world.
    sun_direction: vec3<f32>,
    glow: f32,
    // On a surface that faces the sun.
    sun_irradiance: vec3<f32>,
    pad_a: f32,
    zenith: vec3<f32>,
    pad_b: f32,
    horizon: vec3<f32>,
    pad_c: f32,
    // Below the horizon, where there is no floor.
    ground: vec3<f32>,
    pad_d: f32,
    // Irradiance from the upper and the lower half of the surroundings.
    irradiance_up: vec3<f32>,
    pad_e: f32,
    irradiance_down: vec3<f32>,
    pad_f: f32,
    // Unit, against gravity, world.
    up: vec3<f32>,
    pad_g: f32,
}

// Radiance from the unit direction; below the horizon it is that of the horizon under the same azimuth.
fn sky_radiance(sky: Sky, direction: vec3<f32>) -> vec3<f32> {
    let height = max(dot(direction, sky.up), 0.0);
    let haze = exp2(-5.0 * height);
    let gradient = mix(sky.zenith, sky.horizon, haze);
    // Forward scattering: two powers of the cosine, by squaring.
    let c = max(dot(direction, sky.sun_direction), 0.0);
    let c2 = c * c;
    let c4 = c2 * c2;
    let c8 = c4 * c4;
    let c32 = c8 * c8 * c8 * c8;
    let c128 = c32 * c32 * c32 * c32;
    let glow = sky.glow * (0.035 * c4 + 0.05 * c32 + 0.22 * c128);
    return gradient + glow * sky.sun_irradiance;
}

// `sky` (from `sky_radiance`), but ground below the horizon, with a narrow transition.
fn sky_and_ground_radiance(s: Sky, direction: vec3<f32>, sky: vec3<f32>) -> vec3<f32> {
    let below = smoothstep(0.0, 1.0, clamp(-12.0 * dot(direction, s.up), 0.0, 1.0));
    return mix(sky, s.ground, below);
}
