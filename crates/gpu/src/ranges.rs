use crate::role::{KeptRange, KeptRanges};
use crate::{Binding, Buffer, Gpu, GpuError};

/// A list of runs whose length a pass can read, and write: in WGSL `array<KeptRange>`, of which the first element's `first`
/// is the number of runs that follow.
#[derive(Debug)]
pub struct RangeList {
    buffer: Buffer<KeptRanges>,
    len: usize,
    /// Header and runs on their way to the GPU; kept, so that the steady state allocates nothing.
    staged: Vec<KeptRange>,
}

fn header(len: usize) -> KeptRange {
    KeptRange { first: len as u32, count: 0, keep: 0, shape: 0 }
}

impl RangeList {
    /// An empty list.
    ///
    /// # Errors
    /// As [`Buffer::new`].
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Self::from_slice(gpu, &[])
    }

    /// A list of `ranges`.
    ///
    /// # Errors
    /// As [`Buffer::new`].
    pub fn from_slice(gpu: &Gpu, ranges: &[KeptRange]) -> Result<Self, GpuError> {
        let mut list = Self { buffer: Buffer::new(gpu, 1 + ranges.len())?, len: 0, staged: Vec::new() };
        list.write(gpu, ranges)?;
        Ok(list)
    }

    /// Replaces the list.
    ///
    /// # Errors
    /// As [`Buffer::write`].
    pub fn write(&mut self, gpu: &Gpu, ranges: &[KeptRange]) -> Result<(), GpuError> {
        self.staged.clear();
        self.staged.push(header(ranges.len()));
        self.staged.extend(ranges);
        self.buffer.write(gpu, &self.staged)?;
        self.len = ranges.len();
        Ok(())
    }

    /// Makes room for a pass to write up to `len` runs; what the list holds is lost if it has to grow.
    ///
    /// # Errors
    /// As [`Buffer::new`].
    pub fn reserve(&mut self, gpu: &Gpu, len: usize) -> Result<(), GpuError> {
        if self.buffer.capacity <= len {
            // Cached bind groups would keep the smaller buffer alive beside the new one.
            gpu.bind_cache.clear();
            self.buffer = Buffer::new(gpu, 1 + len + len / 2)?;
        }
        Ok(())
    }

    /// The runs that the host has written.
    pub fn ranges(&self) -> &[KeptRange] {
        self.staged.get(1..).unwrap_or_default()
    }

    /// Runs that the host has written.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether the host has written none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// For a pass's storage binding.
    pub fn bind(&self) -> Binding {
        self.buffer.bind()
    }

    /// Header and runs, to be cleared by a pass: the first element empties the list.
    pub fn buffer(&self) -> &Buffer<KeptRanges> {
        &self.buffer
    }

    /// Waits for the GPU and copies the list to the host, also one that a pass has written.
    ///
    /// # Errors
    /// The GPU's.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<KeptRange>, GpuError> {
        let header = self.buffer.read_first(gpu, 1)?;
        let len = header.first().map_or(0, |header| header.first as usize);
        Ok(self.buffer.read_first(gpu, 1 + len)?.split_off(1))
    }
}
