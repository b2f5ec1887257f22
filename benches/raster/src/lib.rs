//! Splats both ways that the surface stage can draw them: by compute passes, and as triangles, one per particle. The figures say from which
//! radius on triangles are faster on an adapter: [`SplatParams::triangles_from_px`].

mod agreement;
mod case;
mod figures;

use bench_ssfr_splat::{Splats, Stage};
use bench_views::GpuTime;
use meniscus_gpu::role::PackedParticle;
use meniscus_gpu::{Gpu, Recorder};
use meniscus_ssfr::SplatParams;

pub use agreement::Agreement;
pub use case::Case;
pub use figures::{Row, Times, crossover, table};

/// Both ways of drawing, compiled.
pub struct Ways {
    compute: Stage,
    triangles: Stage,
}

impl Ways {
    /// Compiles both.
    pub fn new(gpu: &Gpu) -> Self {
        let stage = |from_px| Stage::new(gpu, SplatParams { triangles_from_px: Some(from_px) });
        Self { compute: stage(f32::MAX), triangles: stage(0.0) }
    }
}

/// A case on the GPU, to be drawn both ways.
pub struct Contest<'a> {
    ways: &'a Ways,
    splats: Splats,
    bytes: u64,
}

impl<'a> Contest<'a> {
    /// What the passes are called that differ.
    pub const PASSES: &'static [&'static str] = &["ssfr.limit", "ssfr.depth"];

    /// Draws `case` both ways.
    ///
    /// # Errors
    /// If the pictures differ: then their times mean nothing.
    pub fn new(time: &GpuTime, ways: &'a Ways, case: &Case) -> Result<Self, Agreement> {
        let (gpu, spheres) = (time.gpu(), case.spheres());
        let mut contest = Self { ways, splats: Splats::new(gpu, &ways.compute, &spheres), bytes: 0 };
        let distances = |contest: &Self, record: fn(&Self, &mut Recorder, &Gpu)| -> Vec<f32> {
            time.measure(1, &[], |recorder, gpu| record(contest, recorder, gpu));
            let front = contest.splats.images().front.read(gpu).expect("the surface");
            front.into_iter().map(|[distance, _]| distance).collect()
        };
        let compute = distances(&contest, Self::record_compute);
        let triangles = distances(&contest, Self::record_triangles);
        let agreement = Agreement::of(&compute, &triangles, spheres.radius_world);
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

    /// Records the surface stage with compute passes only.
    pub fn record_compute(&self, recorder: &mut Recorder, gpu: &Gpu) {
        self.ways.compute.record_opaque(recorder, gpu, &self.splats);
    }

    /// Records it with triangles.
    pub fn record_triangles(&self, recorder: &mut Recorder, gpu: &Gpu) {
        self.ways.triangles.record_opaque(recorder, gpu, &self.splats);
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
