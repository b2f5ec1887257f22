use std::sync::{Mutex, PoisonError};

use crate::resource::Accounted;
use crate::{Buffer, Gpu, GpuError, Image, Role};

/// The buffer that results are read back through, kept and only ever made larger: reading a picture of every frame
/// allocates once.
#[derive(Debug, Default)]
pub(crate) struct Readback(Mutex<Option<(wgpu::Buffer, Accounted)>>);

impl Gpu {
    /// Waits for the GPU and hands the first `bytes` bytes of `source`, a multiple of 4, to `take`.
    pub(crate) fn read_back<T>(
        &self,
        what: &str,
        source: &wgpu::Buffer,
        bytes: u64,
        take: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, GpuError> {
        let mut kept = self.readback.0.lock().unwrap_or_else(PoisonError::into_inner);
        // Taken out, so that a buffer whose mapping failed is not used again.
        let (staging, accounted) = match kept.take().filter(|(staging, _)| staging.size() >= bytes) {
            Some(staging) => staging,
            None => {
                let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("readback"),
                    size: bytes,
                    usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                });
                (staging, Accounted::new(self, bytes))
            }
        };
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(source, 0, &staging, 0, bytes);
        self.submit(Some(encoder.finish()));
        let (sender, receiver) = std::sync::mpsc::channel();
        staging.map_async(wgpu::MapMode::Read, ..bytes, move |result| {
            let _ = sender.send(result);
        });
        self.wait()?;
        let mapped = receiver.recv().map_err(|e| GpuError::Driver(e.to_string()))?;
        mapped.map_err(|e| GpuError::Driver(format!("reading {what} back: {e}")))?;
        let view = staging.get_mapped_range(..bytes).map_err(|e| GpuError::Driver(e.to_string()))?;
        let taken = take(&view);
        drop(view);
        staging.unmap();
        *kept = Some((staging, accounted));
        Ok(taken)
    }
}

impl<R: Role> Buffer<R> {
    /// Waits for the GPU and copies the elements in use to the host.
    ///
    /// # Errors
    /// [`GpuError::Driver`] when the device is lost or out of memory.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<R::Element>, GpuError> {
        self.read_first(gpu, self.len())
    }

    /// As [`Self::read`] for the first `count` elements that there is room for, in use or written by a pass.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_first(&self, gpu: &Gpu, count: usize) -> Result<Vec<R::Element>, GpuError> {
        let bytes = (self.capacity.min(count) * size_of::<R::Element>()) as u64;
        if bytes == 0 {
            return Ok(Vec::new());
        }
        gpu.read_back(R::NAME, &self.raw, bytes.next_multiple_of(4), |read| {
            bytemuck::pod_collect_to_vec(&read[..bytes as usize])
        })
    }
}

impl<R: Role> Image<R> {
    /// Waits for the GPU and copies the pixels to the host, row by row from the top left.
    ///
    /// # Errors
    /// [`GpuError::Driver`] when the device is lost or out of memory.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<R::Element>, GpuError> {
        self.buffer().read(gpu)
    }
}
