//! Twin of `meniscus::scene_march`.

use glam::{IVec2, Vec3};

use super::TwinInput;
use super::view::project_px;

const BISECTIONS: i32 = 4;

pub(super) fn clearance(input: &TwinInput<'_>, position_view: Vec3, limit: f32) -> f32 {
    let px = project_px(input.camera, position_view);
    if !input.inside(px) {
        return limit;
    }
    let scene = input.scene_distance[input.index(px.as_ivec2())];
    (scene + position_view.z).clamp(-limit, limit)
}

pub(super) fn smooth_clearance(input: &TwinInput<'_>, position_view: Vec3, limit: f32) -> f32 {
    let px = project_px(input.camera, position_view);
    if !input.inside(px) {
        return limit;
    }
    let base = (px - 0.5).floor();
    let f = px - 0.5 - base;
    let corners = [IVec2::ZERO, IVec2::X, IVec2::Y, IVec2::ONE];
    let d = corners.map(|offset| input.scene_distance[input.clamped(base.as_ivec2() + offset)]);
    let weights = [(1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y];
    let mean = |of: fn(f32) -> f32| d.iter().zip(weights).map(|(&d, w)| w * of(d)).sum::<f32>();
    let scene = if input.camera.orthographic != 0 {
        mean(|d| d.min(1e30))
    } else {
        1.0 / mean(|d| 1.0 / d).max(1e-30)
    };
    (scene + position_view.z).clamp(-limit, limit)
}

/// Part of a ray in which it passes from in front of the scene to behind it.
pub(super) struct Crossing {
    pub seen: f32,
    pub seen_gap: f32,
    pub far: f32,
    pub far_gap: f32,
}

/// The same, shorter.
pub(super) fn narrowed(gap_at: impl Fn(f32) -> f32, wide: Crossing) -> Crossing {
    let Crossing { mut seen, mut seen_gap, mut far, mut far_gap } = wide;
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (seen + far);
        let gap = gap_at(middle);
        if gap < 0.0 {
            (far, far_gap) = (middle, gap);
        } else {
            (seen, seen_gap) = (middle, gap);
        }
    }
    Crossing { seen, seen_gap, far, far_gap }
}

/// Where within a narrow crossing the scene is met.
pub(super) fn meeting(smooth_gap_at: impl Fn(f32) -> f32, crossing: &Crossing) -> f32 {
    let Crossing { seen, seen_gap, far, far_gap } = *crossing;
    let per_gap = (far - seen) / (seen_gap - far_gap);
    let s = seen + seen_gap * per_gap;
    (s + smooth_gap_at(s) * per_gap).clamp(seen, far)
}
