//! From which radius on triangles are faster than the compute passes: the nearest sphere of each pixel both ways, for radii from
//! 0.6 to 40 px with about as many splat pixels in all, and for dust beside a few spheres before the lens. The last line is the answer for
//! the adapter in use.
//!
//! Times are only taken where both ways draw the same picture.

use bench_raster::{Case, Contest, Row, Times, Ways, crossover, table};
use bench_views::{GpuTime, Stage};
use criterion::{Criterion, criterion_group, criterion_main};

/// `None` where a filter leaves the case out, or nothing is measured.
fn times<'w>(stage: &mut Stage, time: &GpuTime, case: &Case, contest: &Contest<'w>) -> Option<Times> {
    let mut measure = |name, record: fn(&Contest<'w>, &mut _, &_)| {
        stage.gpu(
            time,
            ([name, &case.name], Contest::PASSES),
            case.particles() as u64,
            || contest,
            |contest| Some(contest.bytes()),
            |contest, recorder, gpu| record(contest, recorder, gpu),
        )
    };
    let compute = measure("compute", Contest::record_compute);
    let triangles = measure("triangles", Contest::record_triangles);
    Some(Times { compute: compute?, triangles: triangles? })
}

#[expect(clippy::print_stdout, reason = "what the bench is for")]
fn raster(criterion: &mut Criterion) {
    let time = GpuTime::open();
    let ways = Ways::new(time.gpu());
    let mut stage = Stage::new(criterion, "raster");
    let mut rows = Vec::new();
    for case in Case::all() {
        let case = if bench_views::is_measured() { case } else { case.tiny() };
        let outcome = match Contest::new(&time, &ways, &case) {
            Ok(contest) => times(&mut stage, &time, &case, &contest).map(Ok),
            Err(agreement) => Some(Err(agreement)),
        };
        rows.extend(outcome.map(|outcome| Row { case, outcome }));
    }
    if !rows.is_empty() {
        println!("\n{}\n{}", table(&rows), crossover(&rows));
    }
    // Splats of one size decide the crossover. What a driver makes of close spheres is in the table.
    let differing: Vec<_> = rows.iter().filter(|row| row.outcome.is_err() && row.case.is_equal()).collect();
    assert!(differing.is_empty(), "triangles and compute passes draw different pictures: {differing:#?}");
}

criterion_group!(benches, raster);
criterion_main!(benches);
