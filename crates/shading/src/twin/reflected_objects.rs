//! Twin of `meniscus::reflected_objects`.

use glam::{IVec2, Mat4, Vec2, Vec3, Vec4};

use super::scene_march::{Crossing, clearance, meeting, narrowed, smooth_clearance};
use super::surroundings::trace_floor;
use super::view::{point_to_world, project_px, px_per_world};
use super::water::WaterPoint;
use super::{TwinInput, smoothstep};
use crate::ObjectBounds;

const STEP_PX: f32 = 12.0;
const MOST_STEPS: f32 = 32.0;
const PARTS: f32 = 6.0;
const FARTHEST: f32 = 1e30;
const BORDER: f32 = 0.05;
const STEEPEST: f32 = 48.0;
const SHARP_ROUGHNESS: f32 = 0.3;
const BLURRED_ROUGHNESS: f32 = 0.7;
const FLOOR_BEGINS: f32 = 0.999;

/// Lengths at which the ray enters and leaves the box; the first is larger where it passes by.
fn span_of_objects(objects: &ObjectBounds, position: Vec3, direction: Vec3) -> [f32; 2] {
    let slope = Vec3::from_array(direction.to_array().map(|c| match c.abs() < 1e-6 {
        true if c >= 0.0 => 1e-6,
        true => -1e-6,
        false => c,
    }));
    let a = (Vec3::from(objects.min) - position) / slope;
    let b = (Vec3::from(objects.max) - position) / slope;
    [a.min(b).max_element().max(0.0), a.max(b).min_element()]
}

/// Length at which the ray leaves the picture or comes too near to the eye, at most `reach`.
fn length_in_picture(input: &TwinInput<'_>, start: Vec3, direction: Vec3, reach: f32) -> f32 {
    let camera = input.camera;
    let [scale, grows] = if camera.orthographic != 0 { [1.0, 0.0] } else { [-start.z, -direction.z] };
    let half = scale * Vec2::from(camera.half_extent);
    let grows = grows * Vec2::from(camera.half_extent);
    let (at, along) = (start.truncate(), direction.truncate());
    let mut end = reach;
    for (inside, shrinks) in [(half - at, along - grows), (half + at, -along - grows)] {
        for axis in 0..2 {
            if shrinks[axis] > 0.0 {
                end = end.min(inside[axis].max(0.0) / shrinks[axis].max(1e-6));
            }
        }
    }
    if direction.z > 0.0 {
        end = end.min((-start.z - camera.near_world).max(0.0) / direction.z.max(1e-6));
    }
    end
}

/// Where the ray meets an object.
struct Hit {
    length_world: f32,
    tolerance: f32,
}

/// A part of a ray in the picture.
struct Run<'a> {
    input: &'a TwinInput<'a>,
    px: [Vec2; 2],
    depth: [f32; 2],
}

impl<'a> Run<'a> {
    fn new(input: &'a TwinInput<'a>, ends: [Vec3; 2]) -> Self {
        let depth = ends.map(|end| if input.camera.orthographic != 0 { -end.z } else { (-end.z).recip() });
        Self { input, px: ends.map(|end| project_px(input.camera, end)), depth }
    }

    /// Distance of the scene where this share of the run is passed.
    fn scene_at(&self, share: f32) -> f32 {
        let px = self.px[0] * (1.0 - share) + self.px[1] * share;
        self.input.scene_distance[self.input.clamped(px.as_ivec2())].min(FARTHEST)
    }

    /// Whether the ray is farther away there than a scene at that distance.
    fn is_behind(&self, share: f32, scene: f32) -> bool {
        let ray = between(self.depth, share);
        if self.input.camera.orthographic != 0 { scene < ray } else { scene * ray < 1.0 }
    }
}

fn between([a, b]: [f32; 2], share: f32) -> f32 {
    a * (1.0 - share) + b * share
}

fn march_objects(input: &TwinInput<'_>, start: Vec3, direction: Vec3, [begin, end]: [f32; 2]) -> Option<Hit> {
    let at = |s: f32| start + s * direction;
    let gap_at = |s: f32| clearance(input, at(s), end);
    let run = Run::new(input, [at(begin), at(end)]);
    let scale = if input.camera.orthographic != 0 { [1.0; 2] } else { run.depth };
    let length = |share: f32| between([begin, end], share * scale[1] / between(scale, share));
    let steps = (run.px[0].distance(run.px[1]) / STEP_PX).ceil().clamp(1.0, MOST_STEPS);
    let mut last_scene = run.scene_at(0.0);
    let mut was_behind = run.is_behind(0.0, last_scene);
    for i in 1..=steps as u32 {
        let i = i as f32;
        let scene = run.scene_at(i / steps);
        let behind = run.is_behind(i / steps, scene);
        if !was_behind && (behind || run.is_behind(i / steps, last_scene)) {
            let shares = (1..=PARTS as u32).map(|part| (i - 1.0 + part as f32 / PARTS) / steps);
            let met = shares.into_iter().find(|&share| run.is_behind(share, run.scene_at(share)));
            if let Some(share) = met {
                let [seen, far] =
                    [-1.25, 0.25].map(|part| length((share + part / (PARTS * steps)).clamp(0.0, 1.0)));
                let wide = Crossing { seen, seen_gap: gap_at(seen), far, far_gap: gap_at(far) };
                let crossing = narrowed(gap_at, wide);
                let pixel_world = 1.0 / px_per_world(input.camera, -at(far).z);
                let tolerance = (0.5 * (far - seen)).max(STEEPEST * pixel_world);
                let jump = crossing.seen_gap - crossing.far_gap;
                if crossing.seen_gap >= 0.0 && crossing.far_gap < 0.0 && jump <= tolerance {
                    let smooth_gap_at = |s: f32| smooth_clearance(input, at(s), end);
                    return Some(Hit { length_world: meeting(smooth_gap_at, &crossing), tolerance });
                }
            }
        }
        (last_scene, was_behind) = (scene, behind);
    }
    None
}

/// Scene colour around `px`, over the samples within `tolerance` of the distance; alpha is their share.
fn color_near(input: &TwinInput<'_>, px: Vec2, distance: f32, tolerance: f32) -> Vec4 {
    let base = (px - 0.5).floor();
    let f = px - 0.5 - base;
    let mut sum = Vec4::ZERO;
    for k in 0..4 {
        let offset = IVec2::new(k & 1, k >> 1);
        let at = input.clamped(base.as_ivec2() + offset);
        let along = |axis: usize| if offset[axis] == 1 { f[axis] } else { 1.0 - f[axis] };
        if (input.scene_distance[at] - distance).abs() <= tolerance {
            sum += along(0) * along(1) * input.scene_rgb(at).extend(1.0);
        }
    }
    (sum.truncate() / sum.w.max(1e-6)).extend(sum.w)
}

/// What a mirror of GGX width `alpha` shows of objects in the unit direction (world) from the water; alpha: how sure that is.
pub(super) fn reflected_object(
    input: &TwinInput<'_>,
    water: &WaterPoint,
    direction_world: Vec3,
    alpha: f32,
) -> Vec4 {
    let Some(objects) = &input.objects else { return Vec4::ZERO };
    let camera = input.camera;
    let position = point_to_world(camera, water.position_view);
    let [begin, end] = span_of_objects(objects, position, direction_world);
    let floor_reach = trace_floor(input.surroundings, position, direction_world);
    let direction = Mat4::from_cols_array_2d(&camera.view_from_world).transform_vector3(direction_world);
    let end = length_in_picture(input, water.position_view, direction, end.min(floor_reach));
    let sharp = 1.0 - smoothstep(SHARP_ROUGHNESS, BLURRED_ROUGHNESS, alpha.sqrt());
    if !(begin < end && sharp > 0.0) {
        return Vec4::ZERO;
    }
    let Some(hit) = march_objects(input, water.position_view, direction, [begin, end]) else {
        return Vec4::ZERO;
    };
    if hit.length_world > FLOOR_BEGINS * floor_reach {
        return Vec4::ZERO;
    }
    let met = water.position_view + hit.length_world * direction;
    let px = project_px(camera, met);
    let size = input.size().as_vec2();
    let fade = smoothstep(0.0, BORDER, (px.min(size - px) / size).min_element());
    let color = color_near(input, px, -met.z, hit.tolerance);
    color.truncate().extend(color.w * fade * sharp)
}
