// The composite of VTK's vtkOpenGLFluidMapper, for pictures side by side: Schlick's Fresnel, Beer-Lambert by thickness, the
// background shifted by the refracted direction, a mirror of the environment, one Phong highlight. Nothing hides what
// lies in front of the water from refraction, and edges are hard: that is the model. OPAQUE: an opaque surface instead of a volume.

#define_import_path meniscus::model

#import meniscus::body::irradiance
#import meniscus::brdf::{PI, fifth_power}
#import meniscus::lighting_inputs::{camera, surroundings, distance_at, thickness_at, normal_at, scene_color, attribute_color, point_to_world, to_world}
#import meniscus::reflection::environment
#import meniscus::refraction::background
#import meniscus::water::water_point

struct Vtk {
    // 1 / world unit.
    attenuation: vec3<f32>,
    refractive_index: f32,
    color: vec3<f32>,
    refraction_scale: f32,
    additional_reflection: f32,
    particle_color_power: f32,
    particle_color_scale: f32,
    // What attenuates where an attribute colours the water, 1 / world unit.
    dye_per_world: f32,
    // Of the twin; here it is OPAQUE.
    is_opaque: u32,
    pad_a: u32,
    pad_b: u32,
    pad_c: u32,
}

@group(0) @binding(2) var<uniform> model: Vtk;

// The cosine to the power of VTK's shininess, 150, by squaring: a power takes software drivers ten times as long.
fn highlight(cosine: f32) -> f32 {
    let c2 = cosine * cosine;
    let c4 = c2 * c2;
    let c16 = c4 * c4 * c4 * c4;
    let c64 = c16 * c16 * c16 * c16;
    return c64 * c64 * c16 * c4 * c2;
}

// What attenuates the light in water of this colour; alpha is how much of the water's own it replaces.
fn attenuation(tint: vec4<f32>) -> vec3<f32> {
#ifdef COLORED
    let dye = 1.0 - pow(max(tint.rgb, vec3(1e-6)), vec3(model.particle_color_power)) * model.particle_color_scale;
    return mix(model.attenuation, max(dye, vec3(0.0)) * model.dye_per_world, tint.a);
#else
    return model.attenuation;
#endif
}

// Where there is no water.
fn scene_radiance(pixel: vec2<u32>) -> vec4<f32> {
    return textureLoad(scene_color, pixel, 0);
}

fn water_radiance(pixel: vec2<u32>) -> vec4<f32> {
    let sky = surroundings.sky;
    let water = water_point(camera, pixel, distance_at(pixel), normal_at(pixel));
    let normal = to_world(water.normal_view);
    let to_eye = to_world(water.to_eye_view);
    let tint = attribute_color(pixel);

    // The sun in place of VTK's lights, the sky in place of its ambient term.
    let mirrored = reflect(-to_eye, normal);
    let glint = highlight(max(dot(mirrored, sky.sun_direction), 0.0)) * sky.sun_irradiance / PI;
#ifdef OPAQUE
    let color = mix(model.color, tint.rgb, tint.a);
    return vec4(color * irradiance(sky, normal) / PI + glint, 1.0);
#else
    let f0 = (1.0 - model.refractive_index) / (1.0 + model.refractive_index);
    let schlick = f0 * f0 + (1.0 - f0 * f0) * fifth_power(1.0 - water.n_v);
    let fresnel = mix(schlick, 1.0, model.additional_reflection);
    let bent = refract(-water.to_eye_view, water.normal_view, 1.0 / model.refractive_index);
    let shift = vec2(bent.x, -bent.y) * model.refraction_scale * vec2<f32>(camera.size_px);
    let at_px = clamp(vec2<f32>(pixel) + 0.5 + shift, vec2(0.0), vec2<f32>(camera.size_px));
    let behind = background(at_px, 0.0, textureLoad(scene_color, pixel, 0).rgb);
    let through = exp2(-1.44269504 * attenuation(tint) * thickness_at(pixel)) * behind;
    let mirror = environment(point_to_world(water.position_view), mirrored, 0.0);
    return vec4(mix(through, mirror, fresnel) + glint, 1.0);
#endif
}
