//! Playing a series on disk while somebody deletes, shortens, replaces and adds its files.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use meniscus_cases::{Case, CaseOptions};
use meniscus_core::{FrameErrorKind, FrameSource};
use meniscus_io::writer::{WriteParticles, write_vtu_raw};
use meniscus_io::{IoMode, Series, SeriesOptions};
use meniscus_prefetch::{FrameState, MemoryLimit, Plan, PrefetchOptions, Prefetcher};

const FRAMES: usize = 6;

fn path(folder: &Path, frame: usize) -> PathBuf {
    folder.join(format!("water_{frame:02}.vtu"))
}

/// Writes a frame of about `particles`, and says how many it has.
fn write(path: &Path, particles: u64, frame: usize) -> usize {
    let frame = Case::DamBreak.frame(&CaseOptions { particles, frames: 12, seed: 1 }, frame);
    let particles = WriteParticles { positions: &frame.positions, attributes: &[], time: None };
    write_vtu_raw(path, &particles).expect("a file");
    frame.positions.len()
}

/// A series of [`FRAMES`] frames in a folder, and a player of their numbers of particles.
fn player(io_mode: IoMode, memory: MemoryLimit) -> (tempfile::TempDir, Arc<Series>, Prefetcher<usize>) {
    meniscus_io::map_guard::install().expect("installed");
    let folder = tempfile::tempdir().expect("a folder");
    (0..FRAMES).for_each(|frame| assert!(write(&path(folder.path(), frame), 5000, frame) > 0));
    let options = SeriesOptions { io_mode, ..Default::default() };
    let series = Arc::new(Series::open(folder.path(), &options).expect("a series"));
    let options = PrefetchOptions { memory, ..Default::default() };
    let source = Arc::clone(&series) as Arc<dyn FrameSource>;
    let prefetcher = Prefetcher::new(source, |frame| frame.len(), |_| 100_000, options).expect("threads");
    (folder, series, prefetcher)
}

/// Waits for what is bound to happen; a minute only keeps a broken build from hanging.
fn eventually(what: &str, mut happened: impl FnMut() -> bool) {
    for _ in 0..60_000 {
        if happened() {
            return;
        }
        thread::sleep(Duration::from_millis(1));
    }
    panic!("never: {what}");
}

#[test]
fn playback_goes_on_whatever_happens_to_files() {
    for io_mode in [IoMode::Map, IoMode::Read] {
        // No memory: every frame is read when it is taken or just before.
        let (folder, _series, prefetcher) = player(io_mode, MemoryLimit::Bytes(0));
        let path = |frame| path(folder.path(), frame);
        prefetcher.set_plan(Plan::Play { playhead: 0, step: 1, looping: true });
        let counts: Vec<_> = (0..FRAMES).map(|frame| prefetcher.take(frame).expect("a good frame")).collect();

        fs::remove_file(path(2)).expect("removed");
        let whole = fs::read(path(3)).expect("a file");
        fs::write(path(3), &whole[..whole.len() / 2]).expect("shortened");
        let other = folder.path().join("other");
        let replaced = write(&other, 1000, 4);
        fs::rename(&other, path(4)).expect("replaced");
        fs::write(path(5), "no particles any more").expect("written");
        let second: Vec<_> = (0..FRAMES).map(|frame| prefetcher.take(frame)).collect();
        assert_eq!((&second[0], &second[1]), (&Ok(counts[0]), &Ok(counts[1])));
        assert_eq!(second[4], Ok(replaced));
        for (frame, kind) in
            [(2, FrameErrorKind::NotFound), (3, FrameErrorKind::Malformed), (5, FrameErrorKind::Unsupported)]
        {
            let error = second[frame].clone().expect_err("a bad file");
            assert_eq!((error.kind, error.file.as_deref()), (kind, Some(path(frame).as_path())), "{error}");
            assert_eq!(prefetcher.records()[frame].error, Some(error));
            assert_eq!(prefetcher.status()[frame], FrameState::Failed);
        }

        let restored = [2, 5].map(|frame| write(&path(frame), 3000, frame));
        fs::write(path(3), whole).expect("written");
        eventually("all are wanted again", || !prefetcher.status().contains(&FrameState::Failed));
        let third: Vec<_> = (0..FRAMES).map(|frame| prefetcher.take(frame)).collect();
        assert_eq!(third, [counts[0], counts[1], restored[0], counts[3], replaced, restored[1]].map(Ok));
        assert_eq!(prefetcher.stats().frames_changed, 3);
        assert!(prefetcher.records().iter().all(|record| record.error.is_none()));
    }
}

#[test]
fn a_frame_is_there_when_its_writer_has_finished() {
    let (folder, series, prefetcher) = player(IoMode::Auto, MemoryLimit::Share(0.5));
    let follow = series.follow();
    prefetcher.set_plan(Plan::Play { playhead: 0, step: 1, looping: false });
    (0..FRAMES).for_each(|frame| assert!(prefetcher.take(frame).is_ok()));

    let finished = folder.path().join("finished");
    let count = write(&finished, 5000, 6);
    let bytes = fs::read(&finished).expect("a file");
    fs::remove_file(&finished).expect("removed");
    fs::write(path(folder.path(), FRAMES), &bytes[..bytes.len() / 3]).expect("written");
    eventually("half a frame is noticed", || prefetcher.frame_count() == FRAMES + 1);
    eventually("it is tried", || prefetcher.status()[FRAMES] == FrameState::Failed);
    fs::write(path(folder.path(), FRAMES), &bytes).expect("written");
    eventually("the rest is", || matches!(prefetcher.status()[FRAMES], FrameState::Ready { .. }));
    assert_eq!(prefetcher.take(FRAMES), Ok(count));
    drop(follow);
}
