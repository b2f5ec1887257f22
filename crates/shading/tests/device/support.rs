//! A device, a scene, and the analytic water of the conformance suite.

use glam::Vec3;
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
