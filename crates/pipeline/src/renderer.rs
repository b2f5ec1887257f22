use std::sync::Arc;
use std::time::Instant;

use meniscus_compositor::Compositor;
use meniscus_core::{Camera, Flaw, Flaws, FrameReport, Look, StageCost, WorkCounters};
use meniscus_gpu::role::{Particles, SurfaceColor};
use meniscus_gpu::{CameraUniform, Gpu, Page, Recorder, Span, Texture, Timing};
use meniscus_lod::{LodParams, ParticleCounts, SetStore, SetStoreStats, Viewpoint, explain};
use meniscus_shading::{FoamLook, LightingInputs, LightingPass, SceneGeometry, ScenePass};
use meniscus_ssfr::{ColoredSet, ShapePasses, SplatInput, SplatSet, Ssfr, SurfaceImages, ThicknessParams};

use crate::colors::SurfaceColors;
use crate::counters;
use crate::drawn::{DrawnSet, OPAQUE_LOOKS, is_water_in_front, objects, splat_set, viewpoint};
use crate::foam::{FoamStage, GpuFoam};
use crate::identity::IdentityWatch;
use crate::images::FrameImages;
use crate::lod_view::{self, Canvas, Explained, LodView};
use crate::opaque_sets::{OpaqueSets, Scene};
use crate::sun_view::{SunView, SunViewNeeds};
use crate::{PipelineError, PreparedFrame, Preparer, Registry, Settings, SettingsError, UploadAhead, World};

/// A finished picture.
#[derive(Clone, Debug)]
pub struct Picture {
    /// sRGB, red in the lowest byte, row by row from the top left.
    pub pixels: Vec<u32>,
    /// What it cost and what is wrong with it.
    pub report: FrameReport,
}

/// Draws prepared frames. What is long-lived (pipelines, images, buffers) is kept from frame to frame; a frame of the same
/// size and particle number allocates nothing.
pub struct Renderer {
    gpu: Arc<Gpu>,
    /// Particles on the GPU.
    store: Arc<SetStore>,
    registry: Registry,
    settings: Settings,
    recorder: Recorder,
    scene: ScenePass,
    surface: Ssfr,
    /// `None` until particles are drawn as anything but spheres.
    shapes: Option<ShapePasses>,
    /// `None` where nothing throws shadows; for the size of the last picture.
    sun: Option<SunView>,
    lighting: Box<dyn LightingPass>,
    compositor: Compositor,
    geometry: Option<SceneGeometry>,
    /// The camera that saw what the images show of the scene, where nothing of it moves.
    scene_seen_by: Option<CameraUniform>,
    images: Option<FrameImages>,
    colors: Option<SurfaceColors>,
    opaque: Option<OpaqueSets>,
    foam: Option<FoamStage>,
    sets: Vec<DrawnSet>,
    counts: ParticleCounts,
    counting: bool,
    identities: IdentityWatch,
    /// Set once particles were found to change places.
    unstable: Flaws,
}

impl Renderer {
    /// Compiles all passes that `settings` ask for.
    ///
    /// # Errors
    /// A name that `registry` does not have, a parameter out of range, a shader that the driver does not take.
    pub fn new(gpu: Gpu, registry: Registry, settings: Settings) -> Result<Self, PipelineError> {
        settings.validate(&registry)?;
        let lighting =
            registry.lighting.make(&settings.lighting).map_err(SettingsError::stage)?.compile(&gpu)?;
        Ok(Self {
            recorder: Recorder::new(&gpu, Timing::Stamps),
            scene: ScenePass::new(&gpu)?,
            surface: Ssfr::new(&gpu, &registry.filters, &settings.water_surface(None))?,
            shapes: None,
            sun: None,
            lighting,
            compositor: Compositor::new(&gpu, &settings.post)?,
            geometry: None,
            scene_seen_by: None,
            images: None,
            colors: None,
            opaque: None,
            foam: None,
            sets: Vec::new(),
            counts: ParticleCounts::default(),
            counting: false,
            identities: IdentityWatch::default(),
            unstable: Flaws::default(),
            store: Arc::default(),
            gpu: Arc::new(gpu),
            registry,
            settings,
        })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// The settings in use.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The filters and lighting models there are.
    pub fn registry(&self) -> &Registry {
        &self.registry
    }

    /// Brings frames of `world`'s series into the order that this renderer wants; for reader threads.
    pub fn preparer(&self, world: &World) -> Preparer {
        Preparer {
            page_particles: Page::<Particles>::most_elements(&self.gpu),
            spacing_world: world.space().spacing as f32,
            identity: self.settings.lod.policy.identity(),
            quantity: world.color().map(|scale| scale.quantity.clone()),
            foam: world.foam().cloned(),
        }
    }

    /// Lets particles of frames take up to `bytes` of the GPU's memory: of those that are drawn, of those uploaded ahead
    /// ([`Self::upload_ahead`]), and of those kept until they are shown again. Without it, of those that are drawn; these are
    /// there in any case.
    pub fn set_gpu_memory(&mut self, bytes: u64) {
        self.sets.clear();
        self.gpu.forget_bindings();
        self.store = Arc::new(SetStore::new(bytes));
    }

    /// Starts a thread that uploads frames before they are drawn.
    ///
    /// # Errors
    /// The system's, where it refuses a thread.
    pub fn upload_ahead(&self) -> std::io::Result<UploadAhead> {
        UploadAhead::new(Arc::clone(&self.gpu), Arc::clone(&self.store))
    }

    /// What was uploaded, and what was there already.
    pub fn uploads(&self) -> SetStoreStats {
        self.store.stats()
    }

    /// Changes the level of detail of the following frames. Another policy than that of [`Self::new`] needs frames prepared
    /// for it ([`Self::preparer`]).
    ///
    /// # Errors
    /// A parameter out of range; the level of detail then stays as it was.
    pub fn set_lod(&mut self, params: LodParams) -> Result<(), PipelineError> {
        params.validate()?;
        self.settings.lod = params;
        Ok(())
    }

    /// Exposes the following pictures by `stops`.
    pub(crate) fn set_exposure(&mut self, stops: f32) {
        self.settings.post.exposure = Some(stops);
        self.compositor.set_exposure(stops);
    }

    /// How the following frames are timed.
    pub fn set_timing(&mut self, timing: Timing) {
        self.recorder.set_timing(timing);
    }

    /// Whether passes count their own work in the following frames: splat pixels, filter taps. They are then compiled a second
    /// time and take longer. The other counters are always there.
    pub fn set_counting(&mut self, counting: bool) {
        self.counting = counting;
        self.recorder.set_counting(&self.gpu, counting);
    }

    /// Draws `frame` and reads the picture back.
    ///
    /// # Errors
    /// An unusable camera, or the GPU.
    pub fn render(
        &mut self,
        frame: &PreparedFrame,
        world: &World,
        camera: &Camera,
        size: [u32; 2],
    ) -> Result<Picture, PipelineError> {
        self.draw_and_wait(frame, world, camera, size)?;
        let mut flaws = frame.flaws.clone();
        flaws.merge(&self.unstable);
        if let Some(reason) = self.why_nothing_is_visible()? {
            flaws.add(Flaw::NothingVisible { reason: reason.to_owned() });
        }
        let pixels = self.images().display.read(&self.gpu)?;
        let stages = self.take_costs();
        let counters = self.counters(frame)?;
        let report = FrameReport { frame: frame.index, time: frame.time, counters, stages, flaws };
        Ok(Picture { pixels, report })
    }

    /// Paints over `picture`, which was just drawn of `frame`, what level of detail decided.
    ///
    /// # Errors
    /// The GPU's.
    pub fn paint_lod(
        &self,
        picture: &mut Picture,
        view: LodView,
        frame: &PreparedFrame,
        world: &World,
        camera: &Camera,
    ) -> Result<(), PipelineError> {
        let size = self.surface_images().size();
        let mut canvas = Canvas { pixels: &mut picture.pixels, size, camera };
        self.with_chunks(frame, world, camera, |chunks, distance, reach| {
            canvas.paint(view, chunks, distance, reach, world.space().up);
        })
    }

    /// The kept fraction of the chunk that each pixel of the picture that was just drawn shows; 0 where it shows none.
    pub(crate) fn kept_fractions(
        &self,
        frame: &PreparedFrame,
        world: &World,
        camera: &Camera,
    ) -> Result<Vec<f32>, PipelineError> {
        let size = self.surface_images().size();
        self.with_chunks(frame, world, camera, |chunks, distance, reach| {
            lod_view::kept_fractions(chunks, distance, reach, size, camera)
        })
    }

    /// Calls `look` with all chunks and what became of them, the distance of the water per pixel, and how far from the centres of a
    /// chunk its surface may be.
    fn with_chunks<T>(
        &self,
        frame: &PreparedFrame,
        world: &World,
        camera: &Camera,
        look: impl FnOnce(&[Explained<'_>], &[f32], f32) -> T,
    ) -> Result<T, PipelineError> {
        let surface = self.surface_images();
        let viewpoint = self.viewpoint(world, camera, surface.size());
        let mut chunks = Vec::new();
        for set in &frame.sets {
            let fates = explain(&set.chunked, &viewpoint, &self.settings.lod)?;
            chunks.extend(set.chunked.chunks.iter().zip(fates));
        }
        // Smoothing moves the surface by about a spacing, a grown splat reaches two radii.
        let reach = viewpoint.spacing_world + 2.0 * viewpoint.radius_world * viewpoint.shell_reach;
        Ok(look(&chunks, &surface.distance.read(&self.gpu)?, reach))
    }

    /// Draws `frame` and waits for the GPU; the picture stays there.
    ///
    /// # Errors
    /// As [`Self::render`].
    pub fn draw_and_wait(
        &mut self,
        frame: &PreparedFrame,
        world: &World,
        camera: &Camera,
        size: [u32; 2],
    ) -> Result<(), PipelineError> {
        self.record(frame, world, camera, size)?;
        let begin = Instant::now();
        let submitted = self.recorder.submit(&self.gpu)?;
        self.recorder.note("submit", begin);
        let begin = Instant::now();
        self.gpu.wait_for(submitted)?;
        self.recorder.note("wait for the GPU", begin);
        Ok(())
    }

    /// How much work the last frame was, which drew `frame`: all that was asked of the device since it began, reading results
    /// back included. Waits for the GPU while passes count.
    ///
    /// # Errors
    /// The GPU's.
    pub fn counters(&self, frame: &PreparedFrame) -> Result<WorkCounters, PipelineError> {
        let mut counters = counters::of_host(frame, self.counts, &self.gpu.work(), self.gpu.memory());
        if self.counting {
            counters.particles_hidden = Some(self.counts.tested - self.visible_particles()?);
            counters.covered_pixels = Some(self.surface_images().covered_pixels(&self.gpu)?.into());
            for (name, sum) in self.recorder.tallies(&self.gpu)? {
                // A pass of somebody's own may count what no report has.
                let _ = counters.set(name, sum);
            }
        }
        Ok(counters)
    }

    /// Whether the following frames note what ran when ([`Self::take_spans`]).
    pub fn set_tracing(&mut self, tracing: bool) {
        self.recorder.set_tracing(tracing);
    }

    /// What ran since the last call, on the host's clock; none without [`Self::set_tracing`]. Passes by time stamps come with
    /// [`Self::take_costs`].
    pub fn take_spans(&mut self) -> Vec<Span> {
        self.recorder.take_spans()
    }

    /// Cost per pass of the oldest frame not asked for yet.
    pub fn take_costs(&mut self) -> Vec<StageCost> {
        self.recorder.take_costs(&self.gpu)
    }

    /// Particle numbers of the last frame.
    pub fn counts(&self) -> ParticleCounts {
        self.counts
    }

    /// Surface images of the last frame.
    ///
    /// # Panics
    /// Before the first frame.
    pub fn surface_images(&self) -> &SurfaceImages {
        &self.images().surface
    }

    /// Colour that an attribute gave the surface in the last frame; `None` where nothing is coloured.
    pub fn surface_color(&self) -> Option<&Texture<SurfaceColor>> {
        self.colors.as_ref().map(|colors| &colors.image)
    }

    /// Fraction of the last picture that shows water; waits for the GPU.
    ///
    /// # Errors
    /// The GPU's.
    ///
    /// # Panics
    /// Before the first frame.
    pub fn covered_fraction(&self) -> Result<f64, PipelineError> {
        let surface = self.surface_images();
        let [width, height] = surface.size();
        Ok(f64::from(surface.covered_pixels(&self.gpu)?) / (f64::from(width) * f64::from(height)))
    }

    /// Of the particles that were tested, those in ranges that were not hidden; waits for the GPU.
    fn visible_particles(&self) -> Result<u64, PipelineError> {
        let pages = self.sets.iter().flat_map(|set| set.gpu.pages());
        let mut visible = 0;
        for (_, lists) in pages.filter(|(_, lists)| !lists.occludees.is_empty()) {
            visible += lists.visible.read(&self.gpu)?.iter().map(|range| u64::from(range.count)).sum::<u64>();
        }
        Ok(visible)
    }

    /// `None` where the last picture shows particles.
    fn why_nothing_is_visible(&self) -> Result<Option<&'static str>, PipelineError> {
        let counts = self.counts;
        Ok(if counts.input == 0 {
            Some("the frame has none, or --where, --set and --box leave none; `meniscus info` counts them")
        } else if counts.chunks_culled == counts.chunks {
            Some("all are outside of the view; check --camera or leave it out")
        } else if self.sets.iter().any(|set| !set.foam.is_empty()) {
            None
        } else if counts.kept == 0 {
            Some("the level of detail keeps none; raise --lod")
        } else if self.sets.iter().all(|set| set.look == Look::Water) && self.covered_fraction()? == 0.0 {
            Some(
                "all are hidden, too small to be seen, or too close to the eye; check --camera, --radius and --spacing",
            )
        } else {
            None
        })
    }

    pub(crate) fn images(&self) -> &FrameImages {
        self.images.as_ref().expect("a frame was drawn before its images are asked for")
    }

    /// Puts `radiance`, whose edges are smooth, in place of what was drawn last; its display pixels.
    ///
    /// # Panics
    /// Before the first frame, or if `radiance` is of another size.
    pub(crate) fn recompose(&mut self, radiance: &[[f32; 4]]) -> Result<Vec<u32>, PipelineError> {
        let images = self.images.as_mut().expect("a frame was drawn before it is composed again");
        images.radiance.write_floats(&self.gpu, radiance);
        self.compositor.record_as_drawn(&self.gpu, &mut self.recorder, &images.radiance, &images.display);
        let _ = self.recorder.submit(&self.gpu)?;
        let pixels = images.display.read(&self.gpu)?;
        // What composing again costs is a part of no frame.
        let _ = self.recorder.take_costs(&self.gpu);
        Ok(pixels)
    }

    /// The passes of a frame, in order.
    fn record(
        &mut self,
        frame: &PreparedFrame,
        world: &World,
        camera: &Camera,
        size: [u32; 2],
    ) -> Result<(), PipelineError> {
        self.gpu.restart_work();
        camera.validate()?;
        self.fit_surface(world, camera, size)?;
        self.fit_images(size)?;
        self.fit_colors(size, world)?;
        if self.geometry.is_none() {
            self.geometry = Some(SceneGeometry::new(&self.gpu, world.scene())?);
            self.scene_seen_by = None;
        }
        if !self.settings.lod.is_full() {
            let flaw = self.identities.observe(frame, world.space().spacing as f32);
            if let (Some(flaw), true) = (flaw, self.unstable.is_empty()) {
                self.unstable.add(flaw);
            }
        }
        if let Some(sun) = &mut self.sun {
            sun.release(frame);
        }
        self.select(frame, world, camera, size)?;
        let begin = Instant::now();
        self.fit_opaque(size)?;
        self.fit_sun(size, world)?;
        self.fit_foam(size)?;
        self.find_shapes(frame, world)?;

        let uniform = CameraUniform::new(camera, size);
        let camera_binding = self.recorder.uniform(&uniform);
        let (Some(images), Some(geometry)) = (&self.images, &self.geometry) else { return Ok(()) };
        if let Some(sun) = &mut self.sun {
            let sets = self.sets.iter().map(|set| &set.gpu);
            let how = (&self.registry, &self.settings);
            sun.record(&self.gpu, &mut self.recorder, how, &self.scene, geometry, frame, sets, world)?;
        }
        let has_objects = self.opaque.is_some() || !world.scene().objects.is_empty();
        let shadows = self.sun.as_ref().filter(|_| has_objects).map(SunView::scene);
        // As long as neither the camera moves nor sets are drawn into it, it is there already.
        let is_still = !self.sets.iter().any(|set| OPAQUE_LOOKS.contains(&set.look));
        let before = self.scene_seen_by.take();
        if !is_still || before != Some(uniform) {
            self.scene.record(
                &self.gpu,
                &mut self.recorder,
                &uniform,
                geometry,
                shadows.as_ref(),
                &images.scene_color,
                &images.scene_distance,
                &images.scene_depth,
            );
        }
        self.scene_seen_by = is_still.then_some(uniform);
        let is_in_front = is_water_in_front(frame, world, geometry);
        let pages: Vec<Vec<SplatInput>> = self.sets.iter().map(DrawnSet::splat_inputs).collect();
        // The sets that are drawn in this way and have values to be coloured by, and those that have none.
        let of_look = |look: Look| -> (Vec<ColoredSet>, Vec<ColoredSet>) {
            let sets = self.sets.iter().zip(&pages).filter(|(set, _)| set.look == look);
            let colored = sets.map(|(set, pages)| ColoredSet {
                set: splat_set(pages, world, set.selector.selection(), is_in_front),
                values: &set.values.pages,
            });
            colored.partition(|set| !set.values.is_empty())
        };
        for look in OPAQUE_LOOKS {
            let (colored, plain) = of_look(look);
            // One after the other: a particle's colour spreads to whatever is near it.
            for (sets, colors) in [(colored, self.colors.as_ref()), (plain, None)] {
                if let (Some(opaque), false) = (&self.opaque, sets.is_empty()) {
                    let camera = (&uniform, &camera_binding);
                    let (color, distance) = (&images.scene_color, &images.scene_distance);
                    let scene = Scene { geometry, shadows, color, distance };
                    opaque.record(&self.gpu, &mut self.recorder, camera, &scene, look, &sets, colors);
                }
            }
        }
        let (colored, plain) = of_look(Look::Water);
        let sets: Vec<SplatSet> = colored.iter().chain(&plain).map(|set| set.set).collect();
        self.surface.record(
            &mut self.recorder,
            &self.gpu,
            &camera_binding,
            &sets,
            &images.scene_distance,
            &images.surface,
        );
        if let Some(colors) = &self.colors {
            colors.record(&self.gpu, &mut self.recorder, &camera_binding, &colored, &images.surface);
        }
        let has_sunlight = self.sun.is_some() && self.lighting.uses_sunlight();
        if let (Some(sun), true) = (&self.sun, has_sunlight) {
            sun.record_sunlight(&self.gpu, &mut self.recorder, &uniform, has_objects, images);
        }
        let inputs = LightingInputs {
            camera: &uniform,
            surroundings: geometry.surroundings(),
            environment: geometry.environment(),
            objects: objects(frame, world, geometry),
            scale: world.scale(),
            covered: &images.surface.covered,
            distance: &images.surface.distance,
            thickness: &images.surface.thickness,
            normal: &images.surface.normal,
            surface_color: self.colors.as_ref().map_or(&images.no_color, |colors| &colors.image),
            scene_color: &images.scene_color,
            scene_distance: &images.scene_distance,
            sunlight: if has_sunlight { &images.sunlight } else { &images.no_shadow },
            has_sunlight,
        };
        let bare = self.foam.as_ref().map_or(&images.radiance, FoamStage::bare_radiance);
        self.lighting.record(&self.gpu, &mut self.recorder, &inputs, bare);
        if let Some(foam) = &self.foam {
            let settings = &self.settings.foam;
            let spacing_world = world.space().spacing as f32;
            let drawn = |set| GpuFoam::drawn(set, spacing_world, settings, &self.settings.lod);
            let pages: Vec<_> = self.sets.iter().flat_map(|set| drawn(&set.foam)).collect();
            let extinction = self.lighting.extinction(world.scale());
            let look =
                FoamLook::new(extinction, world.scale(), settings.curvature, settings.curvature_threshold);
            foam.record(
                &self.gpu,
                &mut self.recorder,
                &camera_binding,
                &pages,
                &images.surface,
                &inputs,
                &look,
                &images.radiance,
            );
        }
        self.compositor.record(&self.gpu, &mut self.recorder, &images.radiance, &images.display);
        self.recorder.note("record", begin);
        Ok(())
    }

    /// Takes the parameters of the surface that suit the water, the camera and the level of detail. Below full detail, where coarse
    /// stand-ins take the place of particles in the thickness, it is sampled in coarser steps; else only where nobody sees that,
    /// and not where finer steps than usual were asked for.
    fn fit_surface(&mut self, world: &World, camera: &Camera, size: [u32; 2]) -> Result<(), PipelineError> {
        let mut params = self.settings.water_surface(Some(world.water()));
        let uniform = CameraUniform::new(camera, size);
        let away = (world.bounds().center() - camera.eye).dot(camera.forward());
        let distance = if uniform.orthographic == 0 { away.max(camera.near) } else { 1.0 };
        let spacing_px = world.space().spacing as f32 * uniform.px_per_world_at_one / distance;
        if self.settings.is_thinned() {
            params.thickness = params.thickness.coarsened(spacing_px, 0.75);
        } else if params.thickness.scale == ThicknessParams::default().scale {
            params.thickness = params.thickness.coarsened(spacing_px, 2.0);
        }
        Ok(self.surface.set_params(&self.gpu, &self.registry.filters, &params)?)
    }

    fn fit_images(&mut self, size: [u32; 2]) -> Result<(), PipelineError> {
        let params = self.surface.params();
        if !self.images.as_ref().is_some_and(|images| images.surface.fit(size, params)) {
            // The old ones go first: two sets of images may not fit.
            self.images = None;
            self.scene_seen_by = None;
            self.images = Some(FrameImages::new(&self.gpu, size, params)?);
            self.compositor.resize(&self.gpu, size)?;
        }
        Ok(())
    }

    /// Makes what colours the water, if anything does.
    fn fit_colors(&mut self, size: [u32; 2], world: &World) -> Result<(), PipelineError> {
        match (world.color(), &self.colors) {
            (Some(scale), Some(colors)) if colors.fit(size, scale) => {}
            (scale, _) => {
                self.colors = None;
                self.colors = scale.map(|scale| SurfaceColors::new(&self.gpu, size, scale)).transpose()?;
            }
        }
        Ok(())
    }

    /// Makes what draws opaque sets, if there are any.
    fn fit_opaque(&mut self, size: [u32; 2]) -> Result<(), PipelineError> {
        let needed = self.sets.iter().any(|set| OPAQUE_LOOKS.contains(&set.look));
        if needed && self.opaque.as_ref().is_none_or(|opaque| opaque.size() != size) {
            self.opaque = Some(OpaqueSets::new(&self.gpu, &self.registry, &self.settings.surface, size)?);
        }
        Ok(())
    }

    /// Makes what throws shadows, if anything does.
    fn fit_sun(&mut self, size: [u32; 2], world: &World) -> Result<(), PipelineError> {
        if self.sun.as_ref().is_some_and(|sun| sun.picture() == size) {
            return Ok(());
        }
        // The old one first: two may not fit.
        self.sun = None;
        let needs = SunViewNeeds {
            size,
            sunlight: self.lighting.uses_sunlight(),
            objects: self.opaque.is_some() || !world.scene().objects.is_empty(),
        };
        self.sun = SunView::new(&self.gpu, &self.registry, &self.settings, world, &needs)?;
        Ok(())
    }

    /// Makes what draws foam, if there is to be any.
    fn fit_foam(&mut self, size: [u32; 2]) -> Result<(), PipelineError> {
        if self.settings.foam.is_on() && self.foam.as_ref().is_none_or(|foam| foam.size() != size) {
            self.foam = None;
            self.foam = Some(FoamStage::new(&self.gpu, size)?);
        }
        Ok(())
    }

    /// Finds the shapes that the water's particles are drawn as, where they have changed.
    fn find_shapes(&mut self, frame: &PreparedFrame, world: &World) -> Result<(), PipelineError> {
        let params = &self.surface.params().anisotropy;
        if !params.is_on() {
            return Ok(());
        }
        let passes = match &mut self.shapes {
            Some(passes) => passes,
            none => none.insert(ShapePasses::new(&self.gpu)?),
        };
        for (drawn, set) in self.sets.iter_mut().zip(&frame.sets).filter(|(_, set)| set.look == Look::Water) {
            drawn.shapes.find(
                &self.gpu,
                &mut self.recorder,
                passes,
                &drawn.gpu,
                &set.chunked,
                params,
                world,
            )?;
        }
        Ok(())
    }

    fn viewpoint(&self, world: &World, camera: &Camera, size: [u32; 2]) -> Viewpoint {
        let spheres = viewpoint(world, camera, size, self.surface.params());
        let spacing_per_radius = spheres.spacing_world / spheres.radius_world;
        let shell_reach = self.surface.params().anisotropy.reach_radii(spacing_per_radius);
        Viewpoint { shell_reach, ..spheres }
    }

    /// Uploads the sets and what of them is kept, where either has changed.
    fn select(
        &mut self,
        frame: &PreparedFrame,
        world: &World,
        camera: &Camera,
        size: [u32; 2],
    ) -> Result<(), PipelineError> {
        self.sets.truncate(frame.sets.len());
        self.sets.resize_with(frame.sets.len(), DrawnSet::new);
        self.counts = ParticleCounts::default();
        let viewpoint = self.viewpoint(world, camera, size);
        for (drawn, set) in self.sets.iter_mut().zip(&frame.sets) {
            drawn.look = set.look;
            let begin = Instant::now();
            drawn.gpu.upload(&self.gpu, &self.store, &set.chunked)?;
            drawn.values.upload(&self.gpu, &set.chunked, &set.values)?;
            drawn.foam.upload(&self.gpu, &set.chunked)?;
            self.recorder.note("upload particles", begin);
            let begin = Instant::now();
            let is_new = drawn.selector.update(&set.chunked, &viewpoint, &self.settings.lod)?;
            self.recorder.note("select", begin);
            if is_new {
                let begin = Instant::now();
                drawn.gpu.update(&self.gpu, drawn.selector.selection())?;
                self.recorder.note("upload what is drawn", begin);
            }
            self.counts += drawn.selector.selection().counts;
        }
        Ok(())
    }
}
