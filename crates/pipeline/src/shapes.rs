use meniscus_gpu::role::Shapes;
use meniscus_gpu::{Buffer, Gpu, RangeList, Recorder};
use meniscus_lod::{ChunkedSet, GpuSet, ShapeBatch, shape_batches};
use meniscus_ssfr::{AnisotropyParams, ShapePage, ShapePasses, ShapeWork};

use crate::{PipelineError, World};

/// Most particles whose neighbours are looked for at once: as many cells of a grid as there may be, and 64 MB.
const BATCH_PARTICLES: usize = 1 << 22;

/// The shapes of a set's particles on the GPU, found once for a frame.
#[derive(Debug, Default)]
pub(crate) struct SetShapes {
    serial: Option<u64>,
    pages: Vec<Buffer<Shapes>>,
    /// Pages of the present set; the rest waits for a larger one.
    in_use: usize,
    batches: Vec<BatchLists>,
}

/// The ranges of a batch on the GPU, page by page.
#[derive(Debug, Default)]
struct BatchLists {
    targets: Vec<RangeList>,
    sources: Vec<RangeList>,
}

impl SetShapes {
    /// The shapes of each page, where there are any.
    pub(crate) fn pages(&self) -> &[Buffer<Shapes>] {
        &self.pages[..self.in_use]
    }

    /// Records what finds the shapes of `set`, whose particles `on_gpu` has, unless that was done.
    #[expect(clippy::too_many_arguments, reason = "what passes are recorded with, and what shapes depend on")]
    pub(crate) fn find(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        passes: &mut ShapePasses,
        on_gpu: &GpuSet,
        set: &ChunkedSet,
        params: &AnisotropyParams,
        world: &World,
    ) -> Result<(), PipelineError> {
        if self.serial == Some(set.serial()) {
            return Ok(());
        }
        self.serial = None;
        self.in_use = set.pages().len();
        for page in 0..self.in_use {
            let needed = set.shapes_in(page);
            match self.pages.get_mut(page) {
                Some(shapes) => shapes.reserve(gpu, needed)?,
                None => self.pages.push(Buffer::new(gpu, needed)?),
            }
        }
        let (radius, spacing) = (world.space().radius as f32, world.space().spacing as f32);
        let batches = shape_batches(set, params.support * spacing, BATCH_PARTICLES);
        self.batches.resize_with(self.batches.len().max(batches.len()), BatchLists::default);
        for (batch, lists) in batches.iter().zip(&mut self.batches) {
            lists.write(gpu, batch)?;
            let pages: Vec<ShapePage> = std::iter::zip(on_gpu.pages(), &self.pages)
                .map(|((page, _), shapes)| ShapePage { particles: &page.particles, shapes })
                .collect();
            let work = ShapeWork {
                bounds: batch.bounds,
                targets: &lists.targets[..self.in_use],
                sources: &lists.sources[..self.in_use],
                source_particles: batch.source_particles,
            };
            passes.record(recorder, gpu, &pages, &work, params, (radius, spacing))?;
        }
        self.serial = Some(set.serial());
        Ok(())
    }
}

impl BatchLists {
    fn write(&mut self, gpu: &Gpu, batch: &ShapeBatch) -> Result<(), PipelineError> {
        for (lists, of_batch) in [(&mut self.targets, &batch.targets), (&mut self.sources, &batch.sources)] {
            while lists.len() < of_batch.len() {
                lists.push(RangeList::new(gpu)?);
            }
            lists.iter_mut().zip(of_batch).try_for_each(|(list, ranges)| list.write(gpu, ranges))?;
        }
        Ok(())
    }
}
