// Lambert's law on a veil of water over the scene straight behind, with the highlight of Blinn 1977: the cheapest model. Without
// the highlight it is `lambert`.

#define_import_path meniscus::model

#import meniscus::brdf::PI
#import meniscus::lighting_inputs::{camera, surroundings, distance_at, thickness_at, normal_at, scene_color, attribute_color, coverage, to_world}
#import meniscus::medium::{Medium, veiled}
#import meniscus::water::water_point

struct BlinnPhong {
    medium: Medium,
    color: vec3<f32>,
    spacing_world: f32,
    specular: f32,
    shininess: f32,
    pad_a: f32,
    pad_b: f32,
}

@group(0) @binding(2) var<uniform> model: BlinnPhong;

// Where there is no water.
fn scene_radiance(pixel: vec2<u32>) -> vec4<f32> {
    return textureLoad(scene_color, pixel, 0);
}

fn water_radiance(pixel: vec2<u32>) -> vec4<f32> {
    let scene = textureLoad(scene_color, pixel, 0);
    let sky = surroundings.sky;
    let thickness = thickness_at(pixel);
    let water = water_point(camera, pixel, distance_at(pixel), normal_at(pixel));
    let normal = to_world(water.normal_view);
    let body = veiled(model.medium, sky, normal, scene.rgb, thickness, model.color, attribute_color(pixel));
    let between = sky.sun_direction + to_world(water.to_eye_view);
    let n_h = max(dot(normal, between / max(length(between), 1e-6)), 0.0);
    let lit = select(0.0, pow(n_h, model.shininess), dot(normal, sky.sun_direction) > 0.0);
    let color = body + model.specular * lit * sky.sun_irradiance / PI;
    return mix(scene, vec4(color, 1.0), coverage(thickness, model.spacing_world));
}
