use meniscus_gpu::role::SceneDistance;
use meniscus_gpu::{Binding, ComputePipeline, Dispatch, Gpu, GpuError, Recorder, Texture, shader};

use super::pipeline;
use crate::splats::{Common, SplatUniform};
use crate::{SplatSet, SurfaceImages};

/// Distance and radius of the nearest sphere.
pub(crate) struct SurfacePasses {
    limit: ComputePipeline,
    depth: ComputePipeline,
    radius: ComputePipeline,
    surface: ComputePipeline,
}

impl SurfacePasses {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            limit: pipeline(gpu, shader!("ssfr/limit"))?,
            depth: pipeline(gpu, shader!("ssfr/depth"))?,
            radius: pipeline(gpu, shader!("ssfr/radius"))?,
            surface: pipeline(gpu, shader!("ssfr/surface"))?,
        })
    }

    #[expect(clippy::too_many_arguments, reason = "inputs and outputs of four passes, each used once")]
    pub(crate) fn record(
        &self,
        recorder: &mut Recorder,
        gpu: &Gpu,
        camera: &Binding,
        sets: &[SplatSet<'_>],
        common: &Common,
        scene_distance: &Texture<SceneDistance>,
        images: &SurfaceImages,
    ) {
        let size = images.size();
        recorder.compute(
            gpu,
            "ssfr.limit",
            &self.limit,
            &[
                ("camera", camera.clone()),
                ("scene_distance", scene_distance.bind()),
                ("nearest", images.nearest.bind()),
            ],
            Dispatch::Pixels(size),
        );
        each_page(recorder, sets, common, |recorder, set, particles, ranges, groups| {
            let bindings = [
                ("camera", camera.clone()),
                ("splats", set),
                ("particles", particles),
                ("ranges", ranges),
                ("nearest", images.nearest.bind()),
            ];
            recorder.compute(gpu, "ssfr.depth", &self.depth, &bindings, groups);
        });
        if common.uniform_radius_world.is_none() {
            let pixels = size[0] as usize * size[1] as usize;
            recorder.clear(gpu, "ssfr.radius", images.radius.buffer(), pixels);
            each_page(recorder, sets, common, |recorder, set, particles, ranges, groups| {
                let bindings = [
                    ("camera", camera.clone()),
                    ("splats", set),
                    ("particles", particles),
                    ("ranges", ranges),
                    ("nearest", images.nearest.bind()),
                    ("radius", images.radius.bind()),
                ];
                recorder.compute(gpu, "ssfr.radius", &self.radius, &bindings, groups);
            });
        }
        let uniform = recorder.uniform(&[common.uniform_radius_world.unwrap_or(0.0), 0.0, 0.0, 0.0]);
        recorder.compute(
            gpu,
            "ssfr.surface",
            &self.surface,
            &[
                ("camera", camera.clone()),
                ("surface", uniform),
                ("scene_distance", scene_distance.bind()),
                ("nearest", images.nearest.bind()),
                ("distance", images.unfiltered.bind()),
                ("radius", images.radius.bind()),
            ],
            Dispatch::Pixels(size),
        );
    }
}

/// Calls `record` for every page of every set with the set's uniform, particles, ranges, and one workgroup per range.
pub(super) fn each_page(
    recorder: &mut Recorder,
    sets: &[SplatSet<'_>],
    common: &Common,
    mut record: impl FnMut(&mut Recorder, Binding, Binding, Binding, Dispatch),
) {
    for set in sets {
        for page in set.pages {
            let uniform = recorder.uniform(&SplatUniform {
                radius_world: set.radius_world,
                volume_world: set.volume_world,
                steps_per_world: common.steps_per_world,
                range_count: page.ranges.len() as u32,
            });
            let groups = Dispatch::Groups(page.ranges.len() as u64);
            record(recorder, uniform, page.particles.bind(), page.ranges.bind(), groups);
        }
    }
}
