use meniscus_gpu::role::{
    EyeDistance, FarthestDistance, FilterStep, FrontSphere, ReducedSurface, ReducedThickness, Scratch,
    SmoothedThickness, Thickness, ViewNormal,
};
use meniscus_gpu::{Buffer, Covered, Gpu, GpuError, Image, Texture};

use crate::SsfrParams;
use crate::filter::scratch_len;
use crate::passes::{STRIP_WORDS, tiles};

/// What the surface stage makes, and the room it needs to make it. Made once per picture size.
#[derive(Debug)]
pub struct SurfaceImages {
    /// Distance of the smoothed surface.
    pub distance: Texture<EyeDistance>,
    /// Length of fluid along the ray through a pixel, up to the opaque scene.
    pub thickness: Texture<Thickness>,
    /// Normal of the smoothed surface.
    pub normal: Texture<ViewNormal>,
    /// Distance and drawn radius of the nearest sphere, before smoothing.
    pub front: Texture<FrontSphere>,
    /// Bits of the nearest distance and of its sphere's radius while splats are drawn, then room for the filter.
    pub(crate) nearest: Buffer<Scratch>,
    pub(crate) radius: Buffer<Scratch>,
    /// Large splats, cut into strips; `shaders/ssfr/strips.inc.wgsl`.
    pub(crate) strips: Buffer<Scratch>,
    pub(crate) steps: [Texture<FilterStep>; 2],
    /// Farthest distance per tile, and per tile of those; `shaders/ssfr/farthest.wgsl`.
    pub(crate) farthest: [Texture<FarthestDistance>; 2],
    /// The pixels that show fluid.
    pub covered: Covered,
    pub(crate) reduced: ReducedImages,
}

/// The thickness while it is summed and smoothed, at reduced size.
#[derive(Debug)]
pub(crate) struct ReducedImages {
    pub(crate) scale: u32,
    pub(crate) size: [u32; 2],
    pub(crate) surface: Texture<ReducedSurface>,
    pub(crate) limit: Image<Scratch>,
    pub(crate) sum: Buffer<Scratch>,
    /// From the sums.
    pub(crate) resolved: Texture<ReducedThickness>,
    /// Smoothed along rows, and then along columns.
    pub(crate) smoothed: [Texture<SmoothedThickness>; 2],
}

impl SurfaceImages {
    /// Images for pictures of `size` = `[width, height]` pixels.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] beyond the device's limits.
    pub fn new(gpu: &Gpu, size: [u32; 2], params: &SsfrParams) -> Result<Self, GpuError> {
        let [tiles, large_tiles] = tiles(size);
        Ok(Self {
            distance: Texture::new(gpu, size)?,
            thickness: Texture::new(gpu, size)?,
            normal: Texture::new(gpu, size)?,
            front: Texture::new(gpu, size)?,
            nearest: Buffer::new(gpu, scratch_len(size))?,
            radius: Buffer::new(gpu, scratch_len(size))?,
            strips: Buffer::new(gpu, STRIP_WORDS)?,
            steps: [Texture::new(gpu, size)?, Texture::new(gpu, size)?],
            farthest: [Texture::new(gpu, tiles)?, Texture::new(gpu, large_tiles)?],
            covered: Covered::new(gpu, size)?,
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
        self.covered.count(gpu)
    }

    /// Whether these images serve pictures of `size` pixels made with `params`; if not, make new ones.
    pub fn fit(&self, size: [u32; 2], params: &SsfrParams) -> bool {
        self.size() == size && self.reduced.scale == params.thickness.scale
    }
}

impl ReducedImages {
    fn new(gpu: &Gpu, full: [u32; 2], scale: u32) -> Result<Self, GpuError> {
        let size = full.map(|side| side.div_ceil(scale));
        // Where two blocks share one addition, each has room for a part of the next one's.
        let words_per_sum = if gpu.has_wide_atomics() { 2 } else { 1 };
        Ok(Self {
            scale,
            size,
            surface: Texture::new(gpu, size)?,
            limit: Image::new(gpu, size)?,
            sum: Buffer::new(gpu, words_per_sum * size[0] as usize * size[1] as usize)?,
            resolved: Texture::new(gpu, size)?,
            smoothed: [Texture::new(gpu, size)?, Texture::new(gpu, size)?],
        })
    }
}
