use bytemuck::{Pod, Zeroable};
use meniscus_gpu::role::Occludee;
use meniscus_gpu::{
    ComputePipeline, Definition, Dispatch, Gpu, GpuError, HostField, HostStruct, Recorder, shader,
};

use super::{pipeline, pipeline_with};
use crate::{SplatSet, SurfaceImages};

/// `Tiles` of `shaders/ssfr/farthest.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct TilesUniform {
    source_px: [u32; 2],
    first_source: u32,
    first_tile: u32,
}

impl HostStruct for TilesUniform {
    const WGSL_NAME: &'static str = "Tiles";
    const FIELDS: &'static [HostField] =
        meniscus_gpu::host_fields!(TilesUniform { source_px, first_source, first_tile });
}

/// `Occlusion` of `shaders/ssfr/occlusion.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct OcclusionUniform {
    tiles: [u32; 2],
    large_tiles: [u32; 2],
    first_large: u32,
    count: u32,
}

impl HostStruct for OcclusionUniform {
    const WGSL_NAME: &'static str = "Occlusion";
    const FIELDS: &'static [HostField] =
        meniscus_gpu::host_fields!(OcclusionUniform { tiles, large_tiles, first_large, count });
}

/// Finds the tested ranges that what is drawn already does not hide.
pub(super) struct OcclusionPasses {
    farthest: ComputePipeline,
    farthest_again: ComputePipeline,
    occlusion: ComputePipeline,
}

/// Tiles of a picture of `size` pixels, and the tiles of those.
fn tiles(size: [u32; 2]) -> [[u32; 2]; 2] {
    let small = size.map(|side| side.div_ceil(Occludee::TILE_PX));
    [small, small.map(|side| side.div_ceil(Occludee::TILE_PX))]
}

/// Number of tiles of both sizes of a picture of `size` pixels.
pub(crate) fn tile_count(size: [u32; 2]) -> usize {
    tiles(size).iter().map(|[columns, rows]| *columns as usize * *rows as usize).sum()
}

impl OcclusionPasses {
    pub(super) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let first = Definition { name: "FIRST", value: 1 };
        Ok(Self {
            farthest: pipeline_with(gpu, shader!("ssfr/farthest"), &[first])?,
            farthest_again: pipeline(gpu, shader!("ssfr/farthest"))?,
            occlusion: pipeline(gpu, shader!("ssfr/occlusion"))?,
        })
    }

    /// Fills the list of visible ranges of every page that has tested ones; nothing where none has.
    pub(super) fn record(
        &self,
        recorder: &mut Recorder,
        gpu: &Gpu,
        sets: &[SplatSet<'_>],
        images: &SurfaceImages,
    ) {
        let tested = sets.iter().flat_map(|set| set.pages).filter_map(|page| page.tested);
        let mut tested = tested.filter(|tested| !tested.occludees.is_empty()).peekable();
        if tested.peek().is_none() {
            return;
        }
        let [small, large] = tiles(images.size());
        let first_large = small[0] * small[1];
        let uniform =
            recorder.uniform(&TilesUniform { source_px: images.size(), first_source: 0, first_tile: 0 });
        let nearest = ("nearest", images.nearest.bind());
        let farthest = ("farthest", images.farthest.bind());
        recorder.compute(
            gpu,
            "ssfr.farthest",
            &self.farthest,
            &[("tiles", uniform), nearest, farthest.clone()],
            Dispatch::Pixels(small),
        );
        let uniform =
            recorder.uniform(&TilesUniform { source_px: small, first_source: 0, first_tile: first_large });
        recorder.compute(
            gpu,
            "ssfr.farthest",
            &self.farthest_again,
            &[("tiles", uniform), farthest.clone()],
            Dispatch::Pixels(large),
        );
        for tested in tested {
            recorder.clear(gpu, "ssfr.occlusion", tested.visible.buffer(), 1);
            let count = tested.occludees.len() as u32;
            let uniform =
                recorder.uniform(&OcclusionUniform { tiles: small, large_tiles: large, first_large, count });
            recorder.compute(
                gpu,
                "ssfr.occlusion",
                &self.occlusion,
                &[
                    ("occlusion", uniform),
                    ("occludees", tested.occludees.bind()),
                    farthest.clone(),
                    ("visible", tested.visible.bind()),
                ],
                Dispatch::Groups(u64::from(count).div_ceil(64)),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniforms_have_the_layout_of_their_shaders() {
        TilesUniform::check_layout(&shader!("ssfr/farthest"), &[]).unwrap();
        OcclusionUniform::check_layout(&shader!("ssfr/occlusion"), &[]).unwrap();
    }

    #[test]
    fn a_full_hd_picture_has_two_sizes_of_tiles() {
        assert_eq!(tiles([1920, 1080]), [[240, 135], [30, 17]]);
        assert_eq!(tile_count([1, 1]), 2);
    }
}
