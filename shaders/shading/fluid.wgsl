// Clear liquid over the opaque scene (algorithms.md 10, recommended composite): exact Fresnel, refraction marched against the
// scene's distance, Beer-Lambert with single scattering along the marched path, reflected surroundings, the sun's GGX lobe.

#import meniscus::brdf::{PI, fresnel_dielectric, ggx}
#import meniscus::camera::{Camera, project_px, px_per_world, towards_eye, view_position}
#import meniscus::surface::{is_empty, unpack_normal}
#import meniscus::surroundings::{Surroundings, surroundings_radiance, trace_floor}
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

// Steps of the march along the refracted ray.
const MARCH_STEPS: i32 = 4;
// Halvings of a step in which the ray passes from in front of the scene to behind it.
const BISECTIONS: i32 = 4;
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

// As `clearance`, with the scene interpolated between pixels: without it, refracted lines are ragged. The reciprocal distance
// is linear over the picture of a plane, in parallel projection the distance itself.
fn smooth_clearance(position_view: vec3<f32>, water_distance: f32, limit: f32) -> f32 {
    let px = project_px(camera, position_view);
    if !inside(px) {
        return limit;
    }
    let base = floor(px - 0.5);
    let f = px - 0.5 - base;
    let last = vec2<i32>(camera.size_px) - 1;
    let low = clamp(vec2<i32>(base), vec2(0), last);
    let high = clamp(vec2<i32>(base) + 1, vec2(0), last);
    let d = vec4(
        textureLoad(scene_distance, low, 0).x,
        textureLoad(scene_distance, vec2(high.x, low.y), 0).x,
        textureLoad(scene_distance, vec2(low.x, high.y), 0).x,
        textureLoad(scene_distance, high, 0).x,
    );
    let weights = vec4((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);
    let scene = select(1.0 / max(dot(weights, 1.0 / d), 1e-30), dot(weights, min(d, vec4(1e30))), camera.orthographic != 0u);
    return select(clamp(scene + position_view.z, -limit, limit), limit, any(d < vec4(water_distance)));
}

// Where the march along the refracted ray ends.
struct March {
    // Length of the path inside the water: to the opaque scene, at most `reach`.
    length_world: f32,
    // How far along the path the scene's picture shows what lies ahead, at most `length_world`: beyond, an object hides it.
    seen_world: f32,
}

// From where the scene is behind the ray to where it is in front, it is met, or its silhouette is crossed and the ray goes on
// behind it: bisection tells these apart, since only at a silhouette the gap stays as large as it was.
fn trace_path(water: WaterPoint, direction: vec3<f32>, reach: f32) -> March {
    let step_world = reach / f32(MARCH_STEPS);
    var seen = 0.0;
    var seen_gap = reach;
    var hidden = false;
    for (var i = 1; i <= MARCH_STEPS; i++) {
        let end = step_world * f32(i);
        let end_gap = clearance(water.position_view + end * direction, water.distance, reach);
        if end_gap < 0.0 && !hidden {
            var far = end;
            var far_gap = end_gap;
            for (var k = 0; k < BISECTIONS; k++) {
                let middle = 0.5 * (seen + far);
                let gap = clearance(water.position_view + middle * direction, water.distance, reach);
                if gap < 0.0 {
                    far = middle;
                    far_gap = gap;
                } else {
                    seen = middle;
                    seen_gap = gap;
                }
            }
            if seen_gap - far_gap <= 0.5 * step_world {
                // False position, then Newton's step on the interpolated scene with the slope found so far.
                let per_gap = (far - seen) / (seen_gap - far_gap);
                let s = seen + seen_gap * per_gap;
                let gap = smooth_clearance(water.position_view + s * direction, water.distance, reach);
                let met = clamp(s + gap * per_gap, seen, far);
                return March(met, met);
            }
        }
        hidden = end_gap < 0.0;
        if !hidden {
            seen = end;
            seen_gap = end_gap;
        }
    }
    return March(reach, seen);
}

// Scene colour around `px`, bilinear over the samples no nearer than `nearest_distance`; `fallback` if all are.
fn background(px: vec2<f32>, nearest_distance: f32, fallback: vec3<f32>) -> vec3<f32> {
    let corner = px - 0.5;
    let base = floor(corner);
    let f = corner - base;
    let last = vec2<i32>(camera.size_px) - 1;
    var sum = vec4(0.0);
    for (var k = 0; k < 4; k++) {
        let offset = vec2(k & 1, k >> 1u);
        let at = clamp(vec2<i32>(base) + offset, vec2(0), last);
        let weights = mix(1.0 - f, f, vec2<f32>(offset));
        let behind = textureLoad(scene_distance, at, 0).x >= nearest_distance;
        // A weight that is never quite zero keeps the quotient below defined.
        let weight = select(0.0, weights.x * weights.y + 1e-4, behind);
        sum += weight * vec4(textureLoad(scene_color, at, 0).rgb, 1.0);
    }
    return select(fallback, sum.rgb / max(sum.a, 1e-4), sum.a > 0.0);
}

// Share of a spacing over which normals are compared and averaged: finer detail is not in the particles, it is noise.
const STENCIL_SPACINGS: f32 = 0.3;
const MAX_STENCIL_PX: f32 = 4.0;
// Squared difference that stands for a neighbour on another surface: at an edge the normal is uncertain.
const EDGE_SPREAD: f32 = 0.5;
// How far around a pixel other water makes it part of something larger than a drop.
const DROP_SPACINGS: f32 = 1.6;
const MAX_DROP_PX: f32 = 64.0;

// The normals around a pixel.
struct Neighbourhood {
    // Sum over this pixel and those of its four neighbours that lie on the same surface.
    normal_sum: vec3<f32>,
    // Mean squared difference of the neighbours' to this pixel's.
    spread: f32,
    // 1: everything around lies behind, as around a drop; about 0.5 at a straight edge, 0 within a surface.
    isolation: f32,
}

fn neighbourhood(pixel: vec2<u32>, distance: f32) -> Neighbourhood {
    let spacing_px = fluid.spacing_world * px_per_world(camera, distance);
    let stride_px = floor(clamp(STENCIL_SPACINGS * spacing_px, 1.0, MAX_STENCIL_PX));
    let last = vec2<i32>(camera.size_px) - 1;
    let offsets = array(vec2(-1, 0), vec2(1, 0), vec2(0, -1), vec2(0, 1));
    let center = unpack_normal(normals[pixel.y * camera.size_px.x + pixel.x]);
    var sum = center;
    var spread = 0.0;
    for (var k = 0; k < 4; k++) {
        let at = vec2<u32>(clamp(vec2<i32>(pixel) + i32(stride_px) * offsets[k], vec2(0), last));
        let index = at.y * camera.size_px.x + at.x;
        let same = abs(distances[index] - distance) <= 2.0 * fluid.spacing_world;
        let normal = select(center, unpack_normal(normals[index]), same);
        let delta = normal - center;
        sum += normal;
        spread += 0.25 * select(EDGE_SPREAD, dot(delta, delta), same);
    }
    let far_px = i32(clamp(DROP_SPACINGS * spacing_px, 2.0, MAX_DROP_PX));
    // Half way between normal and view: neither the slant of level water counts nor the curvature of the drop itself.
    let position = view_position(camera, vec2<f32>(pixel) + 0.5, distance);
    let half_way = sum / max(length(sum), 1e-3) + towards_eye(camera, position);
    let plane = half_way / max(length(half_way), 1e-3);
    var isolation = 0.0;
    for (var k = 0; k < 4; k++) {
        let at = vec2<u32>(clamp(vec2<i32>(pixel) + far_px * offsets[k], vec2(0), last));
        let other = min(distances[at.y * camera.size_px.x + at.x], 2.0 * distance);
        let below = dot(plane, position - view_position(camera, vec2<f32>(at) + 0.5, other));
        isolation += 0.25 * clamp(below / max(fluid.spacing_world, 1e-6 * distance) - 1.0, 0.0, 1.0);
    }
    return Neighbourhood(sum, spread, isolation);
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

// Share of sunlight that the deepest shadow of water takes.
const MAX_SHADOW: f32 = 0.55;
// How much of the water's tint its shadow has.
const SHADOW_TINT: f32 = 0.7;

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
    // Waves focus as much light as they take away, and light comes in from all sides: a good part always arrives.
    let grey = dot(fluid.absorption, vec3(1.0 / 3.0));
    let extinction = mix(vec3(grey), fluid.absorption, SHADOW_TINT) + fluid.scattering + fluid.shadow_extinction;
    return 1.0 - MAX_SHADOW * share * (1.0 - exp2(-1.44269504 * extinction * path));
}

fn to_world(direction_view: vec3<f32>) -> vec3<f32> {
    return (camera.world_from_view * vec4(direction_view, 0.0)).xyz;
}

// The refracted path in the water.
struct Path {
    length_world: f32,
    // From its end on to the floor; huge if it does not lead there.
    to_floor_world: f32,
    // Picture point where it ends, as far as it can be seen.
    end_px: vec2<f32>,
    // What lies nearer there is in front of the water or of the end.
    nearest_distance: f32,
}

fn refracted_path(water: WaterPoint, thickness: f32) -> Path {
    let incident = -water.to_eye_view;
    let bent = refract(incident, water.normal_view, 1.0 / fluid.refractive_index);
    let direction = normalize(mix(incident, bent, fluid.refraction_scale));
    // The floor is known exactly, and better not left to the march: from a grazing view its first step may end so deep below
    // the floor that the floor seen there lies in front of the water.
    let position = (camera.world_from_view * vec4(water.position_view, 1.0)).xyz;
    let floor_reach = trace_floor(surroundings, position, to_world(direction));
    let reach = min(max(thickness, 0.0) / max(dot(direction, incident), MIN_PATH_COSINE), floor_reach);
    let march = trace_path(water, direction, reach);
    // What lies outside of the picture is not known: its border stands for it.
    let end = water.position_view + march.seen_world * direction;
    let end_px = clamp(project_px(camera, end), vec2(0.0), vec2<f32>(camera.size_px));
    let tolerance = select(fluid.spacing_world + 0.25 * march.seen_world, 0.0, march.seen_world < march.length_world);
    let nearest_distance = max(water.distance, -end.z - tolerance);
    return Path(march.length_world, floor_reach - march.length_world, end_px, nearest_distance);
}

// Share of diffuse light that a surface of water reflects back down.
const INTERNAL_REFLECTANCE: f32 = 0.48;
// How much of that is applied: a finite body of water lets light out at its sides.
const WET_SHARE: f32 = 0.7;

// How much darker the floor looks where the water at the end of the path wets it: light that it scatters is reflected back at
// the water's surface and meets it again (Lekner & Dorf 1988). Water ends at the floor only to within its
// resolution.
fn wet(path: Path) -> f32 {
    // Without colour: what comes back is tinted by the water, which the path accounts for.
    let albedo = dot(surroundings.floor.color, vec3(1.0 / 3.0));
    let ratio = (1.0 - INTERNAL_REFLECTANCE) / (1.0 - INTERNAL_REFLECTANCE * albedo);
    let near = fluid.spacing_world + 0.2 * path.length_world;
    // Soft where the water begins, so that the scallops of single particles do not show.
    let begin = smoothstep(0.0, 1.5 * fluid.spacing_world + 1e-30, path.length_world);
    let contact = WET_SHARE * begin * (1.0 - smoothstep(near, 2.0 * near + 1e-30, path.to_floor_world));
    return mix(1.0, ratio, contact);
}

// Light that comes through the water: the background, absorbed, and what the water scatters itself.
fn transmitted(behind: vec3<f32>, path_world: f32) -> vec3<f32> {
    let extinction = fluid.absorption + fluid.scattering;
    let transmittance = exp2(-1.44269504 * extinction * path_world);
    let sky = surroundings.sky;
    // Isotropic phase function: the mean radiance around, and the sun over the full sphere.
    let light = (sky.irradiance_up + sky.irradiance_down) / (2.0 * PI) + sky.sun_irradiance / (4.0 * PI);
    let albedo = fluid.scattering / max(extinction, vec3(1e-30));
    return transmittance * behind + albedo * (1.0 - transmittance) * light;
}

// Brightest glint, enough to come out white.
const MAX_GLINT: f32 = 6.0;

// Radiance of a pixel that is all water, with `through` as the light that comes through it.
fn shade(water: WaterPoint, around: Neighbourhood, through: vec3<f32>) -> vec3<f32> {
    let sky = surroundings.sky;
    let normal = to_world(water.normal_view);
    let to_eye = to_world(water.to_eye_view);
    let position = (camera.world_from_view * vec4(water.position_view, 1.0)).xyz;

    var mirrored = reflect(-to_eye, normal);
    // A ray that leaves the upper side downwards meets the next wave, which in turn shows sky: reflect it upwards. From the
    // sides it meets the floor.
    let level = smoothstep(0.15, 0.5, dot(normal, sky.up));
    let fall = min(dot(mirrored, sky.up), 0.0);
    mirrored = normalize(mirrored - 2.0 * level * fall * sky.up);
    let environment = surroundings_radiance(surroundings, position, mirrored);

    // The variance of the normals widens the sun's lobe (Kaplanyan et al. 2016), so that noise does not become speckle. At
    // grazing view the lobe is fed by the rims of single particles: fade it.
    let drop = smoothstep(0.65, 1.0, around.isolation);
    let alpha = min(sqrt(fluid.alpha * fluid.alpha + (0.5 - 0.4 * drop) * around.spread), 0.6);
    let facing = smoothstep(0.15, 0.5, water.n_v);
    let n_l = dot(normal, sky.sun_direction);
    let half_way = normalize(sky.sun_direction + to_eye);
    let lobe = ggx(max(n_l, 1e-3), water.n_v, max(dot(normal, half_way), 0.0), alpha) * max(n_l, 0.0);
    let glint = fresnel_dielectric(dot(to_eye, half_way), fluid.refractive_index) * lobe * sky.sun_irradiance;

    // Uncertain normals have a larger root mean square cosine: reflectance at edges is not that of a mirror seen edge on.
    let cosine = min(sqrt(water.n_v * water.n_v + 0.2 * around.spread), 1.0);
    let fresnel = mix(fresnel_dielectric(cosine, fluid.refractive_index), 1.0, fluid.additional_reflection);
    let clear = mix(through, environment, fresnel) + facing * min(glint, vec3(MAX_GLINT));

    // Single particles stand for many small drops, which scatter like a white diffuser.
    let white = fluid.spray * drop;
    let facing_up = 0.5 + 0.5 * dot(normal, sky.up);
    let diffuse = mix(sky.irradiance_down, sky.irradiance_up, facing_up) + (0.3 + 0.7 * max(n_l, 0.0)) * sky.sun_irradiance;
    return mix(clear, diffuse / PI, white);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= camera.size_px) {
        return;
    }
    let index = id.y * camera.size_px.x + id.x;
    let here_px = vec2<f32>(id.xy) + 0.5;
    let scene = textureLoad(scene_color, id.xy, 0);
    let thickness = thicknesses[index];
    let distance = distances[index];
    if is_empty(distance) || thickness <= 0.0 || distance >= textureLoad(scene_distance, id.xy, 0).x {
        radiance[index] = scene * vec4(shadow(here_px), 1.0);
        return;
    }
    // The mean normal: differences between single pixels are mostly noise, which refraction would magnify.
    let around = neighbourhood(id.xy, distance);
    let water = water_point(camera, id.xy, distance, around.normal_sum);
    let path = refracted_path(water, thickness);
    let dim = shadow(path.end_px);
    let through = transmitted(dim * wet(path) * background(path.end_px, path.nearest_distance, scene.rgb), path.length_world);
    let color = shade(water, around, through);
    // Less than a fraction of a particle is a soft edge, not water.
    let coverage = smoothstep(0.0, max(0.5 * fluid.spacing_world, 1e-30), thickness);
    radiance[index] = mix(scene * vec4(dim, 1.0), vec4(color, 1.0), coverage);
}
