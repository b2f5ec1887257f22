use bytemuck::{Pod, Zeroable};
use meniscus_gpu::role::Occludee;
use meniscus_gpu::{
    Binding, ComputePipeline, Definition, Dispatch, Gpu, HostField, HostStruct, Recorder, shader,
};

use super::{pipeline, pipeline_with};
use crate::{SplatSet, SurfaceImages};

/// `Occlusion` of `shaders/ssfr/occlusion.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct OcclusionUniform {
    count: u32,
}

impl HostStruct for OcclusionUniform {
    const WGSL_NAME: &'static str = "Occlusion";
    const FIELDS: &'static [HostField] = meniscus_gpu::host_fields!(OcclusionUniform { count });
}

/// Finds the tested ranges that what is drawn already does not hide.
pub(super) struct OcclusionPasses {
    farthest: ComputePipeline,
    farthest_again: ComputePipeline,
    occlusion: ComputePipeline,
}

/// Numbers of tiles that a picture of `size` pixels has in columns and rows, and those of the tiles of these.
pub(crate) fn tiles(size: [u32; 2]) -> [[u32; 2]; 2] {
    let small = size.map(|side| side.div_ceil(Occludee::TILE_PX));
    [small, small.map(|side| side.div_ceil(Occludee::TILE_PX))]
}

impl OcclusionPasses {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let first = Definition { name: "FIRST", value: 1 };
        Self {
            farthest: pipeline_with(gpu, shader!("ssfr/farthest"), &[first]),
            farthest_again: pipeline(gpu, shader!("ssfr/farthest")),
            occlusion: pipeline(gpu, shader!("ssfr/occlusion")),
        }
    }

    /// Fills the list of visible ranges of every page that has tested ones; nothing where none has.
    pub(super) fn record(
        &self,
        recorder: &mut Recorder,
        gpu: &Gpu,
        camera: &Binding,
        sets: &[SplatSet<'_>],
        images: &SurfaceImages,
    ) {
        let tested = sets.iter().flat_map(|set| set.pages).filter_map(|page| page.tested);
        let mut tested = tested.filter(|tested| !tested.occludees.is_empty()).peekable();
        if tested.peek().is_none() {
            return;
        }
        let [tiles, large_tiles] = &images.farthest;
        let bindings =
            [("camera", camera.clone()), ("nearest", images.nearest.bind()), ("farthest", tiles.bind())];
        recorder.compute(gpu, "ssfr.farthest", &self.farthest, &bindings, Dispatch::Pixels(tiles.size()));
        let bindings = [("tiles", tiles.bind()), ("farthest", large_tiles.bind())];
        let groups = Dispatch::Pixels(large_tiles.size());
        recorder.compute(gpu, "ssfr.farthest", &self.farthest_again, &bindings, groups);
        for tested in tested {
            recorder.clear(gpu, "ssfr.occlusion", tested.visible.buffer(), 1);
            let count = tested.occludees.len() as u32;
            let uniform = recorder.uniform(&OcclusionUniform { count });
            recorder.compute(
                gpu,
                "ssfr.occlusion",
                &self.occlusion,
                &[
                    ("occlusion", uniform),
                    ("occludees", tested.occludees.bind()),
                    ("farthest", tiles.bind()),
                    ("farthest_large", large_tiles.bind()),
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
    fn the_uniform_has_the_layout_of_its_shader() {
        OcclusionUniform::check_layout(&shader!("ssfr/occlusion"), &[]).unwrap();
    }

    #[test]
    fn a_full_hd_picture_has_two_sizes_of_tiles() {
        assert_eq!(tiles([1920, 1080]), [[240, 135], [30, 17]]);
        assert_eq!(tiles([1, 1]), [[1, 1]; 2]);
    }
}
