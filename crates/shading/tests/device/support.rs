//! A device, a scene, and the analytic water of the conformance suite.

use glam::{Mat4, Vec2, Vec3};
use meniscus_core::{Aabb, UpAxis};
use meniscus_gpu::role::{SceneColor, SceneDepth, SceneDistance};
use meniscus_gpu::{AdapterChoice, CameraUniform, Gpu, Recorder, Texture, Timing};
use meniscus_scene::Scene;
use meniscus_shading::conformance::Frame;
use meniscus_shading::{LightingModel, SceneGeometry, ScenePass, SunView};

pub fn gpu() -> Gpu {
    Gpu::new(&AdapterChoice::default()).expect("an adapter, at least mesa-vulkan-drivers")
}

/// What the GPU makes of a frame.
pub fn render(frame: &Frame, gpu: &Gpu, model: &dyn LightingModel) -> Vec<[f32; 4]> {
    frame.draw(gpu, &*model.compile(gpu).unwrap()).unwrap()
}

/// Where the view ray of a pixel begins, and its step per distance along the view axis, world.
pub fn world_ray(camera: &CameraUniform, pixel: usize) -> (Vec3, Vec3) {
    let [width, height] = camera.size_px.map(|side| side as usize);
    let px = Vec2::new((pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5);
    let ndc = px / Vec2::new(width as f32, height as f32) * Vec2::new(2.0, -2.0) + Vec2::new(-1.0, 1.0);
    let offset = ndc * Vec2::from(camera.half_extent);
    let (origin, step) = if camera.orthographic != 0 {
        (offset.extend(0.0), Vec3::NEG_Z)
    } else {
        (Vec3::ZERO, offset.extend(-1.0))
    };
    let world_from_view = Mat4::from_cols_array_2d(&camera.world_from_view);
    (world_from_view.transform_point3(origin), world_from_view.transform_vector3(step))
}

/// A world with y up and a tiled floor at y = 0 under the unit box.
pub fn tiled_scene() -> Scene {
    Scene::around(Aabb { min: Vec3::ZERO, max: Vec3::new(2.0, 0.5, 1.0) }, UpAxis::Y, 0.0)
}

/// The drawn scene, with the shadows of what the sun sees: colour and distance.
pub fn draw_scene(
    gpu: &Gpu,
    camera: &CameraUniform,
    scene: &Scene,
    shadows: Option<&SunView<'_>>,
) -> (Texture<SceneColor>, Texture<SceneDistance>) {
    let size = camera.size_px;
    let color = Texture::<SceneColor>::new(gpu, size).unwrap();
    let distance = Texture::<SceneDistance>::new(gpu, size).unwrap();
    let depth = Texture::<SceneDepth>::new(gpu, size).unwrap();
    let geometry = SceneGeometry::new(gpu, scene).unwrap();
    let mut recorder = Recorder::new(gpu, Timing::Stamps);
    ScenePass::new(gpu).unwrap().record(
        gpu,
        &mut recorder,
        camera,
        &geometry,
        shadows,
        &color,
        &distance,
        &depth,
    );
    let _ = recorder.submit(gpu).unwrap();
    (color, distance)
}
