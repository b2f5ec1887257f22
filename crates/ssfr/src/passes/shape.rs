use meniscus_core::Aabb;
use meniscus_gpu::role::{GridParticles, Particles, Scratch, Shapes};
use meniscus_gpu::{
    Binding, Buffer, ComputePipeline, Definition, Dispatch, Gpu, GpuError, Page, RangeList, Recorder,
    Texture, shader,
};

use super::{pipeline, pipeline_with};
use crate::AnisotropyParams;
use crate::shape::ShapeUniform;

/// A page of particles and room for the shapes of its shell.
#[derive(Clone, Copy, Debug)]
pub struct ShapePage<'a> {
    /// The particles.
    pub particles: &'a Page<Particles>,
    /// Where shapes go, as the ranges of the targets say.
    pub shapes: &'a Buffer<Shapes>,
}

/// Particles that get shapes, and all that may be near them; one list of each for each page, of which those of the sources may hold
/// none.
#[derive(Clone, Copy, Debug)]
pub struct ShapeWork<'a> {
    /// Box around the targets, world.
    pub bounds: Aabb,
    /// What gets shapes.
    pub targets: &'a [RangeList],
    /// What they may be neighbours of, themselves included.
    pub sources: &'a [RangeList],
    /// Number of particles in `sources`.
    pub source_particles: usize,
}

/// Finds the shapes that particles are drawn as ([`AnisotropyParams`]), once for a frame of particles, whatever the camera. Their
/// neighbours are found in a uniform grid (Green, Particle simulation using CUDA, 2010).
#[derive(Debug)]
pub struct ShapePasses {
    count: ComputePipeline,
    room: ComputePipeline,
    scatter: ComputePipeline,
    shape: ComputePipeline,
    cells: Buffer<Scratch>,
    taken: Buffer<Scratch>,
    by_cell: Texture<GridParticles>,
}

/// Width of the texture that holds the particles by cell; `shaders/ssfr/shape.inc.wgsl`.
const ROW: u32 = 8192;
/// Words of a cell.
const CELL_WORDS: usize = 3;
/// Cells that an invocation gives room to.
const RUN: u64 = 16;

impl ShapePasses {
    /// Makes the passes and room for small sets.
    ///
    /// # Errors
    /// The GPU's memory is full.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let scatter = Definition { name: "SCATTER", value: 1 };
        Ok(Self {
            count: pipeline(gpu, shader!("ssfr/shape_grid")),
            room: pipeline(gpu, shader!("ssfr/shape_room")),
            scatter: pipeline_with(gpu, shader!("ssfr/shape_grid"), &[scatter]),
            shape: pipeline(gpu, shader!("ssfr/shape")),
            cells: Buffer::new(gpu, CELL_WORDS)?,
            taken: Buffer::new(gpu, 1)?,
            by_cell: Texture::new(gpu, [ROW, 1])?,
        })
    }

    /// Records the passes for `work`, particles of `pages` that are drawn with `radius_world` and `spacing_world` apart.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] and [`GpuError::OutOfMemory`] where the device has no room for the grid.
    ///
    /// # Panics
    /// If there are not as many lists as pages.
    pub fn record(
        &mut self,
        recorder: &mut Recorder,
        gpu: &Gpu,
        pages: &[ShapePage<'_>],
        work: &ShapeWork<'_>,
        params: &AnisotropyParams,
        (radius_world, spacing_world): (f32, f32),
    ) -> Result<(), GpuError> {
        assert_eq!((pages.len(), pages.len()), (work.targets.len(), work.sources.len()), "lists of pages");
        let uniform = ShapeUniform::new(params, &work.bounds, radius_world, spacing_world);
        let cells = uniform.cells() as usize;
        self.reserve(gpu, cells, work.source_particles)?;
        let rule = recorder.uniform(&uniform);
        let shared = [("rule", rule), ("cells", self.cells.bind())];
        recorder.clear(gpu, "ssfr.shape_grid", &self.cells, CELL_WORDS * cells);
        recorder.clear(gpu, "ssfr.shape_grid", &self.taken, 1);
        Self::each_source(recorder, gpu, pages, work, &self.count, &shared);
        recorder.compute(
            gpu,
            "ssfr.shape_grid",
            &self.room,
            &[shared[0].clone(), shared[1].clone(), ("taken", self.taken.bind())],
            Dispatch::Groups((cells as u64).div_ceil(64 * RUN)),
        );
        let with_texture = [&shared[..], &[("by_cell", self.by_cell.bind())]].concat();
        Self::each_source(recorder, gpu, pages, work, &self.scatter, &with_texture);
        for (page, ranges) in pages.iter().zip(work.targets) {
            let of_page =
                [("page", page.particles.bind()), ("ranges", ranges.bind()), ("shapes", page.shapes.bind())];
            let bindings = [&with_texture[..], &of_page].concat();
            recorder.compute(
                gpu,
                "ssfr.shape",
                &self.shape,
                &bindings,
                Dispatch::Groups(ranges.len() as u64),
            );
        }
        Ok(())
    }

    /// Runs `pipeline` over the sources of every page.
    fn each_source(
        recorder: &mut Recorder,
        gpu: &Gpu,
        pages: &[ShapePage<'_>],
        work: &ShapeWork<'_>,
        pipeline: &ComputePipeline,
        shared: &[(&'static str, Binding)],
    ) {
        for (page, ranges) in pages.iter().zip(work.sources) {
            let of_page = [("page", page.particles.bind()), ("ranges", ranges.bind())];
            let bindings = [shared, &of_page].concat();
            let groups = Dispatch::Groups(ranges.len() as u64);
            recorder.compute(gpu, "ssfr.shape_grid", pipeline, &bindings, groups);
        }
    }

    /// Makes room, by half more than is needed, so that the next frame seldom needs more.
    fn reserve(&mut self, gpu: &Gpu, cells: usize, particles: usize) -> Result<(), GpuError> {
        self.cells.reserve(gpu, CELL_WORDS * cells)?;
        let rows = particles.div_ceil(ROW as usize);
        if (self.by_cell.size()[1] as usize) < rows {
            gpu.forget_bindings();
            let most = gpu.limits().max_texture_dimension_2d as usize;
            let roomy = (rows * 3 / 2).min(most).max(rows);
            self.by_cell = Texture::new(gpu, [ROW, u32::try_from(roomy).unwrap_or(u32::MAX)])?;
        }
        Ok(())
    }
}
