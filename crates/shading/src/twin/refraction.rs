//! Twin of `meniscus::refraction`.

use glam::{IVec2, Vec2, Vec3};

use super::scene_march::{Crossing, clearance, meeting, narrowed, smooth_clearance};
use super::surroundings::trace_floor;
use super::view::{point_to_world, project_px, to_world};
use super::water::WaterPoint;
use super::{TwinInput, mix};

const MARCH_STEPS: i32 = 4;
const MIN_PATH_COSINE: f32 = 0.3;
const MAX_THICKNESS: f32 = 1e30;

/// WGSL's `refract`.
pub(super) fn refract(incident: Vec3, normal: Vec3, eta: f32) -> Vec3 {
    let c = normal.dot(incident);
    let k = 1.0 - eta * eta * (1.0 - c * c);
    if k < 0.0 { Vec3::ZERO } else { eta * incident - (eta * c + k.sqrt()) * normal }
}

/// Where the march along the refracted ray ends.
struct March {
    length_world: f32,
    seen_world: f32,
}

fn trace_path(input: &TwinInput<'_>, water: &WaterPoint, direction: Vec3, reach: f32) -> March {
    let at = |s: f32| water.position_view + s * direction;
    let gap_at = |s: f32| clearance(input, at(s), water.distance, reach);
    let step_world = reach / MARCH_STEPS as f32;
    let (mut seen, mut seen_gap) = (0.0, reach);
    let mut hidden = false;
    for i in 1..=MARCH_STEPS {
        let end = step_world * i as f32;
        let end_gap = gap_at(end);
        if end_gap < 0.0 && !hidden {
            let wide = Crossing { seen, seen_gap, far: end, far_gap: end_gap };
            let crossing = narrowed(gap_at, wide);
            (seen, seen_gap) = (crossing.seen, crossing.seen_gap);
            if seen_gap - crossing.far_gap <= 0.5 * step_world {
                let smooth_gap_at = |s: f32| smooth_clearance(input, at(s), water.distance, reach);
                let met = meeting(smooth_gap_at, &crossing);
                return March { length_world: met, seen_world: met };
            }
        }
        hidden = end_gap < 0.0;
        if !hidden {
            (seen, seen_gap) = (end, end_gap);
        }
    }
    March { length_world: reach, seen_world: seen }
}

/// Scene colour around `px`.
pub(super) fn background(input: &TwinInput<'_>, px: Vec2, nearest_distance: f32, fallback: Vec3) -> Vec3 {
    let corner = px - 0.5;
    let base = corner.floor();
    let f = corner - base;
    let (mut sum, mut total) = (Vec3::ZERO, 0.0);
    for k in 0..4 {
        let offset = IVec2::new(k & 1, k >> 1);
        let at = input.clamped(base.as_ivec2() + offset);
        let along = |axis: usize| if offset[axis] == 1 { f[axis] } else { 1.0 - f[axis] };
        if input.objects.is_none() || input.scene_distance[at] >= nearest_distance {
            let weight = along(0) * along(1) + 1e-4;
            sum += weight * input.scene_rgb(at);
            total += weight;
        }
    }
    if total > 0.0 { sum / total } else { fallback }
}

/// The refracted path in the water.
pub(super) struct Path {
    pub length_world: f32,
    pub to_floor_world: f32,
    pub end_px: Vec2,
    pub nearest_distance: f32,
}

pub(super) fn refracted_path(
    input: &TwinInput<'_>,
    water: &WaterPoint,
    thickness: f32,
    refractive_index: f32,
    refraction_scale: f32,
    spacing_world: f32,
) -> Path {
    let incident = -water.to_eye_view;
    let bent = refract(incident, water.normal_view, 1.0 / refractive_index);
    let direction = mix(incident, bent, refraction_scale).normalize();
    let position = point_to_world(input.camera, water.position_view);
    let floor_reach = trace_floor(input.surroundings, position, to_world(input.camera, direction));
    let reach =
        (thickness.clamp(0.0, MAX_THICKNESS) / direction.dot(incident).max(MIN_PATH_COSINE)).min(floor_reach);
    let march = match input.objects {
        Some(_) => trace_path(input, water, direction, reach),
        None => March { length_world: reach, seen_world: reach },
    };
    let end = water.position_view + march.seen_world * direction;
    let hidden = march.seen_world < march.length_world;
    let tolerance = if hidden { 0.0 } else { spacing_world + 0.25 * march.seen_world };
    Path {
        length_world: march.length_world,
        to_floor_world: floor_reach - march.length_world,
        end_px: project_px(input.camera, end).clamp(Vec2::ZERO, input.size().as_vec2()),
        nearest_distance: (-end.z - tolerance).max(water.distance),
    }
}
