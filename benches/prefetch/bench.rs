//! Reading ahead, as the drawing thread meets it: every frame of a series is taken in order, by two reader threads.
//!
//! | bench | input | why |
//! |---|---|---|
//! | `decide` | 4,000 frames that cost nothing to read | what planning, policy and messages alone cost a long series |
//! | `prepare` | 8 frames of the dam break in memory | cutting into chunks on the reader threads, without a file |
//! | `read` | the same 8 frames as raw VTU files | end to end: decoding and cutting, from the page cache |

use std::cell::OnceCell;
use std::path::Path;
use std::sync::Arc;

use bench_views::{Stage, View};
use criterion::{Criterion, criterion_group, criterion_main};
use meniscus_core::{Cancel, FrameError, FrameRequest, FrameSource, ParticleFrame, SetFrame};
use meniscus_io::writer::{WriteParticles, write_vtu_raw};
use meniscus_io::{Series, SeriesOptions};
use meniscus_lod::{ChunkOptions, ChunkedSet, chunks};
use meniscus_prefetch::{Plan, PrefetchOptions, Prefetcher};

/// Particles per page: what software Vulkan binds at once.
const PAGE_PARTICLES: usize = 1 << 23;

/// Long enough for both readers to be busy all the time, short enough to stay in the page cache.
const FRAMES: usize = 8;

/// Frames without particles.
struct Empty(usize);

impl FrameSource for Empty {
    fn frame_count(&self) -> usize {
        self.0
    }

    fn time(&self, _index: usize) -> Option<f64> {
        None
    }

    fn estimated_bytes(&self, _index: usize) -> u64 {
        1
    }

    fn read(&self, index: usize, _: &FrameRequest, _: &Cancel) -> Result<SetFrame, FrameError> {
        Ok(SetFrame { index, ..Default::default() })
    }
}

/// The same frame over and over, from memory.
struct Repeated(SetFrame);

impl FrameSource for Repeated {
    fn frame_count(&self) -> usize {
        FRAMES
    }

    fn time(&self, _index: usize) -> Option<f64> {
        None
    }

    fn estimated_bytes(&self, _index: usize) -> u64 {
        self.0.sets.iter().map(|set| 12 * set.particles.positions.len() as u64).sum()
    }

    fn read(&self, index: usize, _: &FrameRequest, _: &Cancel) -> Result<SetFrame, FrameError> {
        Ok(SetFrame { index, ..self.0.clone() })
    }
}

/// Plays `source` once from its first frame to its last.
fn play<P: Send + 'static>(
    source: Arc<dyn FrameSource>,
    prepare: impl Fn(SetFrame) -> P + Send + Sync + 'static,
    bytes_of: impl Fn(&P) -> u64 + Send + Sync + 'static,
) {
    let count = source.frame_count();
    let prefetcher =
        Prefetcher::new(source, prepare, bytes_of, PrefetchOptions::default()).expect("reader threads");
    prefetcher.set_plan(Plan::Play { playhead: 0, step: 1, looping: false });
    for frame in 0..count {
        prefetcher.take(frame).expect("a readable frame");
    }
}

fn play_in_chunks(source: Arc<dyn FrameSource>, spacing_world: f32) {
    let build = move |particles: &ParticleFrame| {
        chunks::build(particles, &ChunkOptions::new(PAGE_PARTICLES, spacing_world))
    };
    let prepare = move |frame: SetFrame| -> Vec<ChunkedSet> {
        frame.sets.iter().map(|set| build(&set.particles)).collect()
    };
    play(source, prepare, |sets| sets.iter().map(ChunkedSet::bytes).sum());
}

/// The view's frame and those that follow it, as files with positions alone.
fn write_series(folder: &Path, view: &View) -> Series {
    let source = view.source();
    for frame in 0..FRAMES {
        let case = source.case_frame(view.frame + frame, &Cancel::default()).expect("a frame of the case");
        let particles = WriteParticles { positions: &case.positions, attributes: &[], time: Some(case.time) };
        write_vtu_raw(&folder.join(format!("water_{frame:02}.vtu")), &particles)
            .expect("a file in the temporary folder");
    }
    Series::open(folder, &SeriesOptions::default()).expect("files that were just written")
}

fn prefetch(criterion: &mut Criterion) {
    let mut stage = Stage::new(criterion, "prefetch");
    let long = if bench_views::is_measured() { 4_000 } else { 40 };
    stage.cpu(
        ["decide", "empty-frames"],
        long as u64,
        || Arc::new(Empty(long)),
        |_| None,
        |source| play(Arc::<Empty>::clone(source), |frame| frame.index, |_| 1),
    );

    let [view] = bench_views::views([View::dam_break()]);
    let spacing_world = view.space().spacing as f32;
    let particles = view.particles * FRAMES as u64;
    // Positions are copied out of the source, read again, and written as packed particles with their order.
    let prepare_bytes = 3 * 12 + 16 + 4;
    stage.cpu(
        ["prepare", &view.name],
        FRAMES as u64,
        || {
            let request = FrameRequest::default();
            let frame = view.source().read(view.frame, &request, &Cancel::default()).expect("a frame");
            Arc::new(Repeated(frame))
        },
        |_| Some(particles * prepare_bytes),
        |source| play_in_chunks(Arc::<Repeated>::clone(source), spacing_world),
    );

    let folder = tempfile::tempdir().expect("a temporary folder");
    let series = OnceCell::new();
    // Positions in double precision come from the file, go to memory in single, and on as above.
    let read_bytes = 24 + 2 * 12 + 16 + 4;
    stage.cpu(
        ["read", &view.name],
        FRAMES as u64,
        || series.get_or_init(|| Arc::new(write_series(folder.path(), &view))),
        |_| Some(particles * read_bytes),
        |series| play_in_chunks(Arc::<Series>::clone(series), spacing_world),
    );
}

criterion_group!(benches, prefetch);
criterion_main!(benches);
