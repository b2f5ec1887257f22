#define_import_path meniscus::body

#import meniscus::brdf::PI
#import meniscus::sky::Sky

// Bodies of water that light does not get through.

// From the sky on a surface that faces `normal`.
fn ambient(sky: Sky, normal: vec3<f32>) -> vec3<f32> {
    return mix(sky.irradiance_down, sky.irradiance_up, 0.5 + 0.5 * dot(normal, sky.up));
}

// From sun and sky.
fn irradiance(sky: Sky, normal: vec3<f32>) -> vec3<f32> {
    return ambient(sky, normal) + max(dot(normal, sky.sun_direction), 0.0) * sky.sun_irradiance;
}

// As `irradiance` for light that enters and leaves elsewhere: it reaches around the body's own shadow by `softness` in
// [0, 1], and the lit side loses what the other one gains.
fn soft_irradiance(sky: Sky, normal: vec3<f32>, softness: f32) -> vec3<f32> {
    let wide = 1.0 + softness;
    let lit = max(dot(normal, sky.sun_direction) + softness, 0.0) / (wide * wide);
    return ambient(sky, normal) + lit * sky.sun_irradiance;
}

// How soft the light is on a body whose colour stands for a number.
const LEGEND_SOFTNESS: f32 = 0.5;

// Radiance of a body that an attribute colours.
fn colored_body(sky: Sky, color: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    return color * soft_irradiance(sky, normal, LEGEND_SOFTNESS) / PI;
}

// How much of the water an attribute's colour hides, and how much of mirror and glint is left over it: the colour is there
// to be read.
const COLOR_OPACITY: f32 = 0.95;
const COLOR_MIRROR: f32 = 0.5;

// `through`, the light that comes through the water, where an attribute colours it with `tint`.
fn tinted(sky: Sky, through: vec3<f32>, tint: vec4<f32>, normal: vec3<f32>) -> vec3<f32> {
    return mix(through, colored_body(sky, tint.rgb, normal), COLOR_OPACITY * tint.a);
}
