//! Scene and water as the sun sees them: what throws shadows and caustics.

use glam::Vec3;
use meniscus_core::{Aabb, Camera, Look, Projection};
use meniscus_gpu::role::{Role, SceneColor, SceneDepth, SceneDistance};
use meniscus_gpu::{CameraUniform, Gpu, Image, Recorder, Texture};
use meniscus_lod::{GpuSet, Selector};
use meniscus_shading::{
    Caustics, CausticsPass, CausticsScratch, SceneGeometry, ScenePass, SunView as SunScene, SunWater,
    SunlightPass, Waves,
};
use meniscus_ssfr::filter::NarrowRange;
use meniscus_ssfr::{
    AnisotropyParams, ColoredSet, FilterChoice, SplatInput, SplatSet, Ssfr, SsfrParams, SurfaceImages,
};

use crate::drawn::{OPAQUE_LOOKS, is_water_in_front, splat_inputs, splat_set, viewpoint};
use crate::images::FrameImages;
use crate::opaque_sets::{OpaqueSets, Scene};
use crate::{PipelineError, PreparedFrame, Registry, Settings, World};

/// A picture along the sun's rays, of all that is near the water. It belongs to a series and a size of pictures, not to a camera:
/// it is drawn anew when the particles change.
pub(crate) struct SunView {
    camera: Camera,
    uniform: CameraUniform,
    scene_color: Texture<SceneColor>,
    scene_distance: Texture<SceneDistance>,
    scene_depth: Texture<SceneDepth>,
    opaque: Option<OpaqueSets>,
    water: Option<WaterView>,
    sets: Vec<SunSet>,
    /// Serials of the sets that are in the picture.
    drawn: Option<Vec<u64>>,
    /// Size of the pictures that it is for.
    picture: [u32; 2],
}

/// What only lighting models that look at sunlight need.
struct WaterView {
    surface: Ssfr,
    images: SurfaceImages,
    sunlight: SunlightPass,
    focus: Option<Focus>,
    /// 1 everywhere without focus.
    caustics: Image<Caustics>,
}

/// What caustics need.
struct Focus {
    pass: CausticsPass,
    strength: f32,
    scratch: CausticsScratch,
}

/// A set and what of it the sun sees.
#[derive(Default)]
struct SunSet {
    gpu: GpuSet,
    selector: Selector,
}

/// What a sun view is made for.
pub(crate) struct SunViewNeeds {
    /// Size of the picture.
    pub(crate) size: [u32; 2],
    /// Whether the lighting model asks what sunlight arrives.
    pub(crate) sunlight: bool,
    /// Whether there is something besides the water and the floor.
    pub(crate) objects: bool,
}

/// Pixels of the smallest sun's picture: tiny pictures of the water still have shadows of some shape.
const LEAST_PIXELS: f32 = 16384.0;
/// And of the largest one.
const MOST_PIXELS: f32 = 4_194_304.0;
/// Most pixels between particles where only water throws shadows: it shows nothing finer than particles, and smoothing it over
/// hundreds of pixels would take longer than the picture itself.
const MOST_PER_SPACING: f32 = 4.0;
/// How far the surface is smoothed that bends the light, spacings.
const WAVES_SIGMA: f32 = 4.0;
/// Below this sine of its elevation the sun throws no shadows: they would be longer than what there is.
const LEAST_SINE: f32 = 0.05;

impl SunView {
    /// `None` where nothing would throw a shadow that somebody looks at.
    pub(crate) fn new(
        gpu: &Gpu,
        registry: &Registry,
        settings: &Settings,
        world: &World,
        needs: &SunViewNeeds,
    ) -> Result<Option<Self>, PipelineError> {
        let scene = world.scene();
        let is_dark = Vec3::from(scene.sun.irradiance).max_element() <= 0.0;
        let is_low = scene.sun.direction.dot(scene.up.vector()) < LEAST_SINE;
        let is_needed = needs.sunlight || needs.objects;
        if !settings.scene.shadows || !is_needed || is_dark || is_low || world.bounds().is_empty() {
            return Ok(None);
        }
        let (camera, size) = sun_camera(world, needs);
        if camera.validate().is_err() {
            return Ok(None);
        }
        let water = needs.sunlight.then(|| WaterView::new(gpu, registry, settings, size)).transpose()?;
        Ok(Some(Self {
            uniform: CameraUniform::new(&camera, size),
            camera,
            scene_color: Texture::new(gpu, size)?,
            scene_distance: Texture::new(gpu, size)?,
            scene_depth: Texture::new(gpu, size)?,
            opaque: None,
            water,
            sets: Vec::new(),
            drawn: None,
            picture: needs.size,
        }))
    }

    /// Size of the pictures that it is for.
    pub(crate) fn picture(&self) -> [u32; 2] {
        self.picture
    }

    /// Lets go of the particles of another frame than `frame`, before that one comes to the GPU.
    pub(crate) fn release(&mut self, frame: &PreparedFrame) {
        if self.drawn.as_ref().is_some_and(|drawn| *drawn != serials(frame)) {
            self.drawn = None;
            self.sets.iter_mut().for_each(|set| set.gpu.release());
        }
    }

    /// Draws `frame`, whose `sets` are on the GPU, unless it is in the picture already.
    #[expect(clippy::too_many_arguments, reason = "it draws a whole picture")]
    pub(crate) fn record<'a>(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        (registry, settings): (&Registry, &Settings),
        scene_pass: &ScenePass,
        geometry: &SceneGeometry,
        frame: &PreparedFrame,
        sets: impl Iterator<Item = &'a GpuSet>,
        world: &World,
    ) -> Result<(), PipelineError> {
        if self.drawn.is_some() {
            return Ok(());
        }
        self.select(gpu, frame, sets, world, settings)?;
        recorder.set_view("sun/");
        let drawn = self.draw(gpu, recorder, (registry, settings), scene_pass, geometry, frame, world);
        recorder.set_view("");
        drawn?;
        self.drawn = Some(serials(frame));
        Ok(())
    }

    fn select<'a>(
        &mut self,
        gpu: &Gpu,
        frame: &PreparedFrame,
        sets: impl Iterator<Item = &'a GpuSet>,
        world: &World,
        settings: &Settings,
    ) -> Result<(), PipelineError> {
        self.sets.resize_with(frame.sets.len(), SunSet::default);
        let viewpoint = viewpoint(world, &self.camera, self.uniform.size_px, &settings.surface);
        for ((seen, on_gpu), set) in self.sets.iter_mut().zip(sets).zip(&frame.sets) {
            seen.gpu.share(gpu, on_gpu)?;
            seen.selector.update(&set.chunked, &viewpoint, &settings.lod)?;
            seen.gpu.update(gpu, seen.selector.selection())?;
        }
        Ok(())
    }

    #[expect(clippy::too_many_arguments, reason = "it draws a whole picture")]
    fn draw(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        (registry, settings): (&Registry, &Settings),
        scene_pass: &ScenePass,
        geometry: &SceneGeometry,
        frame: &PreparedFrame,
        world: &World,
    ) -> Result<(), PipelineError> {
        let has_opaque = frame.sets.iter().any(|set| OPAQUE_LOOKS.contains(&set.look));
        if has_opaque && self.opaque.is_none() {
            let size = self.uniform.size_px;
            self.opaque = Some(OpaqueSets::new(gpu, registry, &settings.surface, size)?);
        }
        let camera_binding = recorder.uniform(&self.uniform);
        scene_pass.record(
            gpu,
            recorder,
            &self.uniform,
            geometry,
            None,
            &self.scene_color,
            &self.scene_distance,
            &self.scene_depth,
        );
        let pages: Vec<Vec<SplatInput>> = self.sets.iter().map(|set| splat_inputs(&set.gpu)).collect();
        let is_in_front = is_water_in_front(frame, world, geometry);
        let splats = |look: Look| -> Vec<SplatSet> {
            let of_look =
                self.sets.iter().zip(&frame.sets).zip(&pages).filter(|((_, set), _)| set.look == look);
            of_look
                .map(|((seen, _), pages)| splat_set(pages, world, seen.selector.selection(), is_in_front))
                .collect()
        };
        for look in OPAQUE_LOOKS {
            // The sun asks what is there, not what colour it has.
            let sets: Vec<_> = splats(look).into_iter().map(|set| ColoredSet { set, values: &[] }).collect();
            if let (Some(opaque), false) = (&self.opaque, sets.is_empty()) {
                let camera = (&self.uniform, &camera_binding);
                let scene = Scene {
                    geometry,
                    shadows: None,
                    color: &self.scene_color,
                    distance: &self.scene_distance,
                };
                opaque.record(gpu, recorder, camera, &scene, look, &sets, None);
            }
        }
        if let Some(water) = &self.water {
            let sets = splats(Look::Water);
            water.surface.record(recorder, gpu, &camera_binding, &sets, &self.scene_distance, &water.images);
            if let Some(Focus { pass, strength, scratch }) = &water.focus {
                let waves = Waves {
                    distance: &water.images.distance,
                    normal: &water.images.normal,
                    spacing_world: world.space().spacing as f32,
                    strength: *strength,
                };
                pass.record(gpu, recorder, &self.scene(), &waves, scratch, &water.caustics);
            }
        }
        Ok(())
    }

    /// What objects throw shadows by.
    pub(crate) fn scene(&self) -> SunScene<'_> {
        SunScene { camera: &self.uniform, scene_distance: &self.scene_distance }
    }

    /// Finds what sunlight arrives where `images` show something, if the lighting model asks for that.
    pub(crate) fn record_sunlight(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        camera: &CameraUniform,
        has_objects: bool,
        images: &FrameImages,
    ) {
        let Some(water) = &self.water else { return };
        let seen = SunWater {
            distance: &water.images.distance,
            thickness: &water.images.thickness,
            caustics: &water.caustics,
        };
        let (distance, scene) = (&images.surface.distance, &images.scene_distance);
        let output = &images.sunlight;
        let view = self.scene();
        water.sunlight.record(gpu, recorder, camera, &view, &seen, distance, scene, has_objects, output);
    }
}

impl WaterView {
    fn new(
        gpu: &Gpu,
        registry: &Registry,
        settings: &Settings,
        size: [u32; 2],
    ) -> Result<Self, PipelineError> {
        // Waves focus light, single particles do not: bumps of a spacing would be seen as a net of dots.
        let sigma = serde_json::Map::from_iter([("sigma".to_owned(), WAVES_SIGMA.into())]);
        let filter = FilterChoice { name: NarrowRange::NAME.to_owned(), parameters: sigma };
        let anisotropy = AnisotropyParams::default();
        let params = SsfrParams { filter, anisotropy, ..settings.surface.clone() };
        let strength = settings.scene.caustics;
        let is_focused = strength > 0.0;
        let focus = || -> Result<Focus, PipelineError> {
            let scratch = CausticsScratch::new(gpu, size)?;
            Ok(Focus { pass: CausticsPass::new(gpu)?, strength, scratch })
        };
        Ok(Self {
            surface: Ssfr::new(gpu, &registry.filters, &params)?,
            images: SurfaceImages::new(gpu, size, &params)?,
            sunlight: SunlightPass::new(gpu)?,
            focus: is_focused.then(focus).transpose()?,
            caustics: if is_focused {
                Image::new(gpu, size)?
            } else {
                Image::from_pixels(gpu, size, &vec![Caustics::EMPTY; size[0] as usize * size[1] as usize])?
            },
        })
    }
}

fn serials(frame: &PreparedFrame) -> Vec<u64> {
    frame.sets.iter().map(|set| set.chunked.serial()).collect()
}

/// A camera that looks along the sun's rays at everything near the water, and a size for it with about as many pixels as the pictures
/// have that it is for, or as particles are worth.
fn sun_camera(world: &World, needs: &SunViewNeeds) -> (Camera, [u32; 2]) {
    let scene = world.scene();
    let water = world.bounds().inflated(2.0 * world.space().spacing as f32);
    // Objects farther away than the water is large throw no shadows on it that could be seen in any detail.
    let near = water.inflated(water.extent().length());
    let objects = scene.objects.iter().flat_map(|object| &object.mesh.positions).map(|&p| Vec3::from(p));
    let is_near = |p: &Vec3| p.clamp(near.min, near.max) == *p;
    let points = objects.filter(is_near).chain(water.corners());
    let to_sun = scene.sun.direction;
    let up = to_sun.any_orthonormal_vector();
    let right = up.cross(to_sun);
    let seen = points.map(|p| Vec3::new(p.dot(right), p.dot(up), p.dot(to_sun)));
    let bounds = seen.fold(Aabb::EMPTY, |all, p| all.union(Aabb { min: p, max: p }));
    let extent = bounds.extent().max(Vec3::splat(world.space().spacing as f32));
    // A margin for what lies at the border, whose neighbours are looked at, too.
    let (width, height) = (1.04 * extent.x, 1.04 * extent.y);
    let center = bounds.center();
    let target = center.x * right + center.y * up + center.z * to_sun;
    let far = extent.length();
    let camera = Camera {
        eye: target + far * to_sun,
        target,
        up,
        projection: Projection::Orthographic { height_world: height },
        near: 1e-3 * far,
    };
    (camera, size_for(width, height, world.space().spacing as f32, needs))
}

/// Pixels of a sun's picture of `width` times `height` (world), of particles that are `spacing_world` apart.
fn size_for(width: f32, height: f32, spacing_world: f32, needs: &SunViewNeeds) -> [u32; 2] {
    let finest = spacing_world / MOST_PER_SPACING;
    let enough = if needs.objects { f32::INFINITY } else { width / finest * (height / finest) };
    let pixels = (needs.size[0] as f32 * needs.size[1] as f32).min(enough).clamp(LEAST_PIXELS, MOST_PIXELS);
    let rows = (pixels * height / width).sqrt().clamp(16.0, 4096.0);
    let columns = (rows * width / height).clamp(16.0, 4096.0);
    [columns.round() as u32, rows.round() as u32]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_sees_no_finer_than_particles_are_worth() {
        let needs = |objects| SunViewNeeds { size: [1280, 720], sunlight: true, objects };
        // 80 x 40 particles, four pixels apart.
        assert_eq!(size_for(8.0, 4.0, 0.1, &needs(false)), [320, 160]);
        // As many pixels as the picture has: edges of objects may be sharp, and so may those of a million particles.
        for size in [size_for(8.0, 4.0, 0.1, &needs(true)), size_for(8.0, 4.0, 0.001, &needs(false))] {
            let pixels = size[0] as f32 * size[1] as f32;
            // To whole rows and columns.
            assert!((pixels / (1280.0 * 720.0) - 1.0).abs() < 0.01, "{size:?}");
        }
        // Few particles have a shadow of some shape nevertheless.
        assert_eq!(size_for(2.0, 2.0, 1.0, &needs(false)), [128, 128]);
    }
}
