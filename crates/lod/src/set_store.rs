use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use meniscus_gpu::role::{Particles, StandIns};
use meniscus_gpu::{Gpu, GpuError, Page};

use crate::ChunkedSet;

/// The particles of a set and its stand-ins on the GPU, page by page; the same for every camera.
#[derive(Debug, Default)]
pub struct SetPages {
    serial: Option<u64>,
    pages: Vec<SetPage>,
    /// Pages of the present set; the rest waits for a larger one.
    in_use: usize,
}

/// A page of a set.
#[derive(Debug)]
pub struct SetPage {
    /// The particles.
    pub particles: Page<Particles>,
    /// Stand-ins of the particles.
    pub stand_in_spheres: Page<StandIns>,
}

impl SetPages {
    /// The pages.
    pub fn pages(&self) -> &[SetPage] {
        &self.pages[..self.in_use]
    }

    /// Replaces what is there; its memory serves again.
    fn write(&mut self, gpu: &Gpu, set: &ChunkedSet) -> Result<(), GpuError> {
        for (index, (particles, stand_ins)) in set.pages().zip(&set.stand_ins).enumerate() {
            match self.pages.get_mut(index) {
                Some(page) => {
                    page.particles.write(gpu, particles)?;
                    page.stand_in_spheres.write(gpu, stand_ins)?;
                }
                None => self.pages.push(SetPage {
                    particles: Page::from_slice(gpu, particles)?,
                    stand_in_spheres: Page::from_slice(gpu, stand_ins)?,
                }),
            }
        }
        self.in_use = set.pages().len();
        self.serial = Some(set.serial());
        Ok(())
    }

    /// Bytes on the GPU, pages that wait included.
    fn bytes(&self) -> u64 {
        self.pages.iter().map(|page| page.particles.bytes() + page.stand_in_spheres.bytes()).sum()
    }
}

/// What a [`SetStore`] did and holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SetStoreStats {
    /// Sets uploaded when they were to be drawn.
    pub uploads: u64,
    /// Sets uploaded before.
    pub uploads_ahead: u64,
    /// Sets that were there when they were to be drawn, whether uploaded ahead or kept since they were last shown.
    pub found: u64,
    /// Bytes that may be held.
    pub limit_bytes: u64,
    /// The most bytes held so far.
    pub peak_bytes: u64,
    /// Bytes of sets that are being uploaded.
    pub uploading_bytes: u64,
}

/// The sets on the GPU: those that are drawn, those uploaded ahead, and those kept for the next time they are shown, within a
/// budget of bytes. What is drawn is held in any case.
///
/// Where room is short, the set shown last of those not in use goes first: played on and around, it is the one needed last. What
/// was uploaded ahead and not shown yet makes way only for what is drawn now.
///
/// Uploads run beside each other and beside whoever asks for sets that are there: the next frame's does not hold up the one that is
/// drawn.
#[derive(Debug, Default)]
pub struct SetStore {
    held: Mutex<Held>,
    /// Told when an upload has ended.
    uploaded: Condvar,
}

#[derive(Debug, Default)]
struct Held {
    /// In the order in which they were asked for.
    sets: Vec<HeldSet>,
    /// Serials of sets that are being uploaded.
    uploading: Vec<u64>,
    stats: SetStoreStats,
}

#[derive(Debug)]
struct HeldSet {
    pages: Arc<SetPages>,
    /// Whether it was uploaded ahead and not drawn since.
    waits: bool,
}

impl HeldSet {
    /// Whether somebody besides the store has it.
    fn is_in_use(&self) -> bool {
        Arc::strong_count(&self.pages) > 1
    }
}

impl SetStore {
    /// A store that may hold `limit_bytes`; 0 keeps nothing that is not drawn.
    pub fn new(limit_bytes: u64) -> Self {
        let stats = SetStoreStats { limit_bytes, ..Default::default() };
        Self { held: Mutex::new(Held { stats, ..Default::default() }), ..Default::default() }
    }

    /// The pages of `set`, to be drawn; uploads them unless they are there. They are not given up while somebody has them.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] where a page exceeds the device's limits, [`GpuError::OutOfMemory`] where the device has no room
    /// even though all that could be given up was.
    pub fn get(&self, gpu: &Gpu, set: &ChunkedSet) -> Result<Arc<SetPages>, GpuError> {
        let mut held = self.lock_without(set);
        if let Some(found) = held.find(set, false) {
            held.stats.found += 1;
            return Ok(found);
        }
        self.upload(gpu, set, held, false)
    }

    /// As [`Self::get`] for a set that will be drawn; `None` where there is no room for it beside what is in use or waits to be.
    ///
    /// # Errors
    /// As [`Self::get`].
    pub fn get_ahead(&self, gpu: &Gpu, set: &ChunkedSet) -> Result<Option<Arc<SetPages>>, GpuError> {
        let mut held = self.lock_without(set);
        if let Some(found) = held.find(set, true) {
            return Ok(Some(found));
        }
        let stays = held.sets.iter().filter(|held| held.waits || held.is_in_use());
        let stays = stays.map(|held| held.pages.bytes()).sum::<u64>() + held.stats.uploading_bytes;
        if stays + bytes_on_gpu(gpu, set) > held.stats.limit_bytes {
            return Ok(None);
        }
        self.upload(gpu, set, held, true).map(Some)
    }

    /// What was done so far.
    pub fn stats(&self) -> SetStoreStats {
        self.lock().stats
    }

    fn lock(&self) -> MutexGuard<'_, Held> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The same while `set` is not being uploaded; waits until that is so.
    fn lock_without(&self, set: &ChunkedSet) -> MutexGuard<'_, Held> {
        let is_uploading = |held: &mut Held| held.uploading.contains(&set.serial());
        self.uploaded.wait_while(self.lock(), is_uploading).unwrap_or_else(PoisonError::into_inner)
    }

    /// Uploads `set`, which is not there; `waits`: ahead of being drawn.
    fn upload(
        &self,
        gpu: &Gpu,
        set: &ChunkedSet,
        mut held: MutexGuard<'_, Held>,
        waits: bool,
    ) -> Result<Arc<SetPages>, GpuError> {
        let bytes = bytes_on_gpu(gpu, set);
        let limit = held.stats.limit_bytes;
        let mut pages = held.give_up_for(gpu, bytes, limit);
        held.uploading.push(set.serial());
        held.stats.uploading_bytes += bytes;
        let mut under_way = UnderWay { store: self, serial: set.serial(), bytes };
        drop(held);
        let mut written = pages.write(gpu, set);
        let mut held = self.lock();
        held.stats.uploading_bytes -= std::mem::take(&mut under_way.bytes);
        if let Err(GpuError::OutOfMemory { .. }) = written {
            // There is less than was allowed: from now on what there is has to do.
            drop(pages);
            drop(held.give_up_for(gpu, 0, 0));
            gpu.forget_bindings();
            gpu.wait()?;
            pages = SetPages::default();
            written = pages.write(gpu, set);
            held.stats.limit_bytes = held.bytes() + pages.bytes();
        }
        written?;
        Ok(held.keep(pages, waits))
    }
}

/// An upload that has begun. Ends with it, whatever becomes of it: nobody waits for what will never come.
struct UnderWay<'a> {
    store: &'a SetStore,
    serial: u64,
    /// Not yet taken off those that are being uploaded.
    bytes: u64,
}

impl Drop for UnderWay<'_> {
    fn drop(&mut self) {
        let mut held = self.store.lock();
        held.uploading.retain(|serial| *serial != self.serial);
        held.stats.uploading_bytes -= self.bytes;
        self.store.uploaded.notify_all();
    }
}

impl Held {
    /// The pages of `set` if they are there; from now on they wait to be drawn (`ahead`), or are drawn now.
    fn find(&mut self, set: &ChunkedSet, ahead: bool) -> Option<Arc<SetPages>> {
        let place = self.sets.iter().position(|held| held.pages.serial == Some(set.serial()))?;
        let held = self.sets.remove(place);
        // What is drawn already when it is asked for ahead need not wait: that was asked too late.
        let waits = ahead && (held.waits || !held.is_in_use());
        let pages = Arc::clone(&held.pages);
        self.sets.push(HeldSet { pages: held.pages, waits });
        Some(pages)
    }

    /// Holds what was uploaded, which `waits` to be drawn or is drawn now.
    fn keep(&mut self, pages: SetPages, waits: bool) -> Arc<SetPages> {
        let pages = Arc::new(pages);
        self.sets.push(HeldSet { pages: Arc::clone(&pages), waits });
        self.stats.peak_bytes = self.stats.peak_bytes.max(self.bytes());
        *if waits { &mut self.stats.uploads_ahead } else { &mut self.stats.uploads } += 1;
        pages
    }

    /// Gives up what is not in use until `bytes` more are within `limit`; hands over the last of it, to be written anew.
    fn give_up_for(&mut self, gpu: &Gpu, bytes: u64, limit: u64) -> SetPages {
        let mut last: Option<SetPages> = None;
        while self.bytes() + bytes > limit
            && let Some(place) = self.least_useful()
        {
            // Nobody can have taken it meanwhile: that needs the lock.
            let pages = Arc::into_inner(self.sets.remove(place).pages);
            if last.is_some() {
                // Cached bindings would keep it alive.
                gpu.forget_bindings();
            }
            last = pages;
        }
        last.unwrap_or_default()
    }

    /// The place of what goes first.
    fn least_useful(&self) -> Option<usize> {
        let shown = self.sets.iter().rposition(|held| !held.waits && !held.is_in_use());
        shown.or_else(|| self.sets.iter().rposition(|held| !held.is_in_use()))
    }

    /// Bytes held or being uploaded.
    fn bytes(&self) -> u64 {
        self.sets.iter().map(|held| held.pages.bytes()).sum::<u64>() + self.stats.uploading_bytes
    }
}

/// What `set` takes on the GPU.
fn bytes_on_gpu(gpu: &Gpu, set: &ChunkedSet) -> u64 {
    let particles = set.pages().map(|particles| Page::<Particles>::bytes_for(gpu, particles.len()));
    let stand_ins = set.stand_ins.iter().map(|of_page| Page::<StandIns>::bytes_for(gpu, of_page.len()));
    particles.chain(stand_ins).sum()
}
