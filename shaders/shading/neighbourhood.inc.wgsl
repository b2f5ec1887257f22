#define_import_path meniscus::neighbourhood

#import meniscus::camera::{px_per_world, towards_eye, view_position}
#import meniscus::lighting_inputs::{camera, distance_at, normal_at}

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
    // How the normal changes from pixel to pixel on this surface, to the right and down.
    to_right: vec3<f32>,
    to_below: vec3<f32>,
    // Mean squared difference of the neighbours' to this pixel's.
    spread: f32,
    // 1: everything around lies behind, as around a drop; about 0.5 at a straight edge, 0 within a surface.
    isolation: f32,
}

fn neighbourhood(pixel: vec2<u32>, distance: f32, spacing_world: f32) -> Neighbourhood {
    let spacing_px = spacing_world * px_per_world(camera, distance);
    let stride_px = floor(clamp(STENCIL_SPACINGS * spacing_px, 1.0, MAX_STENCIL_PX));
    let last = vec2<i32>(camera.size_px) - 1;
    let offsets = array(vec2(-1, 0), vec2(1, 0), vec2(0, -1), vec2(0, 1));
    let center = normal_at(pixel);
    var sum = center;
    var to_right = vec3(0.0);
    var to_below = vec3(0.0);
    var spread = 0.0;
    for (var k = 0; k < 4; k++) {
        let at = vec2<u32>(clamp(vec2<i32>(pixel) + i32(stride_px) * offsets[k], vec2(0), last));
        let same = abs(distance_at(at) - distance) <= 2.0 * spacing_world;
        let normal = select(center, normal_at(at), same);
        let delta = normal - center;
        sum += normal;
        to_right += f32(offsets[k].x) * normal;
        to_below += f32(offsets[k].y) * normal;
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
        let other = min(distance_at(at), 2.0 * distance);
        let below = dot(plane, position - view_position(camera, vec2<f32>(at) + 0.5, other));
        isolation += 0.25 * clamp(below / max(spacing_world, 1e-6 * distance) - 1.0, 0.0, 1.0);
    }
    let per_px = 0.5 / stride_px;
    return Neighbourhood(sum, per_px * to_right, per_px * to_below, spread, isolation);
}
