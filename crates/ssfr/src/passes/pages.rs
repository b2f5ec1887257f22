//! How the splat passes go over the pages of all sets.

use meniscus_gpu::role::{KeptRange, Scratch};
use meniscus_gpu::{
    Binding, Buffer, ComputePipeline, Definition, Dispatch, Gpu, RangeList, Recorder, Shader,
};

use super::counted_pipeline;
use crate::splats::{Common, SplatUniform, VisibleRadius, closing};
use crate::{AnisotropyParams, Radii, SplatInput, SplatSet};

/// A splat pass, compiled for sets of one radius and for all others.
pub(super) struct SplatPipelines {
    uniform: ComputePipeline,
    general: ComputePipeline,
}

impl SplatPipelines {
    /// With `definitions`; `counts` names the counter of the pixels it visits.
    pub(super) fn new(gpu: &Gpu, shader: Shader, definitions: &[Definition], counts: &'static str) -> Self {
        let uniform = [definitions, &[Definition { name: "UNIFORM", value: 1 }]].concat();
        Self {
            uniform: counted_pipeline(gpu, shader, &uniform, counts),
            general: counted_pipeline(gpu, shader, definitions, counts),
        }
    }

    pub(super) fn of(&self, is_uniform: bool) -> &ComputePipeline {
        if is_uniform { &self.uniform } else { &self.general }
    }
}

/// Most pixels of a splat that an invocation of a software driver, or of a GPU, draws alone: `MOST_PX` of `shaders/ssfr/strips.inc.wgsl`.
const MOST_PX: [u32; 2] = [4096, 32];

/// Whether invocations draw alone all spheres of half sizes up to `most_half_px`.
pub(super) fn are_small(gpu: &Gpu, most_half_px: f32) -> bool {
    // Pixel centres in a stretch.
    let side = 2.0 * most_half_px + 1.0;
    let [software, hardware] = MOST_PX;
    let most_px = if gpu.summary().is_software() { software } else { hardware };
    side * side <= most_px as f32
}

/// Most strips of a page, which is room for half a billion pixels. Splats that find none are drawn as small ones are.
const STRIPS: u64 = 1 << 17;
/// Words of the list of strips: its length, and four each.
pub(crate) const STRIP_WORDS: usize = 4 * (1 + STRIPS as usize);

/// What draws the splats of a page: `whole` those that an invocation draws alone, `strips` the rest (`shaders/ssfr/strips.inc.wgsl`).
pub(super) struct PageDrawing<'a> {
    pub(super) whole: &'a ComputePipeline,
    pub(super) strips: &'a ComputePipeline,
    /// The list of strips.
    pub(super) list: &'a Buffer<Scratch>,
}

impl PageDrawing<'_> {
    /// Records both, with the `bindings` of both; `whole` with its `ranges`, over workgroups for them, and what else only it has.
    pub(super) fn record(
        &self,
        recorder: &mut Recorder,
        gpu: &Gpu,
        name: &str,
        mut bindings: Vec<(&'static str, Binding)>,
        of_whole: Option<(&'static str, Binding)>,
        (ranges, groups): (Binding, Dispatch),
    ) {
        recorder.clear(gpu, name, self.list, 4);
        bindings.push(("strips", self.list.bind()));
        let whole: Vec<_> = bindings.iter().cloned().chain(of_whole).chain([("ranges", ranges)]).collect();
        recorder.compute(gpu, name, self.whole, &whole, groups);
        recorder.compute(gpu, name, self.strips, &bindings, Dispatch::Shares(STRIPS));
    }
}

/// A list of ranges of a page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum List {
    /// What the surface is drawn from first.
    Front,
    /// What of the tested is not hidden.
    Visible,
    /// What counts in the thickness.
    Mass,
    /// Stand-ins.
    StandIns,
}

/// What a splat pass binds of one page.
pub(super) struct PageBindings<'a> {
    /// Which page of its set.
    pub(super) index: usize,
    pub(super) splats: Binding,
    pub(super) particles: Binding,
    pub(super) ranges: Binding,
    /// Those of the list that the host has written.
    pub(super) runs: &'a [KeptRange],
    /// Of the shapes, where there are any.
    pub(super) shapes: Option<Binding>,
    pub(super) is_uniform: bool,
    /// Of the set ([`SplatSet::most_half_px`]).
    pub(super) most_half_px: f32,
    pub(super) groups: Dispatch,
}

impl List {
    /// Spheres and ranges of the list, and over which workgroups it is drawn; `None` where the page has no such list.
    fn of<'a>(self, page: &SplatInput<'a>) -> Option<(Binding, &'a RangeList, Dispatch)> {
        let all = |spheres: Binding, ranges: &'a RangeList| {
            (spheres, ranges, Dispatch::Groups(ranges.len() as u64))
        };
        let particles = page.particles.bind();
        match self {
            Self::Front => Some(all(particles, page.front)),
            Self::Visible => page
                .tested
                .map(|tested| (particles, tested.visible, Dispatch::Shares(tested.occludees.len() as u64))),
            Self::Mass => Some(all(particles, page.mass)),
            Self::StandIns => page.stand_ins.map(|(spheres, ranges)| all(spheres.bind(), ranges)),
        }
    }
}

/// Calls `record` for the list of every page of every set that has something in it.
pub(super) fn each_page(
    recorder: &mut Recorder,
    sets: &[SplatSet<'_>],
    common: &Common,
    list: List,
    mut record: impl FnMut(&mut Recorder, PageBindings<'_>),
) {
    for set in sets {
        for (index, page) in set.pages.iter().enumerate() {
            let Some((particles, ranges, groups)) = list.of(page) else { continue };
            if matches!(groups, Dispatch::Groups(0) | Dispatch::Shares(0)) {
                continue;
            }
            let radius_world = if list == List::StandIns { set.spacing_world() } else { set.radius_world };
            let splats = recorder.uniform(&SplatUniform {
                radius_world,
                volume_world: set.volume_world,
                steps_per_world: common.steps_per_world,
                closing: closing(set.radius_world, set.spacing_world()),
                is_graded: u32::from(matches!(common.visible_radius, VisibleRadius::Graded(_))),
                most_shift_world: AnisotropyParams::MAX_SHIFT_SPACINGS * set.spacing_world(),
                longest_axis: common.longest_axis,
            });
            let is_uniform = match list {
                List::Front | List::Visible => set.radii == Radii::Equal,
                List::Mass | List::StandIns => set.is_uniform_mass,
            };
            record(
                recorder,
                PageBindings {
                    index,
                    splats,
                    particles,
                    ranges: ranges.bind(),
                    runs: ranges.ranges(),
                    shapes: page.shapes.map(Buffer::bind),
                    is_uniform,
                    most_half_px: set.most_half_px,
                    groups,
                },
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_gpu::shader;

    #[test]
    fn shaders_leave_splats_of_the_same_size_to_strips() {
        let source = shader!(include "ssfr/strips").source;
        assert_eq!(source.matches("const MOST_PX").count(), MOST_PX.len());
        for most_px in MOST_PX {
            assert!(source.contains(&format!("const MOST_PX: i32 = {most_px};")), "{most_px}");
        }
    }
}
