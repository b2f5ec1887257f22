//! Twin of `shaders/shading/water_shadow.wgsl`.

use glam::{Vec2, Vec3};
use meniscus_gpu::CameraUniform;

use super::view::{is_empty, project_px, view_position};
use crate::water_shadow::WaterShadowUniform;
use crate::{Surroundings, WaterScale, WaterShadow};

const STEPS: i32 = 32;

/// The whole [`SunPath`](crate::SunPath) image, row by row, of [`WaterShadow::size_blocks`]. The inputs are images of the
/// camera's size: water surface and scene as distances along the view axis, water thickness along the view ray.
pub fn water_shadow(
    camera: &CameraUniform,
    surroundings: &Surroundings,
    scale: WaterScale,
    distance: &[f32],
    thickness: &[f32],
    scene_distance: &[f32],
) -> Vec<f32> {
    let uniform = WaterShadowUniform::new(camera, surroundings, scale);
    let [width, height] = uniform.size_blocks;
    let size = Vec2::new(camera.size_px[0] as f32, camera.size_px[1] as f32);
    let index = |px: Vec2| px.y as usize * camera.size_px[0] as usize + px.x as usize;
    let sun = Vec3::from(uniform.sun_direction_view);
    let step_world = uniform.reach_world / STEPS as f32;
    let sun_path = |start_view: Vec3| {
        let mut path = 0.0;
        for i in 0..STEPS {
            let position = start_view + (i as f32 + 0.5) * step_world * sun;
            let px = project_px(camera, position);
            if position.z >= 0.0 || px.cmplt(Vec2::ZERO).any() || px.cmpge(size).any() {
                break;
            }
            let (distance, thickness) = (distance[index(px)], thickness[index(px)]);
            if !is_empty(distance) {
                let per_distance =
                    if camera.orthographic != 0 { 1.0 } else { position.length() / -position.z };
                let depth = (-position.z - distance) * per_distance;
                let soft = step_world.min(thickness) + 1e-30;
                let within = |gap: f32| (gap / soft + 0.5).clamp(0.0, 1.0);
                path += step_world * within(depth) * within(thickness - depth);
            }
        }
        path
    };
    (0..width * height)
        .map(|i| {
            let block = Vec2::new((i % width) as f32, (i / width) as f32);
            let px = ((block + 0.5) * WaterShadow::BLOCK_PX as f32).min(size - 0.5);
            let scene = scene_distance[index(px)];
            let lit = is_empty(scene) || uniform.reach_world <= 0.0;
            if lit { 0.0 } else { sun_path(view_position(camera, px, scene)) }
        })
        .collect()
}
