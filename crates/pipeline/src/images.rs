use meniscus_gpu::role::{DisplayImage, Radiance, SceneColor, SceneDepth, SceneDistance, SurfaceColor};
use meniscus_gpu::{Gpu, GpuError, Image, Texture};
use meniscus_shading::{SunPath, WaterShadow};
use meniscus_ssfr::{SsfrParams, SurfaceImages};

/// Everything that has the size of the picture; made once per size.
pub(crate) struct FrameImages {
    pub(crate) scene_color: Texture<SceneColor>,
    pub(crate) scene_distance: Texture<SceneDistance>,
    pub(crate) scene_depth: Texture<SceneDepth>,
    pub(crate) surface: SurfaceImages,
    /// A single pixel, for water that no attribute colours.
    pub(crate) no_color: Image<SurfaceColor>,
    pub(crate) sun_path: Image<SunPath>,
    pub(crate) radiance: Image<Radiance>,
    pub(crate) display: Image<DisplayImage>,
}

impl FrameImages {
    pub(crate) fn new(gpu: &Gpu, size: [u32; 2], surface: &SsfrParams) -> Result<Self, GpuError> {
        Ok(Self {
            scene_color: Texture::new(gpu, size)?,
            scene_distance: Texture::new(gpu, size)?,
            scene_depth: Texture::new(gpu, size)?,
            surface: SurfaceImages::new(gpu, size, surface)?,
            no_color: Image::new(gpu, [1, 1])?,
            sun_path: Image::new(gpu, WaterShadow::size_blocks(size))?,
            radiance: Image::new(gpu, size)?,
            display: Image::new(gpu, size)?,
        })
    }
}
