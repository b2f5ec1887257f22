//! How the splat passes go over the pages of all sets.

use meniscus_gpu::role::Scratch;
use meniscus_gpu::{Binding, Buffer, ComputePipeline, Definition, Dispatch, Gpu, GpuError, Recorder, Shader};

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
    pub(super) fn new(
        gpu: &Gpu,
        shader: Shader,
        definitions: &[Definition],
        counts: &'static str,
    ) -> Result<Self, GpuError> {
        let uniform = [definitions, &[Definition { name: "UNIFORM", value: 1 }]].concat();
        Ok(Self {
            uniform: counted_pipeline(gpu, shader, &uniform, counts)?,
            general: counted_pipeline(gpu, shader, definitions, counts)?,
        })
    }

    pub(super) fn of(&self, is_uniform: bool) -> &ComputePipeline {
        if is_uniform { &self.uniform } else { &self.general }
    }
}

/// Words of the list of strips: its length, and 131 072 strips of four, which is room for half a billion pixels. Splats that find none
/// are drawn as small ones are.
pub(crate) const STRIP_WORDS: usize = 4 * (1 + (1 << 17));

/// Workgroups that share the strips out: enough to fill a GPU, and soon done where there are none.
const STRIP_SHARES: u64 = 1024;

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
        recorder.compute(gpu, name, self.strips, &bindings, Dispatch::Groups(STRIP_SHARES));
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
pub(super) struct PageBindings {
    /// Which page of its set.
    pub(super) index: usize,
    pub(super) splats: Binding,
    pub(super) particles: Binding,
    pub(super) ranges: Binding,
    /// Of the shapes, where there are any.
    pub(super) shapes: Option<Binding>,
    pub(super) is_uniform: bool,
    pub(super) groups: Dispatch,
}

/// Most workgroups that share a list out whose length only the GPU knows: enough to fill any GPU several times over.
const MOST_SHARES: u64 = 4096;

impl List {
    /// Spheres and ranges of the list, and how many workgroups draw it; `None` where the page has no such list.
    fn of(self, page: &SplatInput<'_>) -> Option<(Binding, Binding, u64)> {
        let particles = page.particles.bind();
        match self {
            Self::Front => Some((particles, page.front.bind(), page.front.len() as u64)),
            Self::Visible => page.tested.map(|tested| {
                let most = tested.occludees.len() as u64;
                (particles, tested.visible.bind(), most.min(MOST_SHARES))
            }),
            Self::Mass => Some((particles, page.mass.bind(), page.mass.len() as u64)),
            Self::StandIns => {
                page.stand_ins.map(|(spheres, ranges)| (spheres.bind(), ranges.bind(), ranges.len() as u64))
            }
        }
    }
}

/// Calls `record` for the list of every page of every set that has something in it.
pub(super) fn each_page(
    recorder: &mut Recorder,
    sets: &[SplatSet<'_>],
    common: &Common,
    list: List,
    mut record: impl FnMut(&mut Recorder, PageBindings),
) {
    for set in sets {
        for (index, page) in set.pages.iter().enumerate() {
            let Some((particles, ranges, groups)) = list.of(page) else { continue };
            if groups == 0 {
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
                    ranges,
                    shapes: page.shapes.map(Buffer::bind),
                    is_uniform,
                    groups: Dispatch::Groups(groups),
                },
            );
        }
    }
}
