//! Twin of `meniscus::refraction`.

use glam::{IVec2, Vec2, Vec3};

use super::scene_march::{Crossing, clearance, meeting, narrowed, smooth_clearance};
use super::surroundings::trace_floor;
use super::view::{point_to_world, project_px, to_world, view_position};
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
    let gap_at = |s: f32| clearance(input, at(s), reach);
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
                let smooth_gap_at = |s: f32| smooth_clearance(input, at(s), reach);
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

/// Length along the ray to the plane of the scene that is seen through the water's pixel, at most `reach`.
fn reach_to_plane(input: &TwinInput<'_>, water: &WaterPoint, direction: Vec3, reach: f32) -> f32 {
    let last = input.size() - 1;
    let at = project_px(input.camera, water.position_view).as_ivec2();
    let at = at.max(IVec2::ONE).min(last - 1).max(IVec2::ZERO);
    let scene_point = |offset: IVec2| {
        let pixel = (at + offset).clamp(IVec2::ZERO, last);
        view_position(input.camera, pixel.as_vec2() + 0.5, input.scene_distance[input.clamped(pixel)])
    };
    let here = scene_point(IVec2::ZERO);
    let shorter = |axis: IVec2| {
        let (after, before) = (scene_point(axis) - here, here - scene_point(-axis));
        if after.length_squared() < before.length_squared() { after } else { before }
    };
    let normal = shorter(IVec2::X).cross(shorter(IVec2::Y));
    let length = normal.dot(here - water.position_view) / normal.dot(direction);
    if length > 0.0 && length < reach { length } else { reach }
}

fn march_to_ground(input: &TwinInput<'_>, water: &WaterPoint, direction: Vec3, reach: f32) -> March {
    let march = trace_path(input, water, direction, reach);
    let end = water.position_view + march.length_world * direction;
    if input.inside(project_px(input.camera, end)) {
        return march;
    }
    let to_plane = reach_to_plane(input, water, direction, reach);
    March { length_world: march.length_world.min(to_plane), seen_world: march.seen_world.min(to_plane) }
}

/// What a pixel of water covers of the picture of the scene.
pub(super) struct Footprint {
    pub along: Vec2,
    pub beside: Vec2,
}

const WIDE_PX: f32 = 1.5;
const MOST_PX: f32 = 64.0;

/// Scene colour over a footprint around `px`.
pub(super) fn background_over(
    input: &TwinInput<'_>,
    px: Vec2,
    footprint: &Footprint,
    nearest_distance: f32,
    fallback: Vec3,
) -> Vec3 {
    let corner = px - 0.5;
    let base = corner.floor();
    let f = corner - base;
    let is_wide = footprint.along.length_squared() > WIDE_PX * WIDE_PX;
    let (mut sum, mut total) = (Vec3::ZERO, 0.0);
    for k in 0..4 {
        let offset = IVec2::new(k & 1, k >> 1);
        let place = Vec2::new(k as f32, ((2 * k + 1) % 5) as f32) - 1.5;
        let spread = px + 0.25 * (place.x * footprint.along + place.y * footprint.beside);
        let at = if is_wide { spread.floor() } else { base + offset.as_vec2() };
        let at = input.clamped(at.as_ivec2());
        let along = |axis: usize| if offset[axis] == 1 { f[axis] } else { 1.0 - f[axis] };
        if input.objects.is_none() || input.scene_distance[at] >= nearest_distance {
            let weight = if is_wide { 0.25 } else { along(0) * along(1) + 1e-4 };
            sum += weight * input.scene_rgb(at);
            total += weight;
        }
    }
    if total > 0.0 { sum / total } else { fallback }
}

/// Scene colour in the point `px`.
pub(super) fn background(input: &TwinInput<'_>, px: Vec2, nearest_distance: f32, fallback: Vec3) -> Vec3 {
    let point = Footprint { along: Vec2::ZERO, beside: Vec2::ZERO };
    background_over(input, px, &point, nearest_distance, fallback)
}

/// The refracted path in the water.
pub(super) struct Path {
    pub length_world: f32,
    pub to_floor_world: f32,
    pub end_px: Vec2,
    pub nearest_distance: f32,
    pub direction_view: Vec3,
    pub seen_world: f32,
}

fn refracted(water: &WaterPoint, normal_view: Vec3, refractive_index: f32, scale: f32) -> Vec3 {
    let incident = -water.to_eye_view;
    mix(incident, refract(incident, normal_view, 1.0 / refractive_index), scale).normalize()
}

/// What the pixel covers at the end of its path, with the normals of the pixels to its right and below it.
pub(super) fn footprint_at_end(
    input: &TwinInput<'_>,
    water: &WaterPoint,
    path: &Path,
    beside_view: [Vec3; 2],
    refractive_index: f32,
    scale: f32,
) -> Footprint {
    let end_of =
        |direction: Vec3| project_px(input.camera, water.position_view + path.seen_world * direction);
    let end = end_of(path.direction_view);
    let ends = beside_view.map(|normal| end_of(refracted(water, normal, refractive_index, scale)));
    let most = Vec2::splat(MOST_PX);
    let right = (ends[0] - end + Vec2::X).clamp(-most, most);
    let below = (ends[1] - end + Vec2::Y).clamp(-most, most);
    if right.length_squared() >= below.length_squared() {
        Footprint { along: right, beside: below }
    } else {
        Footprint { along: below, beside: right }
    }
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
    let direction = refracted(water, water.normal_view, refractive_index, refraction_scale);
    let position = point_to_world(input.camera, water.position_view);
    let floor_reach = trace_floor(input.surroundings, position, to_world(input.camera, direction));
    let reach =
        (thickness.clamp(0.0, MAX_THICKNESS) / direction.dot(incident).max(MIN_PATH_COSINE)).min(floor_reach);
    let march = match input.objects {
        Some(_) => march_to_ground(input, water, direction, reach),
        None => March { length_world: reach, seen_world: reach },
    };
    let end = water.position_view + march.seen_world * direction;
    let hidden = march.seen_world < march.length_world;
    let tolerance = if hidden { 0.0 } else { spacing_world + 0.25 * march.seen_world };
    Path {
        length_world: march.length_world,
        to_floor_world: floor_reach - march.length_world,
        end_px: {
            let size = input.size().as_vec2();
            (size - (size - project_px(input.camera, end).abs()).abs()).clamp(Vec2::ZERO, size)
        },
        nearest_distance: (-end.z - tolerance).max(water.distance),
        direction_view: direction,
        seen_world: march.seen_world,
    }
}
