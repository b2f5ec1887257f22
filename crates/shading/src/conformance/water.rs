//! The water and the scenes of the checks.

use std::sync::Arc;

use glam::Vec3;
use meniscus_core::{Aabb, Camera, Projection, UpAxis};
use meniscus_gpu::CameraUniform;
use meniscus_gpu::role::NO_SURFACE;
use meniscus_scene::{Environment, Scene, Sky};

use super::{Frame, Water, cast, pack_normal};

/// Picture size of most checks: no multiple of a workgroup in either direction.
pub(super) const SIZE: [u32; 2] = [99, 67];

const BOUNDS: Aabb = Aabb { min: Vec3::ZERO, max: Vec3::new(2.0, 0.5, 1.0) };

/// A perspective and a parallel view of the pool from above.
pub(super) fn cameras(size: [u32; 2]) -> [Camera; 2] {
    let perspective = Camera::fit(&BOUNDS.corners(), Vec3::new(-0.4, -0.6, -0.8), Vec3::Y, 0.8, size, 0.9);
    // Far enough for no ray to start below the floor.
    let parallel = Camera {
        eye: perspective.target + (perspective.eye - perspective.target) * 2.0,
        projection: Projection::Orthographic { height_world: 1.4 },
        ..perspective
    };
    [perspective, parallel]
}

/// A tiled floor under a clear sky.
pub(super) fn tiled_scene() -> Scene {
    Scene::around(BOUNDS, UpAxis::Y, 0.0)
}

/// No floor, no sun, and this radiance from everywhere.
pub(super) fn uniform_scene(radiance: f32) -> Scene {
    let mut scene = tiled_scene();
    scene.floor = None;
    scene.sky = Sky { zenith: [radiance; 3], horizon: [radiance; 3], ground: [radiance; 3], glow: 0.0 };
    scene.sun.irradiance = [0.0; 3];
    scene
}

/// A picture of one radiance in place of the sky.
pub(super) fn uniform_picture(radiance: f32) -> Scene {
    let mut scene = uniform_scene(0.0);
    let picture = Environment::from_fn([256, 128], |_| Vec3::splat(radiance));
    scene.environment = Some(Arc::new(picture));
    scene
}

/// A picture of colours that change with the direction, on a floor.
pub(super) fn pictured_scene() -> Scene {
    let mut scene = tiled_scene();
    let picture = |d: Vec3| 0.5 + 0.4 * Vec3::new((5.0 * d.x).sin(), (3.0 * d.y).cos(), d.z);
    scene.environment = Some(Arc::new(Environment::from_fn([64, 32], picture)));
    scene
}

/// A body of waves with steep sides and a drop above it.
fn waves(p: Vec3) -> f32 {
    let height = 0.3 + 0.05 * (7.0 * p.x + 3.0 * p.z).sin() + 0.02 * (19.0 * p.z - 6.0 * p.x).sin();
    let q = (p - BOUNDS.center().with_y(0.0)).abs() - Vec3::new(1.0, height, 0.5);
    let drop = p.distance(Vec3::new(1.6, 0.47, 0.3)) - 0.05;
    (0.7 * q.max_element()).min(drop)
}

/// The pool seen from `camera`.
pub(super) fn pool(camera: &Camera, size: [u32; 2]) -> Water {
    cast(&CameraUniform::new(camera, size), BOUNDS, 0.01, waves)
}

/// The pool over a scene of one colour far behind it.
pub(super) fn pool_frame(camera: &Camera, size: [u32; 2], scene: &Scene, color: [f32; 4]) -> Frame {
    Frame::plain(camera, size, scene, pool(camera, size), color, 1e3)
}

/// The pool on a floor with a coarse pattern at its exact distance, so that marches and fetches between pixels matter.
pub(super) fn patterned_frame(camera: &Camera) -> Frame {
    let mut frame =
        Frame::plain(camera, SIZE, &tiled_scene(), pool(camera, SIZE), [0.25, 0.5, 0.75, 0.0], NO_SURFACE);
    let slab = Aabb { min: Vec3::new(-3.0, -0.1, -3.0), max: Vec3::new(5.0, 0.004, 4.0) };
    let floor = cast(&frame.camera, slab, 0.002, |p| p.y - 0.003);
    for (i, &distance) in floor.distance.iter().enumerate().filter(|(_, d)| **d < NO_SURFACE) {
        frame.scene_distance[i] = distance;
        // Exact in half precision.
        let shade = 0.25 + 0.5 * ((i / 7 + i / SIZE[0] as usize / 5) % 2) as f32;
        frame.scene_color[i] = [shade, 0.5, 0.75, 1.0];
    }
    frame
}

/// Puts a wall of this colour behind the pool.
pub(super) fn add_wall(frame: &mut Frame, color: [f32; 4]) {
    let wall = Aabb { min: Vec3::new(-0.5, 0.0, -0.4), max: Vec3::new(2.5, 0.9, -0.1) };
    let half = 0.5 * wall.extent();
    let seen = cast(&frame.camera, wall, 0.01, |p| ((p - wall.center()).abs() - half).max_element());
    for (i, &distance) in seen.distance.iter().enumerate().filter(|(_, distance)| **distance < NO_SURFACE) {
        if distance < frame.scene_distance[i] {
            frame.scene_distance[i] = distance;
            frame.scene_color[i] = color;
        }
    }
    frame.objects = Some(wall);
}

/// Flat water that fills the picture, seen in parallel projection under this angle to its normal, radians, with a thickness
/// for each column, over a scene of one radiance.
pub(super) fn flat_frame(
    scene: &Scene,
    angle_rad: f32,
    thickness: impl Fn(usize) -> f32,
    behind: f32,
) -> Frame {
    // The view is along the vertical, and the water is what tilts: no model knows where it came from.
    let camera = Camera {
        eye: Vec3::new(0.0, 10.0, 0.0),
        target: Vec3::ZERO,
        up: Vec3::NEG_Z,
        projection: Projection::Orthographic { height_world: 1.0 },
        near: 0.1,
    };
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    let normal = pack_normal(Vec3::new(angle_rad.sin(), 0.0, angle_rad.cos()));
    let water = Water {
        distance: vec![8.0; pixels],
        thickness: (0..pixels).map(|i| thickness(i % SIZE[0] as usize)).collect(),
        normal: vec![normal; pixels],
    };
    Frame::plain(&camera, SIZE, scene, water, [behind, behind, behind, 1.0], 1e3)
}
