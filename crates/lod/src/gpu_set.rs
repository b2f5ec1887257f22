use meniscus_gpu::role::{Occludees, PackedParticle, Particles, StandIn, StandIns};
use meniscus_gpu::{Buffer, Gpu, GpuError, RangeList};

use crate::{ChunkedSet, PageSelection, Selection};

/// A chunked set and what is drawn of it, on the GPU. Its buffers serve frame after frame and only ever grow.
#[derive(Debug, Default)]
pub struct GpuSet {
    pages: Vec<GpuPage>,
    /// Pages of the present set; the rest waits for a larger one.
    in_use: usize,
    serial: Option<u64>,
}

/// A page of a set: its particles and stand-ins, and what of them is drawn ([`PageSelection`]).
#[derive(Debug)]
pub struct GpuPage {
    /// The particles.
    pub particles: Buffer<Particles>,
    /// Stand-ins of the particles.
    pub stand_in_spheres: Buffer<StandIns>,
    /// What the surface is drawn from first.
    pub front: RangeList,
    /// What is drawn after that where it is not hidden.
    pub occludees: Buffer<Occludees>,
    /// Room for those of them that are not.
    pub visible: RangeList,
    /// Particles that count in the thickness.
    pub mass: RangeList,
    /// Stand-ins that count in the thickness.
    pub stand_ins: RangeList,
}

impl GpuPage {
    fn new(gpu: &Gpu, particles: &[PackedParticle], stand_ins: &[StandIn]) -> Result<Self, GpuError> {
        Ok(Self {
            particles: Buffer::from_slice(gpu, particles)?,
            stand_in_spheres: Buffer::from_slice(gpu, stand_ins)?,
            front: RangeList::new(gpu)?,
            occludees: Buffer::new(gpu, 0)?,
            visible: RangeList::new(gpu)?,
            mass: RangeList::new(gpu)?,
            stand_ins: RangeList::new(gpu)?,
        })
    }

    fn select(&mut self, gpu: &Gpu, selection: &PageSelection) -> Result<(), GpuError> {
        self.front.write(gpu, &selection.front)?;
        self.occludees.write(gpu, &selection.occludees)?;
        self.visible.reserve(gpu, selection.occludees.len())?;
        self.mass.write(gpu, &selection.mass)?;
        self.stand_ins.write(gpu, &selection.stand_ins)
    }
}

impl GpuSet {
    /// Uploads `set` unless it is there already. Nothing of a new set is drawn until [`Self::update`].
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] where a page exceeds the device's limits. The set then is empty.
    pub fn upload(&mut self, gpu: &Gpu, set: &ChunkedSet) -> Result<(), GpuError> {
        if self.serial == Some(set.serial()) {
            return Ok(());
        }
        self.serial = None;
        self.in_use = 0;
        for (index, (particles, stand_ins)) in set.pages().zip(&set.stand_ins).enumerate() {
            match self.pages.get_mut(index) {
                Some(page) => {
                    page.particles.write(gpu, particles)?;
                    page.stand_in_spheres.write(gpu, stand_ins)?;
                    page.select(gpu, &PageSelection::default())?;
                }
                None => self.pages.push(GpuPage::new(gpu, particles, stand_ins)?),
            }
        }
        self.in_use = set.pages().len();
        self.serial = Some(set.serial());
        Ok(())
    }

    /// Uploads what is drawn of the present set.
    ///
    /// # Errors
    /// As [`Buffer::write`].
    ///
    /// # Panics
    /// If `selection` is of a set with another number of pages.
    pub fn update(&mut self, gpu: &Gpu, selection: &Selection) -> Result<(), GpuError> {
        assert_eq!(selection.pages.len(), self.in_use, "pages of the selection and of the uploaded set");
        self.pages.iter_mut().zip(&selection.pages).try_for_each(|(page, of_page)| page.select(gpu, of_page))
    }

    /// The present set's pages.
    pub fn pages(&self) -> &[GpuPage] {
        &self.pages[..self.in_use]
    }
}
