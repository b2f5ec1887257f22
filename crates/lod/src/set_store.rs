use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use meniscus_gpu::role::{PackedParticle, Particles, StandIn, StandIns};
use meniscus_gpu::{Buffer, Gpu, GpuError};

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
    pub particles: Buffer<Particles>,
    /// Stand-ins of the particles.
    pub stand_in_spheres: Buffer<StandIns>,
}

impl SetPages {
    /// The pages.
    pub fn pages(&self) -> &[SetPage] {
        &self.pages[..self.in_use]
    }

    /// Replaces what is there; its buffers serve again.
    fn write(&mut self, gpu: &Gpu, set: &ChunkedSet) -> Result<(), GpuError> {
        for (index, (particles, stand_ins)) in set.pages().zip(&set.stand_ins).enumerate() {
            match self.pages.get_mut(index) {
                Some(page) => {
                    page.particles.write(gpu, particles)?;
                    page.stand_in_spheres.write(gpu, stand_ins)?;
                }
                None => self.pages.push(SetPage {
                    particles: Buffer::from_slice(gpu, particles)?,
                    stand_in_spheres: Buffer::from_slice(gpu, stand_ins)?,
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
}

/// The sets on the GPU: those that are drawn, those uploaded ahead, and those kept for the next time they are shown, within a
/// budget of bytes. What is drawn is held in any case.
///
/// Where room is short, the set shown last of those not in use goes first: played on and around, it is the one needed last. What
/// was uploaded ahead and not shown yet makes way only for what is drawn now.
#[derive(Debug, Default)]
pub struct SetStore(Mutex<Held>);

#[derive(Debug, Default)]
struct Held {
    /// In the order in which they were asked for.
    sets: Vec<HeldSet>,
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
        Self(Mutex::new(Held { sets: Vec::new(), stats }))
    }

    /// The pages of `set`, to be drawn; uploads them unless they are there. They are not given up while somebody has them.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] where a page exceeds the device's limits, [`GpuError::OutOfMemory`] where the device has no room
    /// even though all that could be given up was.
    pub fn get(&self, gpu: &Gpu, set: &ChunkedSet) -> Result<Arc<SetPages>, GpuError> {
        let mut held = self.lock();
        if let Some(found) = held.find(set, false) {
            held.stats.found += 1;
            return Ok(found);
        }
        let uploaded = held.upload(gpu, set, false)?;
        held.stats.uploads += 1;
        Ok(uploaded)
    }

    /// As [`Self::get`] for a set that will be drawn; `None` where there is no room for it beside what is in use or waits to be.
    ///
    /// # Errors
    /// As [`Self::get`].
    pub fn get_ahead(&self, gpu: &Gpu, set: &ChunkedSet) -> Result<Option<Arc<SetPages>>, GpuError> {
        let mut held = self.lock();
        if let Some(found) = held.find(set, true) {
            return Ok(Some(found));
        }
        let stays = held.sets.iter().filter(|held| held.waits || held.is_in_use());
        let stays: u64 = stays.map(|held| held.pages.bytes()).sum();
        if stays + bytes_on_gpu(set) > held.stats.limit_bytes {
            return Ok(None);
        }
        let uploaded = held.upload(gpu, set, true)?;
        held.stats.uploads_ahead += 1;
        Ok(Some(uploaded))
    }

    /// What was done so far.
    pub fn stats(&self) -> SetStoreStats {
        self.lock().stats
    }

    /// Uploads run under the lock: who asks for the same set has to wait for it anyway, and nobody asks while drawing.
    fn lock(&self) -> MutexGuard<'_, Held> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Held {
    /// The pages of `set` if they are there; whether they `wait` for being drawn is known anew.
    fn find(&mut self, set: &ChunkedSet, waits: bool) -> Option<Arc<SetPages>> {
        let place = self.sets.iter().position(|held| held.pages.serial == Some(set.serial()))?;
        let HeldSet { pages, .. } = self.sets.remove(place);
        self.sets.push(HeldSet { pages: Arc::clone(&pages), waits });
        Some(pages)
    }

    fn upload(&mut self, gpu: &Gpu, set: &ChunkedSet, waits: bool) -> Result<Arc<SetPages>, GpuError> {
        let mut pages = self.give_up_for(gpu, bytes_on_gpu(set), self.stats.limit_bytes);
        match pages.write(gpu, set) {
            Err(GpuError::OutOfMemory { .. }) => {
                // There is less than was allowed: from now on what there is has to do.
                drop(pages);
                drop(self.give_up_for(gpu, 0, 0));
                gpu.forget_bindings();
                gpu.wait()?;
                pages = SetPages::default();
                pages.write(gpu, set)?;
                self.stats.limit_bytes = self.bytes() + pages.bytes();
            }
            written => written?,
        }
        let pages = Arc::new(pages);
        self.sets.push(HeldSet { pages: Arc::clone(&pages), waits });
        self.stats.peak_bytes = self.stats.peak_bytes.max(self.bytes());
        Ok(pages)
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

    fn bytes(&self) -> u64 {
        self.sets.iter().map(|held| held.pages.bytes()).sum()
    }
}

/// What `set` takes on the GPU.
fn bytes_on_gpu(set: &ChunkedSet) -> u64 {
    let stand_ins: usize = set.stand_ins.iter().map(Vec::len).sum();
    (set.particles.len() * size_of::<PackedParticle>() + stand_ins * size_of::<StandIn>()) as u64
}
