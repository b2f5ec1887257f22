use meniscus_gpu::role::{KeptRanges, Particles};
use meniscus_gpu::{Buffer, Gpu, GpuError};

use crate::{ChunkedSet, Selection};

/// A chunked set and what is kept of it, on the GPU. Its buffers serve frame after frame and only ever grow.
#[derive(Debug, Default)]
pub struct GpuSet {
    pages: Vec<Page>,
    /// Pages of the present set; the rest waits for a larger one.
    in_use: usize,
    serial: Option<u64>,
}

#[derive(Debug)]
struct Page {
    particles: Buffer<Particles>,
    ranges: Buffer<KeptRanges>,
}

impl GpuSet {
    /// Uploads `set` unless it is there already. Nothing of a new set is kept until [`Self::update`].
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] where a page exceeds the device's limits. The set then is empty.
    pub fn upload(&mut self, gpu: &Gpu, set: &ChunkedSet) -> Result<(), GpuError> {
        if self.serial == Some(set.serial()) {
            return Ok(());
        }
        self.serial = None;
        self.in_use = 0;
        for (index, particles) in set.pages().enumerate() {
            match self.pages.get_mut(index) {
                Some(page) => {
                    page.particles.write(gpu, particles)?;
                    page.ranges.write(gpu, &[])?;
                }
                None => self.pages.push(Page {
                    particles: Buffer::from_slice(gpu, particles)?,
                    ranges: Buffer::new(gpu, 0)?,
                }),
            }
        }
        self.in_use = set.pages().len();
        self.serial = Some(set.serial());
        Ok(())
    }

    /// Uploads the ranges that are kept of the present set.
    ///
    /// # Errors
    /// As [`Buffer::write`].
    ///
    /// # Panics
    /// If `selection` is of a set with another number of pages.
    pub fn update(&mut self, gpu: &Gpu, selection: &Selection) -> Result<(), GpuError> {
        assert_eq!(selection.ranges.len(), self.in_use, "pages of the selection and of the uploaded set");
        for (page, ranges) in self.pages.iter_mut().zip(&selection.ranges) {
            page.ranges.write(gpu, ranges)?;
        }
        Ok(())
    }

    /// The present set's pages: particles, and the ranges of them that are drawn, one workgroup each. A page without a
    /// range has nothing to draw.
    pub fn pages(&self) -> impl ExactSizeIterator<Item = (&Buffer<Particles>, &Buffer<KeptRanges>)> {
        self.pages[..self.in_use].iter().map(|page| (&page.particles, &page.ranges))
    }
}
