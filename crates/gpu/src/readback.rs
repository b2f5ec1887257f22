use crate::{Buffer, Gpu, GpuError, Image, Role};

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
        let staging = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("readback"),
            size: bytes.next_multiple_of(4),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(&self.raw, 0, &staging, 0, bytes.next_multiple_of(4));
        gpu.queue.submit([encoder.finish()]);
        let (sender, receiver) = std::sync::mpsc::channel();
        staging.map_async(wgpu::MapMode::Read, .., move |result| {
            let _ = sender.send(result);
        });
        gpu.wait()?;
        let mapped = receiver.recv().map_err(|e| GpuError::Driver(e.to_string()))?;
        mapped.map_err(|e| GpuError::Driver(format!("reading {} back: {e}", R::NAME)))?;
        let view = staging.get_mapped_range(..).map_err(|e| GpuError::Driver(e.to_string()))?;
        Ok(bytemuck::pod_collect_to_vec(&view[..bytes as usize]))
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
