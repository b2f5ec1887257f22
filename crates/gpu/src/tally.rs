//! Sums that passes keep of their own work, while somebody counts.

use crate::resource::Accounted;
use crate::{Binding, Gpu, GpuError};

/// The sums of a frame, 64 bits each; WGSL: `shaders/common/tally.inc.wgsl`. One slot per name, in the order first used.
#[derive(Debug)]
pub(crate) struct Tallies {
    buffer: wgpu::Buffer,
    names: Vec<&'static str>,
    _accounted: Accounted,
}

/// Largest alignment that WebGPU lets a device ask of a storage binding.
const SLOT_BYTES: u64 = 256;
const SLOTS: usize = 16;

impl Tallies {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let size = SLOT_BYTES * SLOTS as u64;
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("tallies"),
            size,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        Self { buffer, names: Vec::new(), _accounted: Accounted::new(gpu, size) }
    }

    /// Sets all sums to zero when `encoder` runs.
    pub(crate) fn restart(&mut self, encoder: &mut wgpu::CommandEncoder) {
        self.names.clear();
        encoder.clear_buffer(&self.buffer, 0, None);
    }

    /// The sum called `name`; `None` when there are too many.
    pub(crate) fn slot(&mut self, name: &'static str) -> Option<Binding> {
        let index = self.names.iter().position(|n| *n == name).unwrap_or(self.names.len());
        if index == SLOTS {
            return None;
        }
        if index == self.names.len() {
            self.names.push(name);
        }
        let offset = index as u64 * SLOT_BYTES;
        Some(Binding::Buffer {
            buffer: self.buffer.clone(),
            offset,
            size: std::num::NonZeroU64::new(size_of::<u64>() as u64),
        })
    }

    /// The sums of the last frame; waits for the GPU.
    pub(crate) fn read(&self, gpu: &Gpu) -> Result<Vec<(&'static str, u64)>, GpuError> {
        let words: Vec<u32> = gpu.read_back("tallies", &self.buffer, SLOT_BYTES * SLOTS as u64, |bytes| {
            bytemuck::pod_collect_to_vec(bytes)
        })?;
        let slots = words.chunks(SLOT_BYTES as usize / size_of::<u32>());
        let sum = |slot: &[u32]| u64::from(slot[1]) << 32 | u64::from(slot[0]);
        Ok(self.names.iter().copied().zip(slots.map(sum)).collect())
    }
}
