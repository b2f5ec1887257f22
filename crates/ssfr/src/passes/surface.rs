use bytemuck::{Pod, Zeroable};
use meniscus_gpu::role::{FrontSphere, NO_SURFACE, SceneDistance, TextureRole};
use meniscus_gpu::{
    Binding, ComputePipeline, Definition, Dispatch, Gpu, GpuError, HostField, HostStruct, PicturePipeline,
    PicturePipelineDescriptor, Pixels, Recorder, Texture, shader,
};

use super::occlusion::OcclusionPasses;
use super::pages::{List, PageBindings, PageDrawing, SplatPipelines, are_small, each_page};
use super::triangles::TrianglePass;
use super::{INCLUDES, counted_pipeline, pipeline, pipeline_with};
use crate::splats::{Common, VisibleRadius};
use crate::{SplatSet, SsfrParams, SurfaceImages};

/// Name of the counter of pixels visited.
const COUNTER: &str = "splat_pixels_depth";

/// WGSL: `Surface` of `shaders/ssfr/surface.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct SurfaceUniform {
    radius_world: f32,
    is_graded: u32,
}

impl HostStruct for SurfaceUniform {
    const WGSL_NAME: &'static str = "Surface";
    const FIELDS: &'static [HostField] =
        meniscus_gpu::host_fields!(SurfaceUniform { radius_world, is_graded });
}

/// Distance and radius of the nearest splat.
pub(crate) struct SurfacePasses {
    spheres: SplatPasses,
    /// For sets whose spheres are all drawn by one invocation each: those in front, and those that are tested.
    small: [SplatPipelines; 2],
    /// Where some may be ellipsoids.
    shaped: Option<SplatPasses>,
    triangles: Option<TrianglePass>,
    occlusion: OcclusionPasses,
    surface: PicturePipeline,
    tiles: ComputePipeline,
}

/// The passes that know what splats look like.
struct SplatPasses {
    depth: SplatPipelines,
    tested_depth: SplatPipelines,
    depth_strips: ComputePipeline,
    radius: ComputePipeline,
    radius_strips: ComputePipeline,
}

impl SplatPasses {
    fn new(gpu: &Gpu, definitions: &[Definition]) -> Self {
        let with = |name| [definitions, &[Definition { name, value: 1 }]].concat();
        let (tested, strips) = (with("TESTED"), with("STRIPS"));
        Self {
            depth: SplatPipelines::new(gpu, shader!("ssfr/depth"), definitions, COUNTER),
            tested_depth: SplatPipelines::new(gpu, shader!("ssfr/depth"), &tested, COUNTER),
            depth_strips: counted_pipeline(gpu, shader!("ssfr/depth"), &strips, COUNTER),
            radius: pipeline_with(gpu, shader!("ssfr/radius"), definitions),
            radius_strips: pipeline_with(gpu, shader!("ssfr/radius"), &strips),
        }
    }
}

fn shaped(gpu: &Gpu, params: &SsfrParams) -> Option<SplatPasses> {
    let shaped = Definition { name: "SHAPED", value: 1 };
    params.anisotropy.is_on().then(|| SplatPasses::new(gpu, &[shaped]))
}

impl SurfacePasses {
    pub(crate) fn new(gpu: &Gpu, params: &SsfrParams) -> Result<Self, GpuError> {
        let small = |definitions: &[Definition]| {
            let definitions = [definitions, &[Definition { name: "SMALL", value: 1 }]].concat();
            SplatPipelines::new(gpu, shader!("ssfr/depth"), &definitions, COUNTER)
        };
        Ok(Self {
            spheres: SplatPasses::new(gpu, &[]),
            small: [small(&[]), small(&[Definition { name: "TESTED", value: 1 }])],
            shaped: shaped(gpu, params),
            triangles: TrianglePass::new(gpu, params),
            occlusion: OcclusionPasses::new(gpu),
            surface: gpu.picture_pipeline(&PicturePipelineDescriptor {
                shader: shader!("ssfr/surface"),
                includes: INCLUDES,
                definitions: &[],
                targets: &[FrontSphere::FORMAT],
                pixels: Pixels::Marked,
            })?,
            tiles: pipeline(gpu, shader!("ssfr/tiles")),
        })
    }

    /// Makes what `params` need and lets go of what they do not.
    pub(crate) fn fit(&mut self, gpu: &Gpu, params: &SsfrParams) {
        self.triangles = TrianglePass::new(gpu, params);
        self.shaped = shaped(gpu, params);
    }

    /// The passes for a page, and what they bind of its shapes.
    fn of(&self, page: &PageBindings<'_>) -> (&SplatPasses, Option<(&'static str, Binding)>) {
        match (&self.shaped, &page.shapes) {
            (Some(shaped), Some(shapes)) => (shaped, Some(("shapes", shapes.clone()))),
            _ => (&self.spheres, None),
        }
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
        let as_triangles = |set: &SplatSet<'_>| self.triangles.as_ref().is_some_and(|pass| pass.suits(set));
        let (large, others): (Vec<_>, Vec<_>) = sets.iter().copied().partition(as_triangles);
        // Nothing behind the opaque scene can win.
        match &self.triangles {
            Some(triangles) if !large.is_empty() => {
                recorder.copy(gpu, "ssfr.limit", scene_distance, &images.distance);
                each_page(recorder, &large, common, List::Front, |recorder, page| {
                    triangles.record(recorder, gpu, camera, page, &images.distance);
                });
                recorder.copy_rows(gpu, "ssfr.limit", &images.distance, &images.nearest);
            }
            _ => recorder.copy_rows(gpu, "ssfr.limit", scene_distance, &images.nearest),
        }
        images.covered.empty(recorder, gpu, "ssfr.limit");
        let bindings = |page: &PageBindings<'_>| {
            vec![
                ("camera", camera.clone()),
                ("splats", page.splats.clone()),
                ("page", page.particles.clone()),
                ("nearest", images.nearest.bind()),
            ]
        };
        for ((list, sets), small) in
            [(List::Front, &others[..]), (List::Visible, sets)].into_iter().zip(&self.small)
        {
            if list == List::Visible {
                self.occlusion.record(recorder, gpu, camera, sets, images);
            }
            each_page(recorder, sets, common, list, |recorder, page| {
                let (passes, shapes) = self.of(&page);
                let of_whole = (list == List::Visible).then(|| ("farthest", images.farthest[0].bind()));
                let mut bindings = bindings(&page);
                if shapes.is_none() && are_small(gpu, page.most_half_px) {
                    bindings.extend(of_whole.into_iter().chain([("ranges", page.ranges)]));
                    recorder.compute(gpu, "ssfr.depth", small.of(page.is_uniform), &bindings, page.groups);
                    return;
                }
                bindings.extend(shapes);
                let whole = if list == List::Visible { &passes.tested_depth } else { &passes.depth };
                let whole = whole.of(page.is_uniform);
                let drawing = PageDrawing { whole, strips: &passes.depth_strips, list: &images.strips };
                drawing.record(recorder, gpu, "ssfr.depth", bindings, of_whole, (page.ranges, page.groups));
            });
        }
        if common.visible_radius == VisibleRadius::Found {
            let pixels = size[0] as usize * size[1] as usize;
            recorder.clear(gpu, "ssfr.radius", &images.radius, pixels);
            for list in [List::Front, List::Visible] {
                each_page(recorder, sets, common, list, |recorder, page| {
                    let mut bindings = bindings(&page);
                    let (passes, shapes) = self.of(&page);
                    bindings.push(("radius", images.radius.bind()));
                    bindings.extend(shapes);
                    let (whole, strips) = (&passes.radius, &passes.radius_strips);
                    let drawing = PageDrawing { whole, strips, list: &images.strips };
                    drawing.record(recorder, gpu, "ssfr.radius", bindings, None, (page.ranges, page.groups));
                });
            }
        }
        let textures = [
            (images.front.view(), [NO_SURFACE.into(), 0.0, 0.0, 0.0]),
            (images.distance.view(), [NO_SURFACE.into(), 0.0, 0.0, 0.0]),
            (images.thickness.view(), [0.0; 4]),
            (images.normal.view(), [0.0; 4]),
        ];
        recorder.clear_textures(gpu, "ssfr.clear", &textures);
        let (radius_world, is_graded) = match common.visible_radius {
            VisibleRadius::One(radius_world) => (radius_world, 0),
            VisibleRadius::Graded(radius_world) => (radius_world, 1),
            VisibleRadius::Found => (0.0, 0),
        };
        let uniform = recorder.uniform(&SurfaceUniform { radius_world, is_graded });
        let bindings = [
            ("camera", camera.clone()),
            ("surface", uniform),
            ("scene_distance", scene_distance.bind()),
            ("nearest", images.nearest.bind()),
            ("radius", images.radius.bind()),
        ];
        let targets = [("front", images.front.view())];
        recorder.picture(gpu, "ssfr.surface", &self.surface, &bindings, &targets, Some(&images.covered));
        let bindings =
            [("camera", camera.clone()), ("front", images.front.bind()), ("tiles", images.covered.tiles())];
        let tiles = Dispatch::Pixels(images.covered.size_in_tiles());
        recorder.compute(gpu, "ssfr.tiles", &self.tiles, &bindings, tiles);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uniform_has_the_layout_of_its_shader() {
        SurfaceUniform::check_layout(&shader!("ssfr/surface"), INCLUDES).unwrap();
    }
}
