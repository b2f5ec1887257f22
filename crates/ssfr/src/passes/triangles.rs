use std::sync::OnceLock;

use meniscus_gpu::role::EyeDistance;
use meniscus_gpu::{
    Binding, Definition, DepthUse, Gpu, Overlap, RasterPipeline, RasterPipelineDescriptor, Recorder, Texture,
    TextureRole, shader,
};

use super::INCLUDES;
use super::pages::PageBindings;
use crate::{SplatSet, SsfrParams};

/// What draws splats as triangles, one for each, where that is faster.
pub(super) struct TrianglePass {
    from_px: f32,
    /// Whether it draws ellipsoids.
    is_shaped: bool,
    /// Compiled when it is first drawn.
    pipeline: OnceLock<Option<RasterPipeline>>,
}

impl TrianglePass {
    /// `None` where nothing is to be drawn so, or the adapter cannot.
    pub(super) fn new(gpu: &Gpu, params: &SsfrParams) -> Option<Self> {
        let from_px = params.splats.triangles_from_px_on(gpu).filter(|_| gpu.keeps_least())?;
        Some(Self { from_px, is_shaped: params.anisotropy.is_on(), pipeline: OnceLock::new() })
    }

    fn pipeline(&self, gpu: &Gpu) -> Option<&RasterPipeline> {
        let compile = || {
            let shaped = self.is_shaped.then_some(Definition { name: "SHAPED", value: 1 });
            gpu.late_raster_pipeline(&RasterPipelineDescriptor {
                shader: shader!("ssfr/triangles"),
                includes: INCLUDES,
                definitions: shaped.as_slice(),
                vertex_buffers: &[],
                targets: &[EyeDistance::FORMAT],
                depth: DepthUse::None,
                overlap: Overlap::Least,
            })
        };
        self.pipeline.get_or_init(compile).as_ref()
    }

    /// Whether what is drawn of `set` first is drawn so.
    pub(super) fn suits(&self, set: &SplatSet<'_>) -> bool {
        let has_shapes = || set.pages.iter().all(|page| page.shapes.is_some());
        set.front_half_px >= self.from_px && (!self.is_shaped || has_shapes())
    }

    /// Records the ranges of `page` that the host has written, over what is in `distance`.
    pub(super) fn record(
        &self,
        recorder: &mut Recorder,
        gpu: &Gpu,
        camera: &Binding,
        page: PageBindings<'_>,
        distance: &Texture<EyeDistance>,
    ) {
        let Some(pipeline) = self.pipeline(gpu) else { return };
        let bindings: Vec<_> = [
            ("camera", camera.clone()),
            ("splats", page.splats),
            ("page", page.particles),
            ("ranges", page.ranges),
        ]
        .into_iter()
        .chain(page.shapes.filter(|_| self.is_shaped).map(|shapes| ("shapes", shapes)))
        .collect();
        let target = [(distance.view(), None)];
        recorder.raster(gpu, "ssfr.depth", pipeline, &bindings, &target, None, |pass| {
            for (instance, range) in (0..).zip(page.runs) {
                pass.draw(0..3 * range.count, instance..instance + 1);
            }
        });
    }
}
