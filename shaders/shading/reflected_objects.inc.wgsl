#define_import_path meniscus::reflected_objects

#import meniscus::camera::{project_px, px_per_world}
#import meniscus::lighting_inputs::{camera, point_to_world, scene_color, scene_distance, surroundings}
#import meniscus::scene_march::{Crossing, clearance, meeting, narrowed}
#import meniscus::surroundings::trace_floor
#import meniscus::water::WaterPoint

// Objects in the mirror of the water, as far as the picture of the opaque scene shows them (McGuire & Mara 2014: steps of equal
// length in the picture). The water is no part of that picture, so that no ray meets where it starts. Floor and sky are known
// exactly and left to the surroundings: the march begins and ends at a box around all objects.

struct ObjectBounds {
    // World.
    min: vec3<f32>,
    pad_a: f32,
    max: vec3<f32>,
    pad_b: f32,
}

@group(0) @binding(13) var<uniform> objects: ObjectBounds;

// Steps of the march through the box: one for so many pixels, but not more than so many; and parts of a step in which the ray may
// meet something. What it is behind for less than a part is missed, as close to the upper edges of objects.
const STEP_PX: f32 = 12.0;
const MOST_STEPS: f32 = 32.0;
const PARTS: f32 = 6.0;
// The sky, times reciprocals of distances.
const FARTHEST: f32 = 1e30;
// Share of the picture's sides along which what is seen fades out, as nothing is known beyond.
const BORDER: f32 = 0.05;
// Pixels of depth that neighbouring pixels of one surface may differ by: it is seen under a good degree then.
const STEEPEST: f32 = 48.0;
// Perceptual roughness up to which the mirror shows a sharp image, and from which on it shows none: the environment has the blur.
const SHARP_ROUGHNESS: f32 = 0.3;
const BLURRED_ROUGHNESS: f32 = 0.7;
// Of the length to the floor: what is met later is the floor.
const FLOOR_BEGINS: f32 = 0.999;

// Lengths at which the ray enters and leaves the box; the first is larger where it passes by.
fn span_of_objects(position: vec3<f32>, direction: vec3<f32>) -> vec2<f32> {
    let slope = select(direction, select(vec3(-1e-6), vec3(1e-6), direction >= vec3(0.0)), abs(direction) < vec3(1e-6));
    let a = (objects.min - position) / slope;
    let b = (objects.max - position) / slope;
    let enters = min(a, b);
    let leaves = max(a, b);
    return vec2(max(max(enters.x, enters.y), max(enters.z, 0.0)), min(leaves.x, min(leaves.y, leaves.z)));
}

// Length at which the ray leaves the picture or comes too near to the eye, at most `reach`.
fn length_in_picture(start: vec3<f32>, direction: vec3<f32>, reach: f32) -> f32 {
    // Half the picture's width and height there, and how they grow along the ray.
    let scale = select(vec2(-start.z, -direction.z), vec2(1.0, 0.0), camera.orthographic != 0u);
    let half = camera.half_extent * scale.x;
    let grows = camera.half_extent * scale.y;
    // Right, top, left, bottom: how far inside, and how fast it gets less.
    let inside = vec4(half - start.xy, half + start.xy);
    let shrinks = vec4(direction.xy - grows, -direction.xy - grows);
    let ends = select(vec4(reach), max(inside, vec4(0.0)) / max(shrinks, vec4(1e-6)), shrinks > vec4(0.0));
    let near = max(-start.z - camera.near_world, 0.0) / max(direction.z, 1e-6);
    let end = min(min(ends.x, ends.y), min(ends.z, ends.w));
    return min(min(end, reach), select(reach, near, direction.z > 0.0));
}

// Where the ray meets an object.
struct Hit {
    // Along the ray; negative if it meets none that can be seen.
    length_world: f32,
    // How far the scene of a pixel may lie from there and still be part of the same surface.
    tolerance: f32,
}

// A part of a ray in the picture. Along it, points and reciprocal distances change evenly, in parallel projection the distances.
struct Run {
    first_px: vec2<f32>,
    last_px: vec2<f32>,
    first_depth: f32,
    last_depth: f32,
}

fn run_of(first: vec3<f32>, last: vec3<f32>) -> Run {
    let depths = select(1.0 / vec2(-first.z, -last.z), vec2(-first.z, -last.z), camera.orthographic != 0u);
    return Run(project_px(camera, first), project_px(camera, last), depths.x, depths.y);
}

// Distance of the scene where this share of the run is passed.
fn scene_at(run: Run, share: f32) -> f32 {
    let px = mix(run.first_px, run.last_px, share);
    let at = clamp(vec2<i32>(px), vec2(0), vec2<i32>(camera.size_px) - 1);
    return min(textureLoad(scene_distance, at, 0).x, FARTHEST);
}

// Whether the ray is farther away there than a scene at that distance.
fn is_behind(run: Run, share: f32, scene: f32) -> bool {
    let ray = mix(run.first_depth, run.last_depth, share);
    return select(scene * ray < 1.0, scene < ray, camera.orthographic != 0u);
}

fn march_objects(start: vec3<f32>, direction: vec3<f32>, begin: f32, end: f32) -> Hit {
    let run = run_of(start + begin * direction, start + end * direction);
    // Reciprocal distances at both ends.
    let scale = select(vec2(run.first_depth, run.last_depth), vec2(1.0), camera.orthographic != 0u);
    let steps = clamp(ceil(distance(run.first_px, run.last_px) / STEP_PX), 1.0, MOST_STEPS);
    var last_scene = scene_at(run, 0.0);
    var was_behind = is_behind(run, 0.0, last_scene);
    for (var i = 1.0; i <= steps; i += 1.0) {
        let scene = scene_at(run, i / steps);
        let behind = is_behind(run, i / steps, scene);
        // It may also be met, and left behind again, where the ray gets farther away than it was.
        let may_meet = !was_behind && (behind || is_behind(run, i / steps, last_scene));
        for (var part = 1.0; may_meet && part <= PARTS; part += 1.0) {
            let share = (i - 1.0 + part / PARTS) / steps;
            if !is_behind(run, share, scene_at(run, share)) {
                continue;
            }
            // A little more on both sides: these lengths are rounded otherwise.
            let shares = clamp(share + vec2(-1.25, 0.25) / (PARTS * steps), vec2(0.0), vec2(1.0));
            let lengths = mix(vec2(begin), vec2(end), shares * scale.y / mix(vec2(scale.x), vec2(scale.y), shares));
            let seen_gap = clearance(start + lengths.x * direction, end);
            let far_gap = clearance(start + lengths.y * direction, end);
            let crossing = narrowed(start, direction, Crossing(lengths.x, seen_gap, lengths.y, far_gap), end);
            let pixel_world = 1.0 / px_per_world(camera, -start.z - lengths.y * direction.z);
            let tolerance = max(0.5 * (lengths.y - lengths.x), STEEPEST * pixel_world);
            let jump = crossing.seen_gap - crossing.far_gap;
            if crossing.seen_gap >= 0.0 && crossing.far_gap < 0.0 && jump <= tolerance {
                return Hit(meeting(start, direction, crossing, end), tolerance);
            }
            // It goes on behind a silhouette.
            break;
        }
        last_scene = scene;
        was_behind = behind;
    }
    return Hit(-1.0, 0.0);
}

// Scene colour around `px`, bilinear over the samples within `tolerance` of the distance; alpha is their share.
fn color_near(px: vec2<f32>, distance: f32, tolerance: f32) -> vec4<f32> {
    let base = floor(px - 0.5);
    let f = px - 0.5 - base;
    let last = vec2<i32>(camera.size_px) - 1;
    var sum = vec4(0.0);
    for (var k = 0; k < 4; k++) {
        let offset = vec2(k & 1, k >> 1u);
        let at = clamp(vec2<i32>(base) + offset, vec2(0), last);
        let weights = mix(1.0 - f, f, vec2<f32>(offset));
        let belongs = abs(textureLoad(scene_distance, at, 0).x - distance) <= tolerance;
        sum += select(0.0, weights.x * weights.y, belongs) * vec4(textureLoad(scene_color, at, 0).rgb, 1.0);
    }
    return vec4(sum.rgb / max(sum.a, 1e-6), sum.a);
}

// What a mirror of GGX width `alpha` shows of objects in the unit direction (world) from the water; alpha: how sure that is.
fn reflected_object(water: WaterPoint, direction_world: vec3<f32>, alpha: f32) -> vec4<f32> {
    let position = point_to_world(water.position_view);
    let span = span_of_objects(position, direction_world);
    let floor_reach = trace_floor(surroundings, position, direction_world);
    let direction = (camera.view_from_world * vec4(direction_world, 0.0)).xyz;
    let end = length_in_picture(water.position_view, direction, min(span.y, floor_reach));
    let sharp = 1.0 - smoothstep(SHARP_ROUGHNESS, BLURRED_ROUGHNESS, sqrt(alpha));
    // Not this way round, absurd positions go on.
    if !(span.x < end && sharp > 0.0) {
        return vec4(0.0);
    }
    let hit = march_objects(water.position_view, direction, span.x, end);
    if hit.length_world < 0.0 || hit.length_world > FLOOR_BEGINS * floor_reach {
        return vec4(0.0);
    }
    let met = water.position_view + hit.length_world * direction;
    let px = project_px(camera, met);
    let from_border = min(px, vec2<f32>(camera.size_px) - px) / vec2<f32>(camera.size_px);
    let fade = smoothstep(0.0, BORDER, min(from_border.x, from_border.y));
    let color = color_near(px, -met.z, hit.tolerance);
    return vec4(color.rgb, color.a * fade * sharp);
}
