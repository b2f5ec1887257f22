#define_import_path meniscus::refraction

#import meniscus::camera::{project_px, view_position}
#import meniscus::lighting_inputs::{camera, scene_color, scene_distance, surroundings, to_world, point_to_world}
#import meniscus::scene_march::{Crossing, clearance, inside, meeting, narrowed}
#import meniscus::surroundings::trace_floor
#import meniscus::water::WaterPoint

// Where light that comes through the water comes from: the refracted ray, marched against the scene's distance.

// Steps of the march along the refracted ray.
const MARCH_STEPS: i32 = 4;
// Most that a refracted path may exceed the thickness along the view ray.
const MIN_PATH_COSINE: f32 = 0.3;
// More is no water; paths stay finite.
const MAX_THICKNESS: f32 = 1e30;

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
        let end_gap = clearance(water.position_view + end * direction, reach);
        if end_gap < 0.0 && !hidden {
            let wide = Crossing(seen, seen_gap, end, end_gap);
            let crossing = narrowed(water.position_view, direction, wide, reach);
            seen = crossing.seen;
            seen_gap = crossing.seen_gap;
            if seen_gap - crossing.far_gap <= 0.5 * step_world {
                let met = meeting(water.position_view, direction, crossing, reach);
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

#ifdef OBJECTS
fn scene_point(pixel: vec2<i32>) -> vec3<f32> {
    return view_position(camera, vec2<f32>(pixel) + 0.5, textureLoad(scene_distance, pixel, 0).x);
}

fn shorter(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return select(b, a, dot(a, a) < dot(b, b));
}

// Length along the ray to the plane of the scene that is seen through the water's pixel, at most `reach`; that where the plane is
// not met.
fn reach_to_plane(water: WaterPoint, direction: vec3<f32>, reach: f32) -> f32 {
    let last = vec2<i32>(camera.size_px) - 1;
    let at = max(min(max(vec2<i32>(project_px(camera, water.position_view)), vec2(1)), last - 1), vec2(0));
    let here = scene_point(at);
    // Of both sides the one that is not beyond a silhouette.
    let right = shorter(scene_point(min(at + vec2(1, 0), last)) - here, here - scene_point(max(at - vec2(1, 0), vec2(0))));
    let below = shorter(scene_point(min(at + vec2(0, 1), last)) - here, here - scene_point(max(at - vec2(0, 1), vec2(0))));
    let normal = cross(right, below);
    let length = dot(normal, here - water.position_view) / dot(normal, direction);
    // This way round, no plane and one in infinity are not met.
    return select(reach, length, length > 0.0 && length < reach);
}

// Where nothing is known, outside of the picture, the ground is taken to go on as it is in the water's pixel.
fn march_to_ground(water: WaterPoint, direction: vec3<f32>, reach: f32) -> March {
    let march = trace_path(water, direction, reach);
    if inside(project_px(camera, water.position_view + march.length_world * direction)) {
        return march;
    }
    let to_plane = reach_to_plane(water, direction, reach);
    return March(min(march.length_world, to_plane), min(march.seen_world, to_plane));
}
#endif

// What a pixel of water covers of the picture of the scene: vectors along its longer and its shorter side, pixels.
struct Footprint {
    along: vec2<f32>,
    beside: vec2<f32>,
}

// From this length of its longer side on, a footprint is sampled as such; below, bilinear sampling is as good.
const WIDE_PX: f32 = 1.5;
// Longer ones are cut: they come from normals that jump.
const MOST_PX: f32 = 64.0;

// Scene colour over a footprint around `px`, by four samples no two of which lie in one row or column of it, or bilinear, of what
// is no nearer than `nearest_distance`; `fallback` if all is. Without objects nothing lies in front of anything.
fn background_over(px: vec2<f32>, footprint: Footprint, nearest_distance: f32, fallback: vec3<f32>) -> vec3<f32> {
    let corner = px - 0.5;
    let base = floor(corner);
    let f = corner - base;
    let last = vec2<i32>(camera.size_px) - 1;
    let is_wide = dot(footprint.along, footprint.along) > WIDE_PX * WIDE_PX;
    var sum = vec4(0.0);
    for (var k = 0; k < 4; k++) {
        let offset = vec2<f32>(vec2(k & 1, k >> 1u));
        let bilinear = mix(1.0 - f, f, offset);
        // Of four rows the second, the last, the first and the third.
        let place = vec2(f32(k), f32((2 * k + 1) % 5)) - 1.5;
        let spread = px + 0.25 * (place.x * footprint.along + place.y * footprint.beside);
        let at = clamp(vec2<i32>(floor(select(base + offset, spread, is_wide))), vec2(0), last);
#ifdef OBJECTS
        let behind = textureLoad(scene_distance, at, 0).x >= nearest_distance;
#else
        let behind = true;
#endif
        // A weight that is never quite zero keeps the quotient below defined.
        let weight = select(0.0, select(bilinear.x * bilinear.y + 1e-4, 0.25, is_wide), behind);
        sum += weight * vec4(textureLoad(scene_color, at, 0).rgb, 1.0);
    }
#ifdef OBJECTS
    return select(fallback, sum.rgb / max(sum.a, 1e-4), sum.a > 0.0);
#else
    return sum.rgb / sum.a;
#endif
}

// Scene colour in the point `px`.
fn background(px: vec2<f32>, nearest_distance: f32, fallback: vec3<f32>) -> vec3<f32> {
    return background_over(px, Footprint(vec2(0.0), vec2(0.0)), nearest_distance, fallback);
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
    // Unit, view space.
    direction_view: vec3<f32>,
    // Length of the path up to `end_px`.
    seen_world: f32,
}

// `scale` is how much of the bending is applied.
fn refracted(water: WaterPoint, normal_view: vec3<f32>, refractive_index: f32, scale: f32) -> vec3<f32> {
    let incident = -water.to_eye_view;
    return normalize(mix(incident, refract(incident, normal_view, 1.0 / refractive_index), scale));
}

// What the pixel covers at the end of its path, from where paths as long would end that begin with the normals of the pixels to
// its right and below it.
fn footprint_at_end(water: WaterPoint, path: Path, right_view: vec3<f32>, below_view: vec3<f32>, refractive_index: f32, scale: f32) -> Footprint {
    let end = project_px(camera, water.position_view + path.seen_world * path.direction_view);
    let of_right = water.position_view + path.seen_world * refracted(water, right_view, refractive_index, scale);
    let of_below = water.position_view + path.seen_world * refracted(water, below_view, refractive_index, scale);
    let right = clamp(project_px(camera, of_right) - end + vec2(1.0, 0.0), vec2(-MOST_PX), vec2(MOST_PX));
    let below = clamp(project_px(camera, of_below) - end + vec2(0.0, 1.0), vec2(-MOST_PX), vec2(MOST_PX));
    let is_flat = dot(right, right) >= dot(below, below);
    return Footprint(select(below, right, is_flat), select(right, below, is_flat));
}

// `refraction_scale` is how much of the bending is applied; what is finer than `spacing_world` is not resolved.
fn refracted_path(water: WaterPoint, thickness: f32, refractive_index: f32, refraction_scale: f32, spacing_world: f32) -> Path {
    let incident = -water.to_eye_view;
    let direction = refracted(water, water.normal_view, refractive_index, refraction_scale);
    // The floor is known exactly, and better not left to the march: from a grazing view its first step may end so deep below
    // the floor that the floor seen there lies in front of the water.
    let position = point_to_world(water.position_view);
    let floor_reach = trace_floor(surroundings, position, to_world(direction));
    let reach = min(clamp(thickness, 0.0, MAX_THICKNESS) / max(dot(direction, incident), MIN_PATH_COSINE), floor_reach);
    // Without objects the scene is the floor.
#ifdef OBJECTS
    let march = march_to_ground(water, direction, reach);
#else
    let march = March(reach, reach);
#endif
    // What lies outside of the picture is not known: what lies as far inside of its border stands for it.
    let end = water.position_view + march.seen_world * direction;
    let size = vec2<f32>(camera.size_px);
    let end_px = clamp(size - abs(size - abs(project_px(camera, end))), vec2(0.0), size);
    let tolerance = select(spacing_world + 0.25 * march.seen_world, 0.0, march.seen_world < march.length_world);
    let nearest_distance = max(water.distance, -end.z - tolerance);
    return Path(march.length_world, floor_reach - march.length_world, end_px, nearest_distance, direction, march.seen_world);
}
