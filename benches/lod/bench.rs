//! Cutting a frame into chunks, once per frame on a reader thread, and selecting from them, once per camera on the drawing
//! thread, at full detail and at three tenths. `dam-break` has all chunks in the picture, of `fjord-tsunami` most are culled.

use std::cell::OnceCell;

use bench_views::{Stage, View};
use criterion::{Criterion, criterion_group, criterion_main};
use meniscus_gpu::role::PackedParticle;
use meniscus_lod::{ChunkOptions, ChunkedSet, LodParams, Viewpoint, chunks, select};

/// Particles per page: what software Vulkan binds at once.
const PAGE_PARTICLES: usize = 1 << 23;

fn build(view: &View, frame: &meniscus_core::ParticleFrame) -> ChunkedSet {
    chunks::build(frame, &ChunkOptions::new(PAGE_PARTICLES, view.space().spacing as f32))
}

fn lod(criterion: &mut Criterion) {
    let mut stage = Stage::new(criterion, "lod");
    for view in bench_views::views([View::dam_break(), View::fjord_tsunami()]) {
        let (frame, set) = (OnceCell::new(), OnceCell::new());
        let frame = || frame.get_or_init(|| view.read());
        // Positions are read, packed particles and their order written.
        let moved = (size_of::<[f32; 3]>() + size_of::<PackedParticle>() + size_of::<u32>()) as u64;
        stage.cpu(
            ["build", &view.name],
            view.particles,
            frame,
            |_| Some(view.particles * moved),
            |frame| build(&view, frame),
        );
        for threshold in [1.0, 0.3] {
            let params = LodParams { threshold, ..Default::default() };
            let viewpoint = Viewpoint {
                camera: view.camera(),
                size_px: view.size,
                radius_world: view.space().radius as f32,
                shell_reach: 1.0,
                spacing_world: view.space().spacing as f32,
                sample_px: if threshold < 1.0 { 4 } else { 2 },
            };
            stage.cpu(
                [&format!("select-{threshold}"), &view.name],
                view.particles,
                || set.get_or_init(|| build(&view, frame())),
                // Every chunk is read; what is written depends on what is kept.
                |set| Some(size_of_val(set.chunks.as_slice()) as u64),
                |set| select(set, &viewpoint, &params).expect("valid options"),
            );
        }
    }
}

criterion_group!(benches, lod);
criterion_main!(benches);
