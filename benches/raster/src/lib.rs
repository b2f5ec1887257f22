//! Splats two ways: as the surface stage draws them, by compute passes, and as triangles, one per particle, with a depth buffer. The
//! figures say from which radius on triangles would be worth a path of their own on an adapter.

mod agreement;
mod case;
mod figures;
mod triangles;

use bench_ssfr_splat::{Splats, Stage};
use bench_views::GpuTime;
use meniscus_gpu::role::PackedParticle;
use meniscus_gpu::{Gpu, Recorder};

pub use agreement::Agreement;
pub use case::Case;
pub use figures::{Row, Times, crossover, table};

use triangles::{Target, TrianglePass};

/// Both ways of drawing, compiled.
pub struct Ways {
    stage: Stage,
    triangles: TrianglePass,
}

impl Ways {
    /// Compiles both.
    pub fn new(gpu: &Gpu) -> Self {
        Self { stage: Stage::new(gpu), triangles: TrianglePass::new(gpu) }
    }
}

/// A case on the GPU, to be drawn both ways.
pub struct Contest<'a> {
    ways: &'a Ways,
    splats: Splats,
    target: Target,
    bytes: u64,
}

impl<'a> Contest<'a> {
    /// What the compute passes are called: a depth buffer is cleared in the pass that draws, so that starting the picture counts.
    pub const COMPUTE: &'static [&'static str] = &["ssfr.limit", "ssfr.depth"];
    /// What the pass that draws triangles is called.
    pub const TRIANGLES: &'static [&'static str] = &[TrianglePass::NAME];

    /// Draws `case` both ways.
    ///
    /// # Errors
    /// If the pictures differ: then their times mean nothing.
    pub fn new(time: &GpuTime, ways: &'a Ways, case: &Case) -> Result<Self, Agreement> {
        let (gpu, spheres) = (time.gpu(), case.spheres());
        let splats = Splats::new(gpu, &ways.stage, &spheres);
        let mut contest = Self { ways, splats, target: Target::new(gpu, &spheres), bytes: 0 };
        time.measure(1, &[], |recorder, gpu| {
            contest.record_compute(recorder, gpu);
            contest.record_triangles(recorder, gpu);
        });
        let front = contest.splats.images().front.read(gpu).expect("the surface");
        let compute: Vec<f32> = front.into_iter().map(|[distance, _]| distance).collect();
        let agreement = Agreement::of(&compute, &contest.target.distances(gpu), spheres.radius_world);
        if !agreement.is_enough(gpu.summary().is_software()) {
            return Err(agreement);
        }
        contest.bytes = (case.particles() * size_of::<PackedParticle>() + 4 * agreement.covered) as u64;
        Ok(contest)
    }

    /// Bytes that neither way can do without: every particle is read, every covered pixel written once.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Records the surface stage.
    pub fn record_compute(&self, recorder: &mut Recorder, gpu: &Gpu) {
        self.ways.stage.record_opaque(recorder, gpu, &self.splats);
    }

    /// Records the triangles.
    pub fn record_triangles(&self, recorder: &mut Recorder, gpu: &Gpu) {
        self.ways.triangles.record(recorder, gpu, &self.splats, &self.target);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ways_draw_the_same_picture_of_every_case() {
        let time = GpuTime::open();
        let ways = Ways::new(time.gpu());
        for case in Case::all() {
            let contest = Contest::new(&time, &ways, &case.clone().tiny());
            assert!(contest.is_ok(), "{}: pictures differ: {:?}", case.name, contest.err());
        }
    }
}
