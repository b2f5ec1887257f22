// Lambert's law on a veil of water over the scene straight behind, with the highlight of Blinn 1977: the cheapest model. Without
// the highlight it is `lambert`.

#import meniscus::brdf::PI
#import meniscus::lighting_inputs::{camera, surroundings, distances, thicknesses, normals, scene_color, radiance, attribute_color, coverage, pixel_index, shows_water, to_world}
#import meniscus::medium::{Medium, veiled}
#import meniscus::surface::unpack_normal
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

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= camera.size_px) {
        return;
    }
    let index = pixel_index(id.xy);
    let scene = textureLoad(scene_color, id.xy, 0);
    if !shows_water(id.xy) {
        radiance[index] = scene;
        return;
    }
    let sky = surroundings.sky;
    let thickness = thicknesses[index];
    let water = water_point(camera, id.xy, distances[index], unpack_normal(normals[index]));
    let normal = to_world(water.normal_view);
    let body = veiled(model.medium, sky, normal, scene.rgb, thickness, model.color, attribute_color(id.xy));
    let between = sky.sun_direction + to_world(water.to_eye_view);
    let n_h = max(dot(normal, between / max(length(between), 1e-6)), 0.0);
    let lit = select(0.0, pow(n_h, model.shininess), dot(normal, sky.sun_direction) > 0.0);
    let color = body + model.specular * lit * sky.sun_irradiance / PI;
    radiance[index] = mix(scene, vec4(color, 1.0), coverage(thickness, model.spacing_world));
}
