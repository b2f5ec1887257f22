#define_import_path meniscus::lit
#import meniscus::brdf::{burley_diffuse, fifth_power, ggx}
#import meniscus::material::Material
#import meniscus::sky::Sky

// Radiance of an opaque surface under sun and sky towards `to_eye` (unit); `sunlit` is the share of the sun that it sees.
fn lit(sky: Sky, sunlit: f32, material: Material, tone: f32, normal: vec3<f32>, to_eye: vec3<f32>) -> vec3<f32> {
    let base = material.color * tone;
    let f0 = mix(vec3(0.04), base, material.metallic);
    let diffuse = base * (1.0 - material.metallic);
    let n_v = max(dot(normal, to_eye), 1e-3);
    let alpha = max(material.roughness * material.roughness, 2e-3);

    let n_l = max(dot(normal, sky.sun_direction), 0.0);
    let half_way = normalize(sky.sun_direction + to_eye);
    let l_h = max(dot(sky.sun_direction, half_way), 0.0);
    let fresnel = f0 + (1.0 - f0) * fifth_power(1.0 - l_h);
    let specular = fresnel * ggx(max(n_l, 1e-3), n_v, max(dot(normal, half_way), 0.0), alpha);
    let sun = (diffuse * burley_diffuse(n_l, n_v, l_h, material.roughness) + specular) * n_l * sunlit * sky.sun_irradiance;

    let facing_up = 0.5 + 0.5 * dot(normal, sky.up);
    let ambient = mix(sky.irradiance_down, sky.irradiance_up, facing_up);
    // Environment specular: the analytic fit of the GGX split sum by Karis 2014, with the ambient as environment.
    let c = vec4(-1.0, -0.0275, -0.572, 0.022) * material.roughness + vec4(1.0, 0.0425, 1.04, -0.04);
    let a = min(c.x * c.x, exp2(-9.28 * n_v)) * c.x + c.y;
    let scale_bias = vec2(-1.04, 1.04) * a + c.zw;
    return sun + (diffuse + f0 * scale_bias.x + scale_bias.y) * ambient * 0.318309886;
}
