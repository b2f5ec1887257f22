use meniscus_gpu::role::DisplayImage;
use meniscus_gpu::{Gpu, GpuError, Image};

/// The picture as it is shown.
#[derive(Debug)]
pub struct Display {
    rows: Image<DisplayImage>,
    size: [u32; 2],
}

impl Display {
    /// A picture of `size` = `[width, height]` pixels; contents are zero.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] beyond the device's limits.
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, GpuError> {
        let [texels, height] = Self::texels(size);
        Ok(Self { rows: Image::new(gpu, [4 * texels, height])?, size })
    }

    /// `[width, height]` in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The picture with up to three pixels more in each row.
    pub(crate) fn rows(&self) -> &Image<DisplayImage> {
        &self.rows
    }

    /// Size in texels of a texture of four pixels each, for a picture of `size` pixels.
    pub(crate) fn texels(size: [u32; 2]) -> [u32; 2] {
        [size[0].div_ceil(4), size[1]]
    }

    /// Waits for the GPU and copies the pixels to the host, row by row from the top left.
    ///
    /// # Errors
    /// [`GpuError::Driver`] when the device is lost or out of memory.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<u32>, GpuError> {
        let pixels = self.rows.read(gpu)?;
        let [width, row] = [self.size, self.rows.size()].map(|size| size[0] as usize);
        if width == row {
            return Ok(pixels);
        }
        Ok(pixels.chunks(row).flat_map(|pixels| &pixels[..width]).copied().collect())
    }
}
