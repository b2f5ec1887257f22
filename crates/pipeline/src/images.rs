use meniscus_compositor::Display;
use meniscus_gpu::role::{Radiance, SceneColor, SceneDepth, SceneDistance, Sunlight, SurfaceColor};
use meniscus_gpu::{Gpu, GpuError, Texture};
use meniscus_shading::SunlightPass;
use meniscus_ssfr::{SsfrParams, SurfaceImages};

/// Everything that has the size of the picture; made once per size.
pub(crate) struct FrameImages {
    pub(crate) scene_color: Texture<SceneColor>,
    pub(crate) scene_distance: Texture<SceneDistance>,
    pub(crate) scene_depth: Texture<SceneDepth>,
    pub(crate) surface: SurfaceImages,
    /// A single pixel, for water that no attribute colours.
    pub(crate) no_color: Texture<SurfaceColor>,
    pub(crate) sunlight: Texture<Sunlight>,
    /// A single pixel, for light that nothing changes.
    pub(crate) no_shadow: Texture<Sunlight>,
    pub(crate) radiance: Texture<Radiance>,
    pub(crate) display: Display,
}

impl FrameImages {
    pub(crate) fn new(gpu: &Gpu, size: [u32; 2], surface: &SsfrParams) -> Result<Self, GpuError> {
        Ok(Self {
            scene_color: Texture::new(gpu, size)?,
            scene_distance: Texture::new(gpu, size)?,
            scene_depth: Texture::new(gpu, size)?,
            surface: SurfaceImages::new(gpu, size, surface)?,
            no_color: Texture::new(gpu, [1, 1])?,
            sunlight: Texture::new(gpu, SunlightPass::size_blocks(size))?,
            no_shadow: Texture::from_texels(gpu, [1, 1], &[Sunlight::UNCHANGED])?,
            radiance: Texture::new(gpu, size)?,
            display: Display::new(gpu, size)?,
        })
    }
}
