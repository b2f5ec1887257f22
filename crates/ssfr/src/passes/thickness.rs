use bytemuck::{Pod, Zeroable};
use meniscus_gpu::role::{SceneDistance, TextureRole, Thickness};
use meniscus_gpu::{
    Binding, ComputePipeline, Definition, Dispatch, Gpu, GpuError, HostField, HostStruct, PicturePipeline,
    Recorder, Texture, shader,
};

use super::pages::{List, PageDrawing, SplatPipelines, each_page};
use super::{counted_pipeline, covered_pipeline, pipeline_with};
use crate::splats::Common;
use crate::{SplatSet, SsfrParams, SurfaceImages};

/// `meniscus::thickness::Thickness` of `shaders/ssfr/thickness.inc.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct ThicknessUniform {
    size_px: [u32; 2],
    scale: u32,
    world_per_step: f32,
    sigma_spacings: f32,
    spacing_per_radius: f32,
    profile_half_px: f32,
    pad: f32,
}

impl HostStruct for ThicknessUniform {
    const WGSL_NAME: &'static str = "Thickness";
    const FIELDS: &'static [HostField] = meniscus_gpu::host_fields!(ThicknessUniform {
        size_px,
        scale,
        world_per_step,
        sigma_spacings,
        spacing_per_radius,
        profile_half_px,
        pad,
    });
}

/// Name of the counter of pixels visited.
const COUNTER: &str = "splat_pixels_thickness";

/// Half size in blocks from which the profile of a stand-in is drawn ([`crate::ThicknessParams::profile_half_px`]). Smaller ones
/// are shared out between four blocks, which together with the smoothing levels what is two blocks apart.
const STAND_IN_PROFILE_HALF_PX: f32 = 1.5;

/// Length of fluid along the ray: summed at reduced size, smoothed, brought back to full size.
pub(crate) struct ThicknessPasses {
    /// Where the scene may cut sets off, and where it does not; of either, where sums may saturate, and where they cannot.
    sums: [[SumPasses; 2]; 2],
    /// Along rows and along columns, where taps lie side by side.
    smooth: [ComputePipeline; 2],
    /// Where they may not, with what evens out their pattern.
    smooth_wide: [ComputePipeline; 4],
    upsample: PicturePipeline,
}

/// The passes that sum.
struct SumPasses {
    prepare: ComputePipeline,
    resolve: ComputePipeline,
    thickness: SplatPipelines,
    points: SplatPipelines,
    thickness_strips: ComputePipeline,
    stand_ins: ComputePipeline,
    stand_in_strips: ComputePipeline,
}

impl SumPasses {
    fn new(gpu: &Gpu, definitions: &[Definition]) -> Self {
        let with = |names: &[&'static str]| {
            let added = names.iter().map(|&name| Definition { name, value: 1 });
            definitions.iter().copied().chain(added).collect::<Vec<_>>()
        };
        let splats = |names| counted_pipeline(gpu, shader!("ssfr/thickness"), &with(names), COUNTER);
        let both = |names| SplatPipelines::new(gpu, shader!("ssfr/thickness"), &with(names), COUNTER);
        Self {
            prepare: pipeline_with(gpu, shader!("ssfr/thickness_prepare"), definitions),
            resolve: pipeline_with(gpu, shader!("ssfr/thickness_resolve"), definitions),
            thickness: both(&[]),
            points: both(&["POINTS"]),
            thickness_strips: splats(&["STRIPS"]),
            stand_ins: splats(&["STAND_IN"]),
            stand_in_strips: splats(&["STAND_IN", "STRIPS"]),
        }
    }
}

impl ThicknessPasses {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let [in_front, bounded, pairs] =
            ["IN_FRONT", "BOUNDED", "PAIRS"].map(|name| Definition { name, value: 1 });
        let sums = |definitions: &[Definition]| {
            let has_pairs = definitions.contains(&bounded) && gpu.has_wide_atomics();
            let pairs: &[Definition] = if has_pairs { &[pairs] } else { &[] };
            SumPasses::new(gpu, &[definitions, pairs].concat())
        };
        let smooth = |names: &[&'static str]| {
            let definitions: Vec<_> = names.iter().map(|&name| Definition { name, value: 1 }).collect();
            pipeline_with(gpu, shader!("ssfr/thickness_smooth"), &definitions)
        };
        Ok(Self {
            sums: [[sums(&[]), sums(&[bounded])], [sums(&[in_front]), sums(&[in_front, bounded])]],
            smooth: [smooth(&["FIRST"]), smooth(&["COLUMNS", "LAST"])],
            smooth_wide: [
                smooth(&["FIRST"]),
                smooth(&["TENT"]),
                smooth(&["COLUMNS"]),
                smooth(&["TENT", "COLUMNS", "LAST"]),
            ],
            upsample: covered_pipeline(gpu, shader!("ssfr/thickness_upsample"), &[], Thickness::FORMAT)?,
        })
    }

    #[expect(clippy::too_many_arguments, reason = "inputs and outputs of six passes, each used once")]
    pub(crate) fn record(
        &self,
        recorder: &mut Recorder,
        gpu: &Gpu,
        camera: &Binding,
        sets: &[SplatSet<'_>],
        common: &Common,
        scene_distance: &Texture<SceneDistance>,
        images: &SurfaceImages,
        params: &SsfrParams,
    ) {
        let reduced = &images.reduced;
        let uniform = ThicknessUniform {
            size_px: reduced.size,
            scale: reduced.scale,
            world_per_step: 1.0 / common.steps_per_world,
            sigma_spacings: params.thickness.smoothing,
            spacing_per_radius: common.spacing_per_radius,
            profile_half_px: params.thickness.profile_half_px(common.spacing_per_radius),
            pad: 0.0,
        };
        let thickness = recorder.uniform(&uniform);
        let pixels = Dispatch::Pixels(reduced.size);
        let passes = &self.sums[usize::from(common.is_in_front)][usize::from(common.is_bounded)];
        let limit = (!common.is_in_front).then(|| ("limit", reduced.limit.bind()));
        let mut bindings = vec![
            ("camera", camera.clone()),
            ("thickness", thickness.clone()),
            ("front", images.front.bind()),
            ("reduced", reduced.surface.bind()),
            ("sum", reduced.sum.bind()),
        ];
        if let Some(limit) = &limit {
            bindings.extend([("scene_distance", scene_distance.bind()), limit.clone()]);
        }
        recorder.compute(gpu, "ssfr.thickness_prepare", &passes.prepare, &bindings, pixels);
        let of_stand_ins = ThicknessUniform { profile_half_px: STAND_IN_PROFILE_HALF_PX, ..uniform };
        let of_stand_ins = recorder.uniform(&of_stand_ins);
        for (list, parameters) in [(List::Mass, &thickness), (List::StandIns, &of_stand_ins)] {
            each_page(recorder, sets, common, list, |recorder, page| {
                let mut bindings = vec![
                    ("camera", camera.clone()),
                    ("splats", page.splats),
                    ("thickness", parameters.clone()),
                    ("page", page.particles),
                    ("sum", reduced.sum.bind()),
                ];
                bindings.extend(limit.clone());
                if list == List::Mass && page.most_half_px < uniform.profile_half_px * reduced.scale as f32 {
                    let whole = passes.points.of(page.is_uniform);
                    let bindings = [bindings, vec![("ranges", page.ranges)]].concat();
                    recorder.compute(gpu, "ssfr.thickness", whole, &bindings, page.groups);
                    return;
                }
                let (whole, strips) = match list {
                    List::StandIns => (&passes.stand_ins, &passes.stand_in_strips),
                    _ => (passes.thickness.of(page.is_uniform), &passes.thickness_strips),
                };
                let drawing = PageDrawing { whole, strips, list: &images.strips };
                drawing.record(recorder, gpu, "ssfr.thickness", bindings, None, (page.ranges, page.groups));
            });
        }
        recorder.compute(
            gpu,
            "ssfr.thickness_resolve",
            &passes.resolve,
            &[
                ("thickness", thickness.clone()),
                ("reduced", reduced.surface.bind()),
                ("sum", reduced.sum.bind()),
                ("resolved", reduced.resolved.bind()),
            ],
            pixels,
        );
        let is_even = params.thickness.is_even(common.spacing_per_radius, common.most_radius_px);
        let smooth: &[ComputePipeline] = if is_even { &self.smooth } else { &self.smooth_wide };
        let mut current = reduced.resolved.bind();
        for (pipeline, smoothed) in smooth.iter().zip(reduced.smoothed.iter().cycle()) {
            let bindings = [
                ("thickness", thickness.clone()),
                ("reduced", reduced.surface.bind()),
                ("source", current),
                ("smoothed", smoothed.bind()),
            ];
            recorder.compute(gpu, "ssfr.thickness_smooth", pipeline, &bindings, pixels);
            current = smoothed.bind();
        }
        let bindings = [("thickness", thickness), ("front", images.front.bind()), ("smoothed", current)];
        let targets = [("length_world", images.thickness.view())];
        let covered = Some(&images.covered);
        recorder.picture(gpu, "ssfr.thickness_upsample", &self.upsample, &bindings, &targets, covered);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::passes::INCLUDES;
    use crate::splats::SplatUniform;

    #[test]
    fn uniforms_have_the_layout_of_their_shaders() {
        SplatUniform::check_layout(&shader!("ssfr/thickness"), INCLUDES).unwrap();
        ThicknessUniform::check_layout(&shader!("ssfr/thickness"), INCLUDES).unwrap();
    }
}
