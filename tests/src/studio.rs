use glam::{DVec3, Vec3};
use meniscus_core::{
    Aabb, Camera, Look, ParticleFrame, ParticleSet, Projection, RadiusChoice, SeriesSpace, SetFrame,
    SpacingSource, UpAxis,
};
use meniscus_gpu::{AdapterChoice, Gpu, role::NO_SURFACE};
use meniscus_pipeline::{LodParams, PipelineError, PreparedFrame, Registry, Renderer, Settings, World};

use crate::{Mask, Pixels};

/// The space of particles made in world space, z up.
pub fn space(spacing: f32, radius: f32) -> SeriesSpace {
    SeriesSpace {
        origin: DVec3::ZERO,
        spacing: spacing.into(),
        spacing_source: SpacingSource::User,
        radius: radius.into(),
        radius_choice: RadiusChoice::User,
        up: UpAxis::Z,
        metres_per_unit: 1.0,
    }
}

/// The pipeline as a library draws a set of water particles.
pub struct Studio {
    renderer: Renderer,
    world: World,
    frame: SetFrame,
    prepared: Option<PreparedFrame>,
}

/// The surface images of a picture, row by row from the top left.
pub struct Shot {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Distance of the surface along the view axis, world units; [`NO_SURFACE`] where there is none.
    pub distance: Vec<f32>,
    /// Length of water along the ray, world units.
    pub thickness: Vec<f32>,
    /// Where water is seen.
    pub mask: Mask,
    /// Particles kept and given.
    pub kept: [u64; 2],
}

impl Studio {
    /// A renderer with `settings` for `positions` (world) in `space`, on the adapter that the program takes.
    ///
    /// # Errors
    /// As [`Renderer::new`]. A missing adapter is one: tests that need it must not pass without.
    pub fn new(
        positions: Vec<[f32; 3]>,
        space: SeriesSpace,
        settings: Settings,
    ) -> Result<Self, PipelineError> {
        let particles = ParticleFrame { positions, ..Default::default() };
        let water = ParticleSet { name: "water".into(), look: Look::Water, particles };
        let frame = SetFrame { sets: vec![water], ..Default::default() };
        let world = World::of_frame(&frame, space, &settings)?;
        let renderer = Renderer::new(Gpu::new(&AdapterChoice::default())?, Registry::builtin(), settings)?;
        Ok(Self { renderer, world, frame, prepared: None })
    }

    /// Draws the following pictures with another level of detail.
    ///
    /// # Errors
    /// As [`Renderer::set_lod`].
    pub fn set_lod(&mut self, params: LodParams) -> Result<(), PipelineError> {
        self.renderer.set_lod(params)
    }

    /// Draws other particles of the same series.
    pub fn set_positions(&mut self, positions: Vec<[f32; 3]>) {
        self.frame.sets[0].particles.positions = positions;
        self.prepared = None;
    }

    /// Draws the whole picture.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn picture(&mut self, camera: &Camera, size: [u32; 2]) -> Result<Pixels, PipelineError> {
        self.prepare();
        let Some(prepared) = &self.prepared else { unreachable!("prepared above") };
        let picture = self.renderer.render(prepared, &self.world, camera, size)?;
        Ok(Pixels { size, rgba: picture.pixels.iter().map(|p| p.to_le_bytes()).collect() })
    }

    fn prepare(&mut self) {
        let prepare = || self.renderer.preparer(&self.world).prepare(self.frame.clone());
        self.prepared.get_or_insert_with(prepare);
    }

    /// Draws and reads the surface images back.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn shoot(&mut self, camera: &Camera, size: [u32; 2]) -> Result<Shot, PipelineError> {
        self.prepare();
        let Some(prepared) = &self.prepared else { unreachable!("prepared above") };
        self.renderer.draw_and_wait(prepared, &self.world, camera, size)?;
        let images = self.renderer.surface_images();
        let distance = images.distance.read(self.renderer.gpu())?;
        let thickness = images.thickness.read(self.renderer.gpu())?;
        let mask = Mask::new(size, distance.iter().map(|d| *d < NO_SURFACE).collect());
        let counts = self.renderer.counts();
        Ok(Shot { size, distance, thickness, mask, kept: [counts.kept, counts.input] })
    }

    /// Box around the particles, world.
    pub fn bounds(&self) -> Aabb {
        self.world.bounds()
    }

    /// A parallel camera along `direction` (world, not vertical) at the middle of the particles; the picture is
    /// `height_world` high.
    pub fn parallel(&self, direction: Vec3, height_world: f32) -> Camera {
        let target = self.bounds().center();
        let distance = self.bounds().extent().length() * 2.0;
        Camera {
            eye: target - direction.normalize() * distance,
            target,
            up: Vec3::Z,
            projection: Projection::Orthographic { height_world },
            near: self.world.near_distance(),
        }
    }
}
