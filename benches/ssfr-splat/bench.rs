//! Splats: nearest distance and thickness of every particle of a view at full detail, each pass run on its own. Level of
//! detail hands over neighbours in short runs; the view's cells stand in for it. Every committed view is an input, since each
//! has splats of another size: 1.5 px (`fjord-tsunami`), 2.5 (`dam-break`), 6 (`sphere-entry`), 18 (`close-up`).

use std::cell::OnceCell;

use bench_ssfr_splat::{Spheres, Splats};
use bench_views::{GpuTime, Stage, View};
use criterion::{Criterion, criterion_group, criterion_main};
use meniscus_gpu::role::PackedParticle;

/// Bytes that the splats cannot do without: every particle is read, every covered pixel written once.
fn bytes(view: &View) -> u64 {
    let pixels = f64::from(view.size[0]) * f64::from(view.size[1]) * f64::from(view.covered_fraction);
    view.particles * size_of::<PackedParticle>() as u64 + 4 * pixels as u64
}

fn splat(criterion: &mut Criterion) {
    let time = GpuTime::open();
    let passes = bench_ssfr_splat::Stage::new(time.gpu(), Default::default());
    let mut stage = Stage::new(criterion, "ssfr-splat");
    for view in bench_views::views(View::all()) {
        let splats = OnceCell::new();
        for pass in ["ssfr.depth", "ssfr.thickness"] {
            stage.gpu(
                &time,
                ([pass, &view.name], &[pass]),
                view.particles,
                || splats.get_or_init(|| Splats::new(time.gpu(), &passes, &Spheres::of(&view))),
                |_| Some(bytes(&view)),
                |splats, recorder, gpu| passes.record(recorder, gpu, splats),
            );
        }
    }
}

criterion_group!(benches, splat);
criterion_main!(benches);
