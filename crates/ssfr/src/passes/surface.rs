use meniscus_gpu::role::SceneDistance;
use meniscus_gpu::{
    Binding, ComputePipeline, Definition, Dispatch, Gpu, GpuError, Recorder, Shader, Texture, shader,
};

use super::{counted_pipeline, pipeline};
use crate::splats::{Common, SplatUniform};
use crate::{SplatSet, SurfaceImages};

/// Distance and radius of the nearest sphere.
pub(crate) struct SurfacePasses {
    limit: ComputePipeline,
    depth: SplatPipelines,
    radius: ComputePipeline,
    surface: ComputePipeline,
}

impl SurfacePasses {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            limit: pipeline(gpu, shader!("ssfr/limit"))?,
            depth: SplatPipelines::new(gpu, shader!("ssfr/depth"), "splat_pixels_depth")?,
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
                ("covered", images.covered.bind()),
            ],
            Dispatch::Pixels(size),
        );
        each_page(recorder, sets, common, |recorder, page| {
            let bindings = [
                ("camera", camera.clone()),
                ("splats", page.splats),
                ("particles", page.particles),
                ("ranges", page.ranges),
                ("nearest", images.nearest.bind()),
            ];
            recorder.compute(gpu, "ssfr.depth", self.depth.of(page.is_uniform), &bindings, page.groups);
        });
        if common.uniform_radius_world.is_none() {
            let pixels = size[0] as usize * size[1] as usize;
            recorder.clear(gpu, "ssfr.radius", images.radius.buffer(), pixels);
            each_page(recorder, sets, common, |recorder, page| {
                let bindings = [
                    ("camera", camera.clone()),
                    ("splats", page.splats),
                    ("particles", page.particles),
                    ("ranges", page.ranges),
                    ("nearest", images.nearest.bind()),
                    ("radius", images.radius.bind()),
                ];
                recorder.compute(gpu, "ssfr.radius", &self.radius, &bindings, page.groups);
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
                ("unfiltered", images.unfiltered.bind()),
                ("radius", images.radius.bind()),
                ("distance", images.distance.bind()),
                ("length_world", images.thickness.bind()),
                ("normal", images.normal.bind()),
                ("covered", images.covered.bind()),
            ],
            Dispatch::Pixels(size),
        );
    }
}

/// A splat pass, compiled for sets of one radius and for all others.
pub(super) struct SplatPipelines {
    uniform: ComputePipeline,
    general: ComputePipeline,
}

impl SplatPipelines {
    /// `counts` names the counter of the pixels it visits.
    pub(super) fn new(gpu: &Gpu, shader: Shader, counts: &'static str) -> Result<Self, GpuError> {
        let uniform = Definition { name: "UNIFORM", value: 1 };
        Ok(Self {
            uniform: counted_pipeline(gpu, shader, &[uniform], counts)?,
            general: counted_pipeline(gpu, shader, &[], counts)?,
        })
    }

    pub(super) fn of(&self, is_uniform: bool) -> &ComputePipeline {
        if is_uniform { &self.uniform } else { &self.general }
    }
}

/// What a splat pass binds of one page, and one workgroup per range.
pub(super) struct PageBindings {
    pub(super) splats: Binding,
    pub(super) particles: Binding,
    pub(super) ranges: Binding,
    pub(super) is_uniform: bool,
    pub(super) groups: Dispatch,
}

/// Calls `record` for every page of every set.
pub(super) fn each_page(
    recorder: &mut Recorder,
    sets: &[SplatSet<'_>],
    common: &Common,
    mut record: impl FnMut(&mut Recorder, PageBindings),
) {
    for set in sets {
        for page in set.pages {
            let splats = recorder.uniform(&SplatUniform {
                radius_world: set.radius_world,
                volume_world: set.volume_world,
                steps_per_world: common.steps_per_world,
                range_count: page.ranges.len() as u32,
            });
            let bindings = PageBindings {
                splats,
                particles: page.particles.bind(),
                ranges: page.ranges.bind(),
                is_uniform: set.uniform_radius,
                groups: Dispatch::Groups(page.ranges.len() as u64),
            };
            record(recorder, bindings);
        }
    }
}
