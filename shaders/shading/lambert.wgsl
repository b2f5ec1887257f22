// Lambert's law on a veil of water over the scene straight behind: the cheapest model.

#import meniscus::lighting_inputs::{camera, surroundings, distances, thicknesses, normals, scene_color, radiance, attribute_color, coverage, pixel_index, shows_water, to_world}
#import meniscus::medium::{Medium, veiled}
#import meniscus::surface::unpack_normal
#import meniscus::water::water_point

struct Lambert {
    medium: Medium,
    color: vec3<f32>,
    spacing_world: f32,
}

@group(0) @binding(2) var<uniform> model: Lambert;

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
    let thickness = thicknesses[index];
    let water = water_point(camera, id.xy, distances[index], unpack_normal(normals[index]));
    let normal = to_world(water.normal_view);
    let color = veiled(model.medium, surroundings.sky, normal, scene.rgb, thickness, model.color, attribute_color(id.xy));
    radiance[index] = mix(scene, vec4(color, 1.0), coverage(thickness, model.spacing_world));
}
