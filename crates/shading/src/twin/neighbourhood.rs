//! Twin of `meniscus::neighbourhood`.

use glam::{IVec2, Vec3};

use super::TwinInput;
use super::view::{px_per_world, towards_eye, unpack_normal, view_position};

const STENCIL_SPACINGS: f32 = 0.3;
const MAX_STENCIL_PX: f32 = 4.0;
const EDGE_SPREAD: f32 = 0.5;
const DROP_SPACINGS: f32 = 1.6;
const MAX_DROP_PX: f32 = 64.0;

/// The normals around a pixel.
pub(super) struct Neighbourhood {
    pub normal_sum: Vec3,
    pub to_right: Vec3,
    pub to_below: Vec3,
    pub spread: f32,
    pub isolation: f32,
}

pub(super) fn neighbourhood(
    input: &TwinInput<'_>,
    pixel: [u32; 2],
    distance: f32,
    spacing_world: f32,
) -> Neighbourhood {
    let spacing_px = spacing_world * px_per_world(input.camera, distance);
    let stride_px = (STENCIL_SPACINGS * spacing_px).clamp(1.0, MAX_STENCIL_PX).floor();
    let at = IVec2::new(pixel[0] as i32, pixel[1] as i32);
    let offsets = [IVec2::NEG_X, IVec2::X, IVec2::NEG_Y, IVec2::Y];
    let center = unpack_normal(input.normal[input.index(at)]);
    let (mut sum, mut spread) = (center, 0.0);
    let (mut to_right, mut to_below) = (Vec3::ZERO, Vec3::ZERO);
    for offset in offsets {
        let index = input.clamped(at + stride_px as i32 * offset);
        let same = (input.distance[index] - distance).abs() <= 2.0 * spacing_world;
        let normal = if same { unpack_normal(input.normal[index]) } else { center };
        sum += normal;
        to_right += offset.x as f32 * normal;
        to_below += offset.y as f32 * normal;
        spread += 0.25 * if same { normal.distance_squared(center) } else { EDGE_SPREAD };
    }
    let far_px = (DROP_SPACINGS * spacing_px).clamp(2.0, MAX_DROP_PX) as i32;
    let position = |at: IVec2, d| view_position(input.camera, at.as_vec2() + 0.5, d);
    let here = position(at, distance);
    let half_way = sum / sum.length().max(1e-3) + towards_eye(input.camera, here);
    let plane = half_way / half_way.length().max(1e-3);
    let mut isolation = 0.0;
    for offset in offsets {
        let at = (at + far_px * offset).clamp(IVec2::ZERO, input.size() - 1);
        let other = input.distance[input.index(at)].min(2.0 * distance);
        let below = plane.dot(here - position(at, other));
        let soft = spacing_world.max(1e-6 * distance);
        isolation += 0.25 * (below / soft - 1.0).clamp(0.0, 1.0);
    }
    let per_px = 0.5 / stride_px;
    let (to_right, to_below) = (per_px * to_right, per_px * to_below);
    Neighbourhood { normal_sum: sum, to_right, to_below, spread, isolation }
}
