//! Pages of particles, kept where passes read them fastest.

use crate::role::PageTexels;
use crate::{Binding, Buffer, Gpu, GpuError, Role, Texture};

/// Elements of 16 bytes that passes read one by one: WGSL `meniscus::page` in `shaders/common/page.inc.wgsl`. A storage buffer on
/// GPUs; on software drivers, which read textures several times faster, a texture that holds them row by row.
#[derive(Debug)]
pub struct Page<R: Role> {
    memory: Memory<R>,
}

#[derive(Debug)]
enum Memory<R: Role> {
    Buffer(Buffer<R>),
    Texture { texels: Texture<PageTexels>, len: usize },
}

/// Elements of a row; `shaders/common/page.inc.wgsl`.
const ROW: usize = 4096;
/// Most rows: every device has textures as high.
const MOST_ROWS: usize = 8192;
/// Rows that are handed to the driver at once, as pieces of a buffer are ([`Buffer::write`]).
const PIECE_ROWS: usize = 256;

impl<R: Role> Page<R> {
    /// Most elements of a page.
    pub fn most_elements(gpu: &Gpu) -> usize {
        let of_buffers = gpu.page_elements::<R::Element>();
        if gpu.summary().is_software() { of_buffers.min(ROW * MOST_ROWS) } else { of_buffers }
    }

    /// Bytes that `len` elements take on the device, room to grow not counted.
    pub fn bytes_for(gpu: &Gpu, len: usize) -> u64 {
        let elements = if gpu.summary().is_software() { rows_for(len) * ROW } else { len };
        (elements * size_of::<R::Element>()) as u64
    }

    /// A page that holds `elements`.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] beyond [`Self::most_elements`], [`GpuError::OutOfMemory`] where the device's memory is full.
    pub fn from_slice(gpu: &Gpu, elements: &[R::Element]) -> Result<Self, GpuError> {
        const { assert!(size_of::<R::Element>() == 16, "a page is of elements of 16 bytes") };
        if !gpu.summary().is_software() {
            return Ok(Self { memory: Memory::Buffer(Buffer::from_slice(gpu, elements)?) });
        }
        let texels = Self::texture(gpu, rows_for(elements.len()))?;
        let mut page = Self { memory: Memory::Texture { texels, len: 0 } };
        page.write(gpu, elements)?;
        Ok(page)
    }

    /// Replaces the elements; grows by half where room is short, else allocates nothing.
    ///
    /// # Errors
    /// As [`Self::from_slice`].
    pub fn write(&mut self, gpu: &Gpu, elements: &[R::Element]) -> Result<(), GpuError> {
        let (texels, len) = match &mut self.memory {
            Memory::Buffer(buffer) => return buffer.write(gpu, elements),
            Memory::Texture { texels, len } => (texels, len),
        };
        let rows = rows_for(elements.len());
        if rows > texels.size()[1] as usize {
            // Cached bind groups would keep the smaller texture alive beside the new one.
            gpu.forget_bindings();
            *texels = Self::texture(gpu, (rows * 3 / 2).min(MOST_ROWS).max(rows))?;
        }
        *len = elements.len();
        let (whole, rest) = elements.split_at(elements.len() / ROW * ROW);
        let mut row = 0;
        for piece in whole.chunks(PIECE_ROWS * ROW).chain([rest]) {
            if !piece.is_empty() {
                let width = ROW.min(piece.len()) as u32;
                texels.write_rows(gpu, R::NAME, row, width, bytemuck::cast_slice(piece));
                row += (piece.len() / ROW) as u32;
            }
            if elements.len() > PIECE_ROWS * ROW {
                gpu.begin_writes();
            }
        }
        Ok(())
    }

    fn texture(gpu: &Gpu, rows: usize) -> Result<Texture<PageTexels>, GpuError> {
        Texture::new(gpu, [ROW as u32, u32::try_from(rows).unwrap_or(u32::MAX)])
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        match &self.memory {
            Memory::Buffer(buffer) => buffer.len(),
            Memory::Texture { len, .. } => *len,
        }
    }

    /// Whether there is no element.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes that it takes on the device.
    pub fn bytes(&self) -> u64 {
        match &self.memory {
            Memory::Buffer(buffer) => buffer.bytes(),
            Memory::Texture { texels, .. } => texels.bytes(),
        }
    }

    /// For the binding `page` of a pass.
    pub fn bind(&self) -> Binding {
        match &self.memory {
            Memory::Buffer(buffer) => buffer.bind(),
            Memory::Texture { texels, .. } => texels.bind(),
        }
    }

    /// Waits for the GPU and copies the elements to the host.
    ///
    /// # Errors
    /// [`GpuError::Driver`] when the device is lost or out of memory.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<R::Element>, GpuError> {
        match &self.memory {
            Memory::Buffer(buffer) => buffer.read(gpu),
            Memory::Texture { texels, len } => {
                let texels = texels.read(gpu)?;
                Ok(bytemuck::cast_slice(&texels[..*len]).to_vec())
            }
        }
    }
}

/// Rows of a texture for `len` elements.
fn rows_for(len: usize) -> usize {
    len.div_ceil(ROW).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader;

    #[test]
    fn shaders_fold_rows_of_the_same_length() {
        let source = shader!(include "common/page").source;
        assert!(source.contains(&format!("const ROW: u32 = {ROW}u;")));
    }
}
