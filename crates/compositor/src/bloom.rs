//! Light that the lens scatters around what is bright.

use bytemuck::{Pod, Zeroable};
use meniscus_gpu::role::{BloomLevel, Radiance};
use meniscus_gpu::{
    Binding, Definition, DepthUse, Gpu, GpuError, HostField, HostStruct, Overlap, RasterPipeline,
    RasterPipelineDescriptor, Recorder, Shader, Texture, TextureRole, host_fields, shader, wgpu,
};

use crate::compositor::INCLUDES;

const DOWN: Shader = shader!("compositor/bloom_down");
const UP: Shader = shader!("compositor/bloom_up");

/// Share of the light of a level that is scattered further than the level does: the halo loses about a third of its brightness from
/// each ring to the next, which is twice as wide.
pub(crate) const SPREAD: f32 = 0.7;
/// Longer side of the coarsest level, in texels, at most twice this: how wide halos get does not depend on the size of the picture.
const COARSEST_PX: u32 = 8;
/// Levels are enough for pictures of 16384 pixels.
const MAX_LEVELS: u32 = 11;

/// WGSL: `BloomDown` in `shaders/compositor/bloom_down.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
struct DownUniform {
    source_px: [u32; 2],
    exposure: f32,
    pad: u32,
}

impl HostStruct for DownUniform {
    const WGSL_NAME: &'static str = "BloomDown";
    const FIELDS: &'static [HostField] = host_fields!(DownUniform { source_px, exposure, pad });
}

/// WGSL: `BloomUp` in `shaders/compositor/bloom_up.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
struct UpUniform {
    coarse_px: [u32; 2],
    spread: f32,
    pad: f32,
}

impl HostStruct for UpUniform {
    const WGSL_NAME: &'static str = "BloomUp";
    const FIELDS: &'static [HostField] = host_fields!(UpUniform { coarse_px, spread, pad });
}

/// Sizes of the levels for a picture of `size` pixels, the finest first: each half as wide and high as what it is made of, at
/// least one.
pub(crate) fn level_sizes(size: [u32; 2]) -> Vec<[u32; 2]> {
    let longer = size[0].max(size[1]);
    let count = (longer / COARSEST_PX).max(2).ilog2().min(MAX_LEVELS);
    (1..=count).map(|level| size.map(|side| side.div_ceil(1 << level))).collect()
}

/// The passes.
#[derive(Debug)]
pub(crate) struct Bloom {
    first: RasterPipeline,
    down: RasterPipeline,
    up: RasterPipeline,
}

/// The pyramid for pictures of one size, from the finest level to the coarsest.
#[derive(Debug)]
pub(crate) struct BloomImages {
    size: [u32; 2],
    /// Halved from one to the next.
    halved: Vec<Texture<BloomLevel>>,
    /// With what the coarser ones scatter; the coarsest scatters what it has.
    scattered: Vec<Texture<BloomLevel>>,
}

impl BloomImages {
    pub(crate) fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, GpuError> {
        let sizes = level_sizes(size);
        let make = |sizes: &[[u32; 2]]| -> Result<Vec<Texture<BloomLevel>>, GpuError> {
            sizes.iter().map(|&size| Texture::new(gpu, size)).collect()
        };
        Ok(Self { size, halved: make(&sizes)?, scattered: make(&sizes[..sizes.len() - 1])? })
    }

    /// What the picture's light becomes, half as wide and high.
    pub(crate) fn finest(&self) -> &Texture<BloomLevel> {
        self.scattered.first().unwrap_or(&self.halved[0])
    }
}

impl Bloom {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let compile = |shader, definitions: &[Definition]| {
            gpu.raster_pipeline(&RasterPipelineDescriptor {
                shader,
                includes: INCLUDES,
                definitions,
                vertex_buffers: &[],
                targets: &[BloomLevel::FORMAT],
                depth: DepthUse::None,
                overlap: Overlap::Last,
            })
        };
        Ok(Self {
            first: compile(DOWN, &[Definition { name: "FIRST", value: 1 }])?,
            down: compile(DOWN, &[])?,
            up: compile(UP, &[])?,
        })
    }

    /// Records `compositor.bloom_down` and `compositor.bloom_up` of radiance, times `exposure`.
    pub(crate) fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        exposure: f32,
        radiance: &Texture<Radiance>,
        images: &BloomImages,
    ) {
        let mut source = (&self.first, images.size, radiance.bind());
        for level in &images.halved {
            let (pipeline, source_px, texture) = source;
            let down = recorder.uniform(&DownUniform { source_px, exposure, pad: 0 });
            let bindings = [("down", down), ("source", texture)];
            fill(gpu, recorder, "compositor.bloom_down", pipeline, &bindings, level);
            source = (&self.down, level.size(), level.bind());
        }
        let Some(mut coarse) = images.halved.last() else { return };
        for (fine, target) in images.halved.iter().zip(&images.scattered).rev() {
            let up = recorder.uniform(&UpUniform { coarse_px: coarse.size(), spread: SPREAD, pad: 0.0 });
            let bindings = [("up", up), ("fine", fine.bind()), ("coarse", coarse.bind())];
            fill(gpu, recorder, "compositor.bloom_up", &self.up, &bindings, target);
            coarse = target;
        }
    }
}

fn fill(
    gpu: &Gpu,
    recorder: &mut Recorder,
    name: &str,
    pipeline: &RasterPipeline,
    bindings: &[(&str, Binding)],
    target: &Texture<BloomLevel>,
) {
    let targets = [(target.view(), Some(wgpu::Color::BLACK))];
    recorder.raster(gpu, name, pipeline, bindings, &targets, None, |pass| pass.draw(0..3, 0..1));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniforms_match_their_shaders() {
        DownUniform::check_layout(&DOWN, INCLUDES).unwrap();
        UpUniform::check_layout(&UP, INCLUDES).unwrap();
    }

    #[test]
    fn levels_halve_down_to_a_few_texels_and_there_is_always_one() {
        assert_eq!(level_sizes([1, 1]), [[1, 1]]);
        assert_eq!(level_sizes([64, 36]), [[32, 18], [16, 9], [8, 5]]);
        assert_eq!(level_sizes([4097, 3]).last(), Some(&[9, 1]));
        assert_eq!(level_sizes([16384, 16384]).last(), Some(&[8, 8]));
    }
}
