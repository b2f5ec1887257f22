//! Buffers, images and textures that carry their role in their type.

use std::marker::PhantomData;
use std::sync::Arc;

use half::f16;

use crate::device::GpuMemory;
use crate::{Binding, Gpu, GpuError, Role, TextureRole};

/// Counts a resource's bytes for as long as it lives.
#[derive(Debug)]
pub(crate) struct Accounted {
    bytes: u64,
    memory: Arc<GpuMemory>,
}

impl Accounted {
    pub(crate) fn new(gpu: &Gpu, bytes: u64) -> Self {
        gpu.memory.add(bytes);
        gpu.work.add(|work| {
            work.allocations += 1;
            work.bytes_allocated += bytes;
        });
        Self { bytes, memory: Arc::clone(&gpu.memory) }
    }
}

impl Drop for Accounted {
    fn drop(&mut self) {
        self.memory.remove(self.bytes);
    }
}

/// A storage buffer of role `R`: `len` elements in use, room for more.
#[derive(Debug)]
pub struct Buffer<R: Role> {
    pub(crate) raw: wgpu::Buffer,
    len: usize,
    pub(crate) capacity: usize,
    accounted: Accounted,
    role: PhantomData<R>,
}

/// From here on, writing where the GPU reads saves more than it takes to map.
const IN_PLACE_BYTES: u64 = 1 << 20;

impl<R: Role<Element = u32>> Buffer<R> {
    /// Makes its elements the vertices that `pass` draws by index.
    pub fn set_as_indices(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_index_buffer(self.raw.slice(..), wgpu::IndexFormat::Uint32);
    }
}

impl<R: Role> Buffer<R> {
    /// Room for `capacity` elements, none in use; contents are zero.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] beyond the device's limits, [`GpuError::OutOfMemory`] where its memory is full.
    pub fn new(gpu: &Gpu, capacity: usize) -> Result<Self, GpuError> {
        Self::create(gpu, capacity, gpu.writes_in_place())
    }

    fn create(gpu: &Gpu, capacity: usize, in_place: bool) -> Result<Self, GpuError> {
        let bytes = (capacity.max(1) * size_of::<R::Element>()) as u64;
        let limit = gpu.limits().max_storage_buffer_binding_size.min(gpu.limits().max_buffer_size);
        if bytes > limit {
            return Err(GpuError::TooLarge { what: R::NAME.to_owned(), bytes, limit });
        }
        let is_mappable = in_place && bytes >= IN_PLACE_BYTES;
        let map_write = if is_mappable { wgpu::BufferUsages::MAP_WRITE } else { wgpu::BufferUsages::empty() };
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let raw = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(R::NAME),
            // wgpu copies in words of 4 bytes.
            size: bytes.next_multiple_of(4),
            usage: wgpu::BufferUsages::STORAGE
                | wgpu::BufferUsages::COPY_DST
                | wgpu::BufferUsages::COPY_SRC
                | wgpu::BufferUsages::VERTEX
                | wgpu::BufferUsages::INDEX
                | map_write,
            mapped_at_creation: false,
        });
        if pollster::block_on(scope.pop()).is_some() {
            return Err(GpuError::OutOfMemory { what: R::NAME.to_owned(), bytes });
        }
        Ok(Self {
            raw,
            len: 0,
            capacity: capacity.max(1),
            accounted: Accounted::new(gpu, bytes),
            role: PhantomData,
        })
    }

    /// A buffer that holds `elements`.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn from_slice(gpu: &Gpu, elements: &[R::Element]) -> Result<Self, GpuError> {
        let mut buffer = Self::new(gpu, elements.len())?;
        buffer.write(gpu, elements)?;
        Ok(buffer)
    }

    /// Replaces the contents; grows by half where room is short, else allocates nothing.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn write(&mut self, gpu: &Gpu, elements: &[R::Element]) -> Result<(), GpuError> {
        self.reserve(gpu, elements.len())?;
        self.len = elements.len();
        let bytes: &[u8] = bytemuck::cast_slice(elements);
        // Few bytes are not worth the wait for what uses the rest.
        if self.raw.usage().contains(wgpu::BufferUsages::MAP_WRITE)
            && bytes.len() as u64 >= IN_PLACE_BYTES
            && bytes.len().is_multiple_of(4)
        {
            return gpu.write_in_place(R::NAME, &self.raw, bytes);
        }
        // Pieces of 16 MiB, each submitted: 2.5 times faster than one call on lavapipe (facts.md 2), and no second copy of
        // the whole in wgpu's staging memory.
        const PIECE: usize = 16 << 20;
        for (i, piece) in bytes.chunks(PIECE).enumerate() {
            gpu.write_buffer(R::NAME, &self.raw, (i * PIECE) as u64, piece);
            if bytes.len() > PIECE {
                gpu.submit(None);
            }
        }
        Ok(())
    }

    /// Makes room for a pass to write up to `len` elements; what the buffer holds is lost if it has to grow, by half.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn reserve(&mut self, gpu: &Gpu, len: usize) -> Result<(), GpuError> {
        if len > self.capacity {
            let limit = gpu.page_elements::<R::Element>();
            // Cached bind groups would keep the smaller buffer alive beside the new one.
            gpu.bind_cache.clear();
            *self = Self::new(gpu, (len * 3 / 2).min(limit).max(len))?;
        }
        Ok(())
    }

    /// Elements in use.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Bytes that it takes on the device.
    pub fn bytes(&self) -> u64 {
        self.accounted.bytes
    }

    /// Whether no element is in use.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// For a pass's storage binding; covers the whole buffer.
    pub fn bind(&self) -> Binding {
        Binding::whole(&self.raw)
    }

    /// For a raster pass's vertex or index slot.
    pub fn raw(&self) -> &wgpu::Buffer {
        &self.raw
    }
}

/// A picture in a storage buffer: row by row from the top left, `array<Element>` in WGSL, index `y * width + x`.
#[derive(Debug)]
pub struct Image<R: Role> {
    buffer: Buffer<R>,
    size: [u32; 2],
}

impl<R: Role> Image<R> {
    /// A picture of `size` = `[width, height]` pixels; contents are zero, which need not be `R::EMPTY`.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] beyond the device's limits.
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, GpuError> {
        // The GPU's own: no picture is written by the host.
        let mut buffer = Buffer::create(gpu, size[0] as usize * size[1] as usize, false)?;
        buffer.len = size[0] as usize * size[1] as usize;
        Ok(Self { buffer, size })
    }

    /// A picture with the given pixels.
    ///
    /// # Errors
    /// As [`Self::new`].
    ///
    /// # Panics
    /// If `pixels` is not `width * height` long.
    pub fn from_pixels(gpu: &Gpu, size: [u32; 2], pixels: &[R::Element]) -> Result<Self, GpuError> {
        assert_eq!(pixels.len(), size[0] as usize * size[1] as usize, "pixels of a {size:?} image");
        Ok(Self { buffer: Buffer::from_slice(gpu, pixels)?, size })
    }

    /// Replaces all pixels.
    ///
    /// # Errors
    /// As [`Buffer::write`].
    ///
    /// # Panics
    /// If `pixels` is not `width * height` long.
    pub fn write(&mut self, gpu: &Gpu, pixels: &[R::Element]) -> Result<(), GpuError> {
        assert_eq!(pixels.len(), self.buffer.len(), "pixels of a {:?} image", self.size);
        self.buffer.write(gpu, pixels)
    }

    /// `[width, height]` in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The pixels as a buffer.
    pub fn buffer(&self) -> &Buffer<R> {
        &self.buffer
    }

    /// For a pass's storage binding.
    pub fn bind(&self) -> Binding {
        self.buffer.bind()
    }
}

/// A texture: raster target, written by compute passes with `textureStore` and read with `textureLoad`.
#[derive(Debug)]
pub struct Texture<R: TextureRole> {
    pub(crate) raw: wgpu::Texture,
    pub(crate) view: wgpu::TextureView,
    size: [u32; 2],
    accounted: Accounted,
    role: PhantomData<R>,
}

impl<R: TextureRole<Texel = [f16; 4]>> Texture<R> {
    /// As [`Self::from_texels`], rounded to half precision; beyond its range infinite.
    ///
    /// # Errors
    /// As there.
    ///
    /// # Panics
    /// As there.
    pub fn from_floats(gpu: &Gpu, size: [u32; 2], texels: &[[f32; 4]]) -> Result<Self, GpuError> {
        let texture = Self::new(gpu, size)?;
        texture.write_floats(gpu, texels);
        Ok(texture)
    }

    /// As [`Self::write`], rounded to half precision; beyond its range infinite.
    ///
    /// # Panics
    /// As there.
    pub fn write_floats(&self, gpu: &Gpu, texels: &[[f32; 4]]) {
        let halves: Vec<[f16; 4]> = texels.iter().map(|texel| texel.map(f16::from_f32)).collect();
        self.write(gpu, &halves);
    }
}

impl<R: TextureRole> Texture<R> {
    /// A texture of `size` = `[width, height]` texels.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] beyond the device's limits, [`GpuError::OutOfMemory`] where its memory is full.
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, GpuError> {
        let limit = gpu.limits().max_texture_dimension_2d;
        if size.iter().any(|&s| s > limit || s == 0) {
            let what = format!("{} {}x{}, larger side at most {limit};", R::NAME, size[0], size[1]);
            return Err(GpuError::TooLarge {
                what,
                bytes: u64::from(size[0]) * u64::from(size[1]),
                limit: limit.into(),
            });
        }
        let written = if R::FORMAT.is_depth_stencil_format() {
            wgpu::TextureUsages::empty()
        } else {
            wgpu::TextureUsages::STORAGE_BINDING
        };
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let raw = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(R::NAME),
            size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: R::FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC
                | wgpu::TextureUsages::COPY_DST
                | written,
            view_formats: &[],
        });
        let texel = u64::from(R::FORMAT.block_copy_size(None).unwrap_or(4));
        let bytes = u64::from(size[0]) * u64::from(size[1]) * texel;
        if pollster::block_on(scope.pop()).is_some() {
            return Err(GpuError::OutOfMemory { what: R::NAME.to_owned(), bytes });
        }
        let view = raw.create_view(&Default::default());
        Ok(Self { raw, view, size, accounted: Accounted::new(gpu, bytes), role: PhantomData })
    }

    /// A texture with the given texels, row by row.
    ///
    /// # Errors
    /// As [`Self::new`].
    ///
    /// # Panics
    /// If `texels` is not `width * height` long.
    pub fn from_texels(gpu: &Gpu, size: [u32; 2], texels: &[R::Texel]) -> Result<Self, GpuError> {
        let texture = Self::new(gpu, size)?;
        texture.write(gpu, texels);
        Ok(texture)
    }

    /// Replaces all texels, row by row.
    ///
    /// # Panics
    /// If `texels` is not `width * height` long.
    pub fn write(&self, gpu: &Gpu, texels: &[R::Texel]) {
        let count = self.size[0] as usize * self.size[1] as usize;
        assert_eq!(texels.len(), count, "texels of a {:?} {}", self.size, R::NAME);
        self.write_rows(gpu, R::NAME, 0, self.size[0], texels);
    }

    /// Replaces the first `width` texels of rows from `first` on with `texels`, which counts as upload of `what`.
    pub(crate) fn write_rows(
        &self,
        gpu: &Gpu,
        what: &'static str,
        first: u32,
        width: u32,
        texels: &[R::Texel],
    ) {
        let bytes: &[u8] = bytemuck::cast_slice(texels);
        gpu.work.add(|work| *work.uploaded.entry(what).or_default() += bytes.len() as u64);
        let mut target = self.raw.as_image_copy();
        target.origin.y = first;
        let bytes_per_row = Some(width * size_of::<R::Texel>() as u32);
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
        let height = texels.len() as u32 / width;
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        gpu.queue.write_texture(target, bytes, layout, size);
    }

    /// Bytes that it takes on the device.
    pub fn bytes(&self) -> u64 {
        self.accounted.bytes
    }

    /// `[width, height]` in texels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// For a pass's texture binding, to be read or to be written.
    pub fn bind(&self) -> Binding {
        Binding::Texture(self.view.clone())
    }

    /// As a raster target.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.view
    }
}
