#define_import_path meniscus::sun_view

#import meniscus::camera::{Camera, project_px}

// The scene as the sun sees it, in parallel projection: what lies behind is in shadow.

@group(0) @binding(20) var<uniform> sun_camera: Camera;
@group(0) @binding(21) var sun_scene_distance: texture_2d<f32>;

// A point in the sun's picture.
struct SunPoint {
    px: vec2<f32>,
    distance: f32,
    // Whether the picture holds it, with its neighbours.
    is_inside: bool,
}

fn sun_point(position_world: vec3<f32>) -> SunPoint {
    let position = (sun_camera.view_from_world * vec4(position_world, 1.0)).xyz;
    let px = project_px(sun_camera, position);
    let is_inside = all(px >= vec2(2.0)) && all(px <= vec2<f32>(sun_camera.size_px) - 2.0);
    return SunPoint(px, -position.z, is_inside);
}

// Pixels of the sun's picture by which a surface is lifted off itself: what the filter below reaches sideways, the square root
// of two, and as much again for what rounding to pixels adds.
const LIFT_PX: f32 = 2.8;

// Share of the sun's light that no object keeps from a surface: percentage closer filtering (Reeves, Salesin & Cook 1987) over
// the four nearest pixels, bilinear.
fn sun_visibility(position_world: vec3<f32>, normal_world: vec3<f32>) -> f32 {
    let lift = LIFT_PX / sun_camera.px_per_world_at_one;
    let s = sun_point(position_world + lift * normal_world);
    if !s.is_inside {
        return 1.0;
    }
    let corner = s.px - 0.5;
    let base = vec2<i32>(floor(corner));
    let f = fract(corner);
    let nearest = vec4(
        textureLoad(sun_scene_distance, base, 0).x,
        textureLoad(sun_scene_distance, base + vec2(1, 0), 0).x,
        textureLoad(sun_scene_distance, base + vec2(0, 1), 0).x,
        textureLoad(sun_scene_distance, base + vec2(1, 1), 0).x,
    );
    let seen = select(vec4(0.0), vec4(1.0), nearest >= vec4(s.distance));
    return mix(mix(seen.x, seen.y, f.x), mix(seen.z, seen.w, f.x), f.y);
}
