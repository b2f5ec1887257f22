use std::sync::Arc;

use meniscus_gpu::role::Occludees;
use meniscus_gpu::{Buffer, Gpu, GpuError, RangeList};

use crate::set_store::{SetPage, SetPages, SetStore};
use crate::{ChunkedSet, PageSelection, Selection};

/// A chunked set on the GPU and what is drawn of it. The lists serve frame after frame and only ever grow.
#[derive(Debug, Default)]
pub struct GpuSet {
    set: Option<(u64, Arc<SetPages>)>,
    /// One per page of the largest set so far.
    lists: Vec<PageLists>,
}

/// What is drawn of a page ([`PageSelection`]).
#[derive(Debug)]
pub struct PageLists {
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

impl PageLists {
    fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
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
    /// Takes `set` from `store`, which uploads it where it is not there, unless it is the present one. Nothing of a new set is
    /// drawn until [`Self::update`].
    ///
    /// # Errors
    /// As [`SetStore::get`]. The set then is empty.
    pub fn upload(&mut self, gpu: &Gpu, store: &SetStore, set: &ChunkedSet) -> Result<(), GpuError> {
        if self.set.as_ref().is_some_and(|(serial, _)| *serial == set.serial()) {
            return Ok(());
        }
        // The old one first, so that its buffers can serve the new one.
        self.set = None;
        let pages = store.get(gpu, set)?;
        self.take(gpu, set.serial(), pages)
    }

    /// Takes the set that `other` has, of which something else may be drawn from here. Nothing is until [`Self::update`].
    ///
    /// # Errors
    /// As [`Buffer::write`].
    pub fn share(&mut self, gpu: &Gpu, other: &Self) -> Result<(), GpuError> {
        self.set = None;
        match &other.set {
            Some((serial, pages)) => self.take(gpu, *serial, Arc::clone(pages)),
            None => Ok(()),
        }
    }

    /// Lets go of the set; the lists wait for another one.
    pub fn release(&mut self) {
        self.set = None;
    }

    fn take(&mut self, gpu: &Gpu, serial: u64, pages: Arc<SetPages>) -> Result<(), GpuError> {
        self.lists.iter_mut().try_for_each(|lists| lists.select(gpu, &PageSelection::default()))?;
        while self.lists.len() < pages.pages().len() {
            self.lists.push(PageLists::new(gpu)?);
        }
        self.set = Some((serial, pages));
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
        assert_eq!(
            selection.pages.len(),
            self.pages().len(),
            "pages of the selection and of the uploaded set"
        );
        self.lists
            .iter_mut()
            .zip(&selection.pages)
            .try_for_each(|(lists, of_page)| lists.select(gpu, of_page))
    }

    /// The present set's pages, each with what is drawn of it.
    pub fn pages(&self) -> impl ExactSizeIterator<Item = (&SetPage, &PageLists)> {
        let pages = self.set.as_ref().map_or(&[][..], |(_, pages)| pages.pages());
        pages.iter().zip(&self.lists)
    }
}
