//! Cutting a frame into chunks, once per frame on a reader thread, and selecting from them, once per camera on the drawing
//! thread, at full detail and at three tenths.

use std::cell::OnceCell;
use std::hint::black_box;
use std::time::Duration;

use bench_views::View;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use meniscus_lod::{ChunkOptions, ChunkedSet, LodParams, chunks, select};

/// Particles per page: what software Vulkan binds at once.
const PAGE_PARTICLES: usize = 1 << 23;

fn build(view: &View, frame: &meniscus_core::ParticleFrame) -> ChunkedSet {
    chunks::build(frame, &ChunkOptions::new(PAGE_PARTICLES, view.space().spacing as f32))
}

fn lod(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("lod");
    group.sample_size(10).measurement_time(Duration::from_secs(3));
    for view in bench_views::views([View::dam_break(), View::fjord_tsunami()]) {
        // Made when a bench that is not filtered out asks for them.
        let (frame, set) = (OnceCell::new(), OnceCell::new());
        let frame = || frame.get_or_init(|| view.read());
        group.throughput(Throughput::Elements(view.particles));
        group.bench_function(BenchmarkId::new("build", &view.name), |b| {
            b.iter(|| black_box(build(&view, frame())));
        });
        for threshold in [1.0, 0.3] {
            let params = LodParams { threshold, ..Default::default() };
            group.bench_function(BenchmarkId::new(format!("select-{threshold}"), &view.name), |b| {
                let set = set.get_or_init(|| build(&view, frame()));
                let (camera, radius) = (view.camera(), view.space().radius as f32);
                b.iter(|| {
                    black_box(select(set, &camera, view.size, radius, &params).expect("valid options"))
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, lod);
criterion_main!(benches);
