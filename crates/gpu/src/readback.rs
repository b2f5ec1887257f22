use std::sync::{Mutex, PoisonError};

use half::f16;

use crate::resource::Accounted;
use crate::{Buffer, Gpu, GpuError, Image, Role, Texture, TextureRole};

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
        let copy = |encoder: &mut wgpu::CommandEncoder, staging: &wgpu::Buffer| {
            encoder.copy_buffer_to_buffer(source, 0, staging, 0, bytes);
        };
        self.read_copied(what, bytes, copy, take)
    }

    /// Waits for the GPU and hands `bytes` bytes, a multiple of 4, that `copy` copies to the buffer it is given, to `take`.
    fn read_copied<T>(
        &self,
        what: &str,
        bytes: u64,
        copy: impl FnOnce(&mut wgpu::CommandEncoder, &wgpu::Buffer),
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
        copy(&mut encoder, &staging);
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

impl<R: TextureRole<Texel = [f16; 4]>> Texture<R> {
    /// As [`Self::read`], in single precision.
    ///
    /// # Errors
    /// As there.
    pub fn read_floats(&self, gpu: &Gpu) -> Result<Vec<[f32; 4]>, GpuError> {
        Ok(self.read(gpu)?.into_iter().map(|texel| texel.map(f16::to_f32)).collect())
    }
}

impl<R: TextureRole> Texture<R> {
    /// Waits for the GPU and copies the texels to the host, row by row from the top left.
    ///
    /// # Errors
    /// [`GpuError::Driver`] when the device is lost or out of memory.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<R::Texel>, GpuError> {
        let [width, height] = self.size();
        let row = width * size_of::<R::Texel>() as u32;
        let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded), rows_per_image: None };
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        gpu.read_copied(
            R::NAME,
            u64::from(padded) * u64::from(height),
            |encoder, buffer| {
                let target = wgpu::TexelCopyBufferInfo { buffer, layout };
                encoder.copy_texture_to_buffer(self.raw.as_image_copy(), target, size);
            },
            |read| {
                read.chunks_exact(padded as usize)
                    .flat_map(|texels| bytemuck::pod_collect_to_vec(&texels[..row as usize]))
                    .collect()
            },
        )
    }
}
