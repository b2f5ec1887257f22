#define_import_path meniscus::medium

#import meniscus::body::{COLOR_OPACITY, irradiance}
#import meniscus::brdf::PI
#import meniscus::sky::Sky

// What fills the water: it absorbs and scatters.
struct Medium {
    // 1 / world unit.
    absorption: vec3<f32>,
    // 1 / world unit, the same for all channels.
    scattering: f32,
}

// Share of light that goes straight through (Beer-Lambert).
fn transmittance(medium: Medium, path_world: f32) -> vec3<f32> {
    return exp2(-1.44269504 * (medium.absorption + medium.scattering) * path_world);
}

// Light that comes through the water below a surface with this normal: what is behind, attenuated, and what the water
// scatters itself.
fn transmitted(medium: Medium, sky: Sky, normal: vec3<f32>, behind: vec3<f32>, path_world: f32) -> vec3<f32> {
    let through = transmittance(medium, path_world);
    // Isotropic phase function: the mean radiance around, and the sun over the full sphere. Where light gets no further than
    // a little way, only what falls on the surface counts, as on a diffuse body.
    let around = (sky.irradiance_up + sky.irradiance_down) / (2.0 * PI) + sky.sun_irradiance / (4.0 * PI);
    let density = 1.0 - exp2(-1.44269504 * medium.scattering * path_world);
    let light = mix(around, irradiance(sky, normal) / PI, smoothstep(0.3, 1.0, density));
    let albedo = medium.scattering / max(medium.absorption + medium.scattering, vec3(1e-30));
    return through * behind + albedo * (1.0 - through) * light;
}

// The plain way: the scene straight behind, veiled by a diffuse body of this colour.
fn veiled(medium: Medium, sky: Sky, normal: vec3<f32>, behind: vec3<f32>, path_world: f32, color: vec3<f32>, tint: vec4<f32>) -> vec3<f32> {
    let through = transmittance(medium, path_world) * (1.0 - COLOR_OPACITY * tint.a);
    let body = mix(color, tint.rgb, tint.a) * irradiance(sky, normal) / PI;
    return mix(body, behind, through);
}
