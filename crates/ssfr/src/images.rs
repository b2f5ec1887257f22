use meniscus_gpu::role::{EffectiveRadius, EyeDistance, Scratch, Thickness, ViewNormal};
use meniscus_gpu::{Buffer, Gpu, GpuError, Image};

use crate::SsfrParams;
use crate::passes::tile_count;

/// What the surface stage makes, and the room it needs to make it. Made once per picture size.
#[derive(Debug)]
pub struct SurfaceImages {
    /// Distance of the smoothed surface.
    pub distance: Image<EyeDistance>,
    /// Drawn radius of the particle that is visible in a pixel.
    pub radius: Image<EffectiveRadius>,
    /// Length of fluid along the ray through a pixel, up to the opaque scene.
    pub thickness: Image<Thickness>,
    /// Normal of the smoothed surface.
    pub normal: Image<ViewNormal>,
    /// Distance of the nearest sphere, before smoothing.
    pub unfiltered: Image<EyeDistance>,
    /// Bits of the nearest distance while splats are drawn, then room for the filter.
    pub(crate) nearest: Image<Scratch>,
    pub(crate) scratch: Image<Scratch>,
    /// Farthest distance per tile; `shaders/ssfr/farthest.wgsl`.
    pub(crate) farthest: Buffer<Scratch>,
    /// The pixels that show fluid; `shaders/common/covered.inc.wgsl`.
    pub covered: Buffer<Scratch>,
    pub(crate) reduced: ReducedImages,
}

/// The thickness while it is summed and smoothed, at reduced size.
#[derive(Debug)]
pub(crate) struct ReducedImages {
    pub(crate) scale: u32,
    pub(crate) size: [u32; 2],
    pub(crate) limit: Image<Scratch>,
    pub(crate) nearest: Image<Scratch>,
    pub(crate) covered: Image<Scratch>,
    pub(crate) sigma: Image<Scratch>,
    pub(crate) sum: Image<Scratch>,
    /// Two numbers per pixel: thickness and coverage, smoothed along rows, then in both directions.
    pub(crate) rows: Image<Scratch>,
    pub(crate) smoothed: Image<Scratch>,
}

impl SurfaceImages {
    /// Images for pictures of `size` = `[width, height]` pixels.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] beyond the device's limits.
    pub fn new(gpu: &Gpu, size: [u32; 2], params: &SsfrParams) -> Result<Self, GpuError> {
        Ok(Self {
            distance: Image::new(gpu, size)?,
            radius: Image::new(gpu, size)?,
            thickness: Image::new(gpu, size)?,
            normal: Image::new(gpu, size)?,
            unfiltered: Image::new(gpu, size)?,
            nearest: Image::new(gpu, size)?,
            scratch: Image::new(gpu, size)?,
            farthest: Buffer::new(gpu, tile_count(size))?,
            covered: Buffer::new(gpu, 1 + size[0] as usize * size[1] as usize)?,
            reduced: ReducedImages::new(gpu, size, params.thickness.scale)?,
        })
    }

    /// `[width, height]` in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.distance.size()
    }

    /// Pixels that showed fluid in the last frame; waits for the GPU.
    ///
    /// # Errors
    /// The GPU's.
    pub fn covered_pixels(&self, gpu: &Gpu) -> Result<u32, GpuError> {
        // The list starts with its length (`shaders/common/covered.inc.wgsl`).
        Ok(self.covered.read_first(gpu, 1)?.first().copied().unwrap_or(0))
    }

    /// Whether these images serve pictures of `size` pixels made with `params`; if not, make new ones.
    pub fn fit(&self, size: [u32; 2], params: &SsfrParams) -> bool {
        self.size() == size && self.reduced.scale == params.thickness.scale
    }
}

impl ReducedImages {
    fn new(gpu: &Gpu, full: [u32; 2], scale: u32) -> Result<Self, GpuError> {
        let size = full.map(|side| side.div_ceil(scale));
        let pairs = [2 * size[0], size[1]];
        Ok(Self {
            scale,
            size,
            limit: Image::new(gpu, size)?,
            nearest: Image::new(gpu, size)?,
            covered: Image::new(gpu, size)?,
            sigma: Image::new(gpu, size)?,
            sum: Image::new(gpu, size)?,
            rows: Image::new(gpu, pairs)?,
            smoothed: Image::new(gpu, pairs)?,
        })
    }
}
