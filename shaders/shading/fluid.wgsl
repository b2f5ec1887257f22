// Clear liquid over the opaque scene (algorithms.md 10, recommended composite): exact Fresnel, refraction marched against the
// scene's distance, Beer-Lambert with single scattering along the marched path, reflected surroundings, the sun's GGX lobe.

#import meniscus::brdf::{PI, fresnel_dielectric, ggx}
#import meniscus::camera::{Camera, project_px, px_per_world}
#import meniscus::sky::Sky
#import meniscus::surface::{NO_SURFACE, is_empty, unpack_normal}
#import meniscus::surroundings::{Surroundings, Cone, surroundings_radiance}
#import meniscus::water::{WaterPoint, water_point}

struct Fluid {
    // 1 / world unit.
    absorption: vec3<f32>,
    // 1 / world unit, the same for all channels.
    scattering: f32,
    refractive_index: f32,
    refraction_scale: f32,
    additional_reflection: f32,
    // GGX alpha of the calm surface.
    alpha: f32,
    spray: f32,
    spacing_world: f32,
    // 1 / world unit: sunlight that the water bends away, on top of what it absorbs.
    shadow_extinction: f32,
    pad_a: f32,
}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> surroundings: Surroundings;
@group(0) @binding(2) var<uniform> fluid: Fluid;
@group(0) @binding(3) var<storage, read> distances: array<f32>;
@group(0) @binding(4) var<storage, read> thicknesses: array<f32>;
@group(0) @binding(5) var<storage, read> normals: array<u32>;
@group(0) @binding(6) var scene_color: texture_2d<f32>;
@group(0) @binding(7) var scene_distance: texture_2d<f32>;
// One value per block of pixels.
@group(0) @binding(8) var<storage, read> sun_paths: array<f32>;
@group(0) @binding(9) var<storage, read_write> radiance: array<vec4<f32>>;

// Steps of the march along the refracted ray, and of the false position that refines it.
const MARCH_STEPS: i32 = 4;
const REFINE_STEPS: i32 = 2;
// Most that a refracted path may exceed the thickness along the view ray.
const MIN_PATH_COSINE: f32 = 0.3;

// Pixels per side of a block of `sun_paths`.
const BLOCK_PX: f32 = 4.0;

fn inside(px: vec2<f32>) -> bool {
    return all(px >= vec2(0.0)) && all(px < vec2<f32>(camera.size_px));
}

// How far the point lies in front of the opaque scene along the view axis, within +-`limit`; samples in front of the water
// do not count as scene, nor does what lies outside of the picture.
fn clearance(position_view: vec3<f32>, water_distance: f32, limit: f32) -> f32 {
    let px = project_px(camera, position_view);
    if !inside(px) {
        return limit;
    }
    let scene = textureLoad(scene_distance, vec2<i32>(px), 0).x;
    return select(clamp(scene + position_view.z, -limit, limit), limit, scene < water_distance);
}

// Length of the refracted path inside the water: to the opaque scene, at most `reach`.
fn trace_path(water: WaterPoint, direction: vec3<f32>, reach: f32) -> f32 {
    var near = 0.0;
    var near_gap = reach;
    var far = reach;
    var far_gap = 0.0;
    var hit = false;
    for (var i = 1; i <= MARCH_STEPS; i++) {
        let s = reach * f32(i) / f32(MARCH_STEPS);
        let gap = clearance(water.position_view + s * direction, water.distance, reach);
        if gap < 0.0 {
            far = s;
            far_gap = gap;
            hit = true;
            break;
        }
        near = s;
        near_gap = gap;
    }
    if !hit {
        return reach;
    }
    for (var i = 0; i < REFINE_STEPS; i++) {
        let s = mix(near, far, near_gap / (near_gap - far_gap));
        let gap = clearance(water.position_view + s * direction, water.distance, reach);
        if gap < 0.0 {
            far = s;
            far_gap = gap;
        } else {
            near = s;
            near_gap = gap;
        }
    }
    return mix(near, far, near_gap / (near_gap - far_gap));
}

// Scene colour around `px`, bilinear over the samples that do not lie in front of the water; alpha 0 if all do.
fn background(px: vec2<f32>, water_distance: f32) -> vec4<f32> {
    let corner = px - 0.5;
    let base = floor(corner);
    let f = corner - base;
    let last = vec2<i32>(camera.size_px) - 1;
    var sum = vec4(0.0);
    for (var k = 0; k < 4; k++) {
        let offset = vec2(k & 1, k >> 1u);
        let at = clamp(vec2<i32>(base) + offset, vec2(0), last);
        let weights = mix(1.0 - f, f, vec2<f32>(offset));
        let behind = textureLoad(scene_distance, at, 0).x >= water_distance;
        // A weight that is never quite zero keeps the quotient below defined.
        let weight = select(0.0, weights.x * weights.y + 1e-4, behind);
        sum += weight * vec4(textureLoad(scene_color, at, 0).rgb, 1.0);
    }
    if sum.a == 0.0 {
        return vec4(0.0);
    }
    return vec4(sum.rgb / sum.a, 1.0);
}

// Differences of the normals of the four neighbours to this one: sum of squares over those that are water.
fn normal_spread(pixel: vec2<u32>, normal_view: vec3<f32>) -> f32 {
    let last = camera.size_px - 1u;
    let offsets = array(vec2(-1, 0), vec2(1, 0), vec2(0, -1), vec2(0, 1));
    var sum = 0.0;
    for (var k = 0; k < 4; k++) {
        let at = vec2<u32>(clamp(vec2<i32>(pixel) + offsets[k], vec2(0), vec2<i32>(last)));
        let index = at.y * camera.size_px.x + at.x;
        if !is_empty(distances[index]) {
            let delta = unpack_normal(normals[index]) - normal_view;
            sum += dot(delta, delta);
        }
    }
    return 0.25 * sum;
}

fn to_world(direction_view: vec3<f32>) -> vec3<f32> {
    return (camera.world_from_view * vec4(direction_view, 0.0)).xyz;
}

// Length of water between the scene seen at `px` and the sun, bilinear.
fn sun_path(px: vec2<f32>) -> f32 {
    let size = vec2<i32>((camera.size_px + 3u) / 4u);
    let corner = px / BLOCK_PX - 0.5;
    let base = floor(corner);
    let f = corner - base;
    let low = clamp(vec2<i32>(base), vec2(0), size - 1);
    let high = clamp(vec2<i32>(base) + 1, vec2(0), size - 1);
    let top = mix(sun_paths[low.y * size.x + low.x], sun_paths[low.y * size.x + high.x], f.x);
    let bottom = mix(sun_paths[high.y * size.x + low.x], sun_paths[high.y * size.x + high.x], f.x);
    return mix(top, bottom, f.y);
}

// What the water between scene and sun leaves of the light on the scene seen at `px`. The scene was lit by sun and sky
// together; the sun's share is taken as that on level ground.
fn shadow(px: vec2<f32>) -> vec3<f32> {
    let path = sun_path(px);
    if path <= 0.0 {
        return vec3(1.0);
    }
    let sky = surroundings.sky;
    let sun = sky.sun_irradiance * max(dot(sky.sun_direction, sky.up), 0.0);
    let share = sun / max(sun + sky.irradiance_up, vec3(1e-30));
    let extinction = fluid.absorption + fluid.scattering + fluid.shadow_extinction;
    return 1.0 - share * (1.0 - exp2(-1.44269504 * extinction * path));
}

// Light that comes through the water: the refracted background, absorbed, and what the water scatters itself.
fn transmitted(pixel: vec2<u32>, water: WaterPoint, thickness: f32) -> vec3<f32> {
    let incident = -water.to_eye_view;
    let bent = refract(incident, water.normal_view, 1.0 / fluid.refractive_index);
    let direction = normalize(mix(incident, bent, fluid.refraction_scale));
    let reach = thickness / max(dot(direction, incident), MIN_PATH_COSINE);
    var path = 0.0;
    if reach > 0.0 {
        path = trace_path(water, direction, reach);
    }
    let exit_view = water.position_view + path * direction;

    let px = project_px(camera, exit_view);
    var behind = vec3(0.0);
    if inside(px) {
        let sample = background(px, water.distance);
        if sample.a > 0.0 {
            behind = sample.rgb;
        } else {
            behind = textureLoad(scene_color, vec2<i32>(pixel), 0).rgb;
        }
        behind *= shadow(px);
    } else {
        // Outside of the picture the objects are unknown, floor and sky are not.
        let exit_world = (camera.world_from_view * vec4(exit_view, 1.0)).xyz;
        let onwards = select(normalize(exit_view), vec3(0.0, 0.0, -1.0), camera.orthographic != 0u);
        behind = surroundings_radiance(surroundings, exit_world, to_world(onwards), Cone(1.0 / px_per_world(camera, water.distance), 0.0));
    }

    let extinction = fluid.absorption + fluid.scattering;
    let transmittance = exp2(-1.44269504 * extinction * path);
    let sky = surroundings.sky;
    // Isotropic phase function: the mean radiance around, and the sun over the full sphere.
    let light = (sky.irradiance_up + sky.irradiance_down) / (2.0 * PI) + sky.sun_irradiance / (4.0 * PI);
    let albedo = fluid.scattering / max(extinction, vec3(1e-30));
    return transmittance * behind + albedo * (1.0 - transmittance) * light;
}

// Radiance of a pixel that is all water.
fn shade(pixel: vec2<u32>, distance: f32, thickness: f32, normal_bits: u32) -> vec3<f32> {
    let water = water_point(camera, pixel, distance, normal_bits);
    let sky = surroundings.sky;
    let spread = normal_spread(pixel, water.normal_view);

    let normal = to_world(water.normal_view);
    let to_eye = to_world(water.to_eye_view);
    let position = (camera.world_from_view * vec4(water.position_view, 1.0)).xyz;

    var mirrored = reflect(-to_eye, normal);
    // A ray that leaves the upper side downwards meets the next wave, which in turn shows sky: reflect it upwards. From the
    // sides it meets the floor.
    let level = smoothstep(0.15, 0.5, dot(normal, sky.up));
    let fall = min(dot(mirrored, sky.up), 0.0);
    mirrored = normalize(mirrored - 2.0 * level * fall * sky.up);
    let px_world = 1.0 / px_per_world(camera, distance);
    let environment = surroundings_radiance(surroundings, position, mirrored, Cone(px_world, 2.0 * sqrt(spread) + fluid.alpha));

    // The curvature that a pixel hides widens the sun's lobe (Kaplanyan et al. 2016), so that glints do not flicker.
    let alpha = min(sqrt(fluid.alpha * fluid.alpha + 0.5 * spread), 0.5);
    let n_l = dot(normal, sky.sun_direction);
    var glint = vec3(0.0);
    if n_l > 0.0 {
        let half_way = normalize(sky.sun_direction + to_eye);
        let lobe = ggx(n_l, water.n_v, max(dot(normal, half_way), 0.0), alpha);
        glint = fresnel_dielectric(dot(to_eye, half_way), fluid.refractive_index) * lobe * n_l * sky.sun_irradiance;
    }

    let fresnel = mix(fresnel_dielectric(water.n_v, fluid.refractive_index), 1.0, fluid.additional_reflection);
    let through = transmitted(pixel, water, thickness);
    var color = mix(through, environment, fresnel) + min(glint, vec3(40.0));

    // Thin and strongly curved is spray: many small drops scatter like a white diffuser. The cosine takes back the turning
    // that is only foreshortening, at silhouettes.
    let per_spacing = fluid.spacing_world / px_world;
    let turn = sqrt(spread) * per_spacing * water.n_v;
    let thin = exp2(-thickness / (3.0 * max(fluid.spacing_world, 1e-30)));
    let white = fluid.spray * thin * smoothstep(0.4, 1.5, turn);
    let facing_up = 0.5 + 0.5 * dot(normal, sky.up);
    let diffuse = mix(sky.irradiance_down, sky.irradiance_up, facing_up) + (0.5 + 0.5 * n_l) * sky.sun_irradiance;
    return mix(color, diffuse / PI, white);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= camera.size_px) {
        return;
    }
    let index = id.y * camera.size_px.x + id.x;
    var scene = textureLoad(scene_color, id.xy, 0);
    let reach = textureLoad(scene_distance, id.xy, 0).x;
    let distance = distances[index];
    let thickness = thicknesses[index];
    let wet = !is_empty(distance) && thickness > 0.0 && distance < reach;
    let coverage = select(0.0, smoothstep(0.0, max(0.2 * fluid.spacing_world, 1e-30), thickness), wet);
    if coverage < 1.0 {
        scene *= vec4(shadow(vec2<f32>(id.xy) + 0.5), 1.0);
    }
    if !wet {
        radiance[index] = scene;
        return;
    }
    let water = shade(id.xy, distance, thickness, normals[index]);
    // Less than a fraction of a particle is a soft edge, not water.
    radiance[index] = mix(scene, vec4(water, 1.0), coverage);
}
