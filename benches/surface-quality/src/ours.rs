//! The screen-space surface.

use glam::Vec3;
use meniscus_gpu::{AdapterChoice, Gpu};
use meniscus_pipeline::{Layer, LodMode, PipelineError, Registry, Renderer, Settings};

use crate::subject::View;
use crate::surface::Surface;

/// What `meniscus render` draws by itself, but for what a mesh knows nothing of: a floor that cuts the water off.
pub fn settings() -> Settings {
    let mut settings = Settings::default();
    settings.lod.mode = LodMode::ErrorBound;
    settings.scene.floor = Some(false);
    settings.scene.shadows = false;
    settings
}

/// Adapter and driver.
///
/// # Errors
/// Without an adapter there is nothing to compare.
pub fn adapter() -> Result<String, PipelineError> {
    let gpu = Gpu::new(&AdapterChoice::default())?;
    Ok(format!("{} ({})", gpu.summary().name, gpu.summary().driver))
}

/// The surface of `view`, drawn with `settings` into a picture of `size`.
///
/// # Errors
/// As [`Renderer::render`].
pub fn draw(view: &View, size: [u32; 2], settings: &Settings) -> Result<Surface, PipelineError> {
    let gpu = Gpu::new(&AdapterChoice::default())?;
    let mut renderer = Renderer::new(gpu, Registry::builtin(), settings.clone())?;
    let frame = renderer.preparer(&view.world).prepare(view.particles.clone());
    renderer.draw_and_wait(&frame, &view.world, &view.camera, size)?;
    let channels = renderer.layers(&[Layer::Depth, Layer::Normal], &frame, &view.world, &view.camera)?;
    let [distance, x, y, z] = &channels[..] else { unreachable!("one channel of depth, three of normals") };
    let to_view = view.camera.view_from_world();
    let normal = |i| to_view.transform_vector3(Vec3::new(x.values[i], y.values[i], z.values[i]));
    Ok(Surface { normal: (0..x.values.len()).map(normal).collect(), distance: Some(distance.values.clone()) })
}
