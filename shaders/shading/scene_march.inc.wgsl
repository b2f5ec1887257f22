#define_import_path meniscus::scene_march

#import meniscus::camera::project_px
#import meniscus::lighting_inputs::{camera, scene_distance}

// Where a ray meets the opaque scene, as far as the picture of the scene shows it. Along the ray the scene lies in front of it or
// behind it by a gap; where its sign changes, the scene is met or a silhouette is crossed.

// Halvings of a step in which the ray passes from in front of the scene to behind it.
const BISECTIONS: i32 = 4;

fn inside(px: vec2<f32>) -> bool {
    return all(px >= vec2(0.0)) && all(px < vec2<f32>(camera.size_px));
}

// How far the point lies in front of the opaque scene along the view axis, within +-`limit`; what lies outside of the picture
// does not count as scene. What is nearer than where the ray starts does: from a grazing view, that is the ground above a point
// below it.
fn clearance(position_view: vec3<f32>, limit: f32) -> f32 {
    let px = project_px(camera, position_view);
    if !inside(px) {
        return limit;
    }
    let scene = textureLoad(scene_distance, vec2<i32>(px), 0).x;
    return clamp(scene + position_view.z, -limit, limit);
}

// As `clearance`, with the scene interpolated between pixels: without it, refracted lines are ragged. The reciprocal distance
// is linear over the picture of a plane, in parallel projection the distance itself.
fn smooth_clearance(position_view: vec3<f32>, limit: f32) -> f32 {
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
    return clamp(scene + position_view.z, -limit, limit);
}

// Part of a ray in which it passes from in front of the scene, at `seen`, to behind it, at `far`: lengths along it, and the gaps.
struct Crossing {
    seen: f32,
    seen_gap: f32,
    far: f32,
    far_gap: f32,
}

// The same, shorter. At a silhouette the gaps stay as far apart as they were; where the scene is met, they do not.
fn narrowed(start_view: vec3<f32>, direction: vec3<f32>, wide: Crossing, limit: f32) -> Crossing {
    var crossing = wide;
    for (var k = 0; k < BISECTIONS; k++) {
        let middle = 0.5 * (crossing.seen + crossing.far);
        let gap = clearance(start_view + middle * direction, limit);
        if gap < 0.0 {
            crossing.far = middle;
            crossing.far_gap = gap;
        } else {
            crossing.seen = middle;
            crossing.seen_gap = gap;
        }
    }
    return crossing;
}

// Where within a narrow crossing the scene is met: false position, then Newton's step on the interpolated scene with the slope
// found so far.
fn meeting(start_view: vec3<f32>, direction: vec3<f32>, crossing: Crossing, limit: f32) -> f32 {
    let per_gap = (crossing.far - crossing.seen) / (crossing.seen_gap - crossing.far_gap);
    let s = crossing.seen + crossing.seen_gap * per_gap;
    let gap = smooth_clearance(start_view + s * direction, limit);
    return clamp(s + gap * per_gap, crossing.seen, crossing.far);
}
