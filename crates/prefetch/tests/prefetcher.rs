//! The prefetcher with real threads and a source made for the test.

use std::sync::atomic::{AtomicI64, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Barrier, Mutex};
use std::thread;
use std::time::Duration;

use meniscus_core::{Cancel, FrameError, FrameErrorKind, FrameRequest, FrameSource, SetFrame};
use meniscus_prefetch::{
    FrameState, MemoryLimit, MemoryProbe, Plan, PrefetchError, PrefetchOptions, Prefetcher,
};

const FRAME: u64 = 1 << 20;

/// A source whose frames do what `on_read` says.
struct Source<F> {
    count: usize,
    on_read: F,
}

impl<F: Fn(usize, &Cancel) -> Result<(), FrameError> + Send + Sync> FrameSource for Source<F> {
    fn frame_count(&self) -> usize {
        self.count
    }

    fn time(&self, _index: usize) -> Option<f64> {
        None
    }

    fn estimated_bytes(&self, _index: usize) -> u64 {
        FRAME
    }

    fn read(&self, index: usize, _request: &FrameRequest, cancel: &Cancel) -> Result<SetFrame, FrameError> {
        (self.on_read)(index, cancel)?;
        Ok(SetFrame { index, ..SetFrame::default() })
    }
}

struct Free(Arc<AtomicU64>);

impl MemoryProbe for Free {
    fn available_bytes(&mut self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// A prefetcher of frame numbers, which says they take [`FRAME`] bytes each.
fn prefetcher(
    count: usize,
    threads: usize,
    free: &Arc<AtomicU64>,
    on_read: impl Fn(usize, &Cancel) -> Result<(), FrameError> + Send + Sync + 'static,
) -> Prefetcher<usize> {
    let options = PrefetchOptions { threads, ..PrefetchOptions::default() };
    let source = Arc::new(Source { count, on_read });
    Prefetcher::with_memory(source, |frame| frame.index, |_| FRAME, options, Box::new(Free(free.clone())))
        .expect("threads")
}

fn plenty() -> Arc<AtomicU64> {
    Arc::new(AtomicU64::new(1 << 40))
}

fn play(playhead: usize, step: isize, looping: bool) -> Plan {
    Plan::Play { playhead, step, looping }
}

fn error(kind: FrameErrorKind) -> FrameError {
    FrameError { kind, file: None, message: "as the test wants it".to_owned() }
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

fn ready(prefetcher: &Prefetcher<usize>) -> usize {
    prefetcher.status().iter().filter(|state| matches!(state, FrameState::Ready { .. })).count()
}

#[test]
fn plays_in_order_and_backwards_and_without_a_plan() {
    let prefetcher = prefetcher(50, 3, &plenty(), |_, _| Ok(()));
    prefetcher.set_plan(play(0, 1, false));
    for frame in 0..50 {
        assert_eq!(prefetcher.take(frame), Ok(frame));
    }
    prefetcher.set_plan(play(49, -1, false));
    for frame in (0..50).rev() {
        assert_eq!(prefetcher.take(frame), Ok(frame));
    }
    prefetcher.set_plan(Plan::IDLE);
    assert_eq!(prefetcher.take(17), Ok(17));
    let stats = prefetcher.stats();
    assert!(stats.frames_read >= 101 && stats.stalls >= 1, "{stats:?}");
    assert_eq!(stats.bytes_read, stats.frames_read * FRAME);
}

#[test]
fn fills_up_ahead_before_anything_is_taken() {
    let prefetcher = prefetcher(8, 2, &plenty(), |_, _| Ok(()));
    assert_eq!(prefetcher.status(), [FrameState::Absent; 8]);
    prefetcher.set_plan(play(3, 1, false));
    eventually("frames 3 to 7 are ready", || ready(&prefetcher) == 5);
    assert_eq!(prefetcher.status()[2..4], [FrameState::Absent, FrameState::Ready { bytes: FRAME }]);
    assert_eq!(prefetcher.take(3), Ok(3));
    assert_eq!(prefetcher.status()[3], FrameState::Taken);
    assert_eq!(prefetcher.stats().stalls, 0);
}

#[test]
fn looking_at_a_ready_frame_takes_nothing() {
    let prefetcher = prefetcher(3, 2, &plenty(), |_, _| Ok(()));
    assert_eq!(prefetcher.peek(1), None);
    prefetcher.set_plan(play(0, 1, false));
    eventually("all are ready", || ready(&prefetcher) == 3);
    assert_eq!((prefetcher.peek(1), prefetcher.peek(1), prefetcher.peek(7)), (Some(1), Some(1), None));
    assert_eq!((ready(&prefetcher), prefetcher.take(0), prefetcher.take(1)), (3, Ok(0), Ok(1)));
    assert_eq!((prefetcher.peek(1), prefetcher.stats().stalls), (None, 0));
}

#[test]
fn reads_several_frames_at_once() {
    // Neither of the two reads ends before the other has begun.
    let both = Barrier::new(2);
    let prefetcher = prefetcher(2, 2, &plenty(), move |_, _| {
        both.wait();
        Ok(())
    });
    prefetcher.set_plan(play(0, 1, false));
    assert_eq!((prefetcher.take(0), prefetcher.take(1)), (Ok(0), Ok(1)));
}

#[test]
fn a_broken_frame_is_reported_and_the_next_ones_follow() {
    let tries = Arc::new(AtomicUsize::new(0));
    let counted = tries.clone();
    let prefetcher = prefetcher(6, 2, &plenty(), move |frame, _| match frame {
        2 if counted.fetch_add(1, Ordering::Relaxed) == 0 => Err(error(FrameErrorKind::Malformed)),
        4 => panic!("a bug in a reader"),
        _ => Ok(()),
    });
    prefetcher.set_plan(play(0, 1, false));
    eventually("frame 2 failed", || prefetcher.status()[2] == FrameState::Failed);
    assert_eq!((prefetcher.take(0), prefetcher.take(1)), (Ok(0), Ok(1)));
    assert_eq!(prefetcher.take(2), Err(error(FrameErrorKind::Malformed)));
    assert_eq!(prefetcher.take(3), Ok(3));
    let bug = prefetcher.take(4).expect_err("it panics");
    assert!(bug.message.contains("frame 4") && bug.message.contains("a bug in a reader"), "{bug}");
    assert_eq!(prefetcher.take(5), Ok(5));
    assert_eq!(prefetcher.take(2), Ok(2), "taken again it is tried again");
    assert_eq!(tries.load(Ordering::Relaxed), 2);
    assert_eq!(prefetcher.stats().frames_failed, 2);
}

#[test]
fn no_memory_at_all_still_shows_every_frame() {
    let prefetcher = prefetcher(20, 4, &Arc::new(AtomicU64::new(0)), |_, _| Ok(()));
    prefetcher.set_plan(play(0, 1, false));
    for frame in 0..20 {
        assert_eq!(prefetcher.take(frame), Ok(frame));
    }
    // Out of order, against the plan.
    prefetcher.set_plan(play(0, 1, true));
    for frame in [19, 3, 11] {
        assert_eq!(prefetcher.take(frame), Ok(frame));
    }
}

/// A prepared frame that is counted while it lives.
struct Counted(Arc<AtomicI64>);

impl Drop for Counted {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

#[test]
fn no_more_frames_live_than_the_budget_has_room_for() {
    let (alive, most) = (Arc::new(AtomicI64::new(0)), Arc::new(AtomicI64::new(0)));
    let (counter, peak) = (alive.clone(), most.clone());
    let prepare = move |_| {
        peak.fetch_max(counter.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
        Counted(counter.clone())
    };
    // Half of 20 frames, and a sixteenth less; what is held is not taken off here, which gives at most as much again.
    let free = Box::new(Free(Arc::new(AtomicU64::new(20 * FRAME))));
    let options = PrefetchOptions { threads: 3, ..PrefetchOptions::default() };
    let source = Arc::new(Source { count: 200, on_read: |_, _: &Cancel| Ok(()) });
    let prefetcher = Prefetcher::with_memory(source, prepare, |_| FRAME, options, free).expect("threads");
    for playhead in [0, 100, 40, 199] {
        prefetcher.set_plan(play(playhead, -1, true));
        for step in 0..30 {
            assert!(prefetcher.take((playhead + 200 - step) % 200).is_ok());
        }
    }
    let most = most.load(Ordering::SeqCst);
    assert!((4..=20).contains(&most), "{most}");
    drop(prefetcher);
    assert_eq!(alive.load(Ordering::SeqCst), 0, "nothing leaks");
}

#[test]
fn memory_that_others_take_is_given_back() {
    let free = Arc::new(AtomicU64::new(100 * FRAME));
    let prefetcher = prefetcher(30, 2, &free, |_, _| Ok(()));
    prefetcher.set_plan(play(0, 1, false));
    eventually("all is read", || ready(&prefetcher) == 30);
    free.store(0, Ordering::Relaxed);
    eventually("all but the next are dropped", || ready(&prefetcher) == 1);
    assert_eq!(prefetcher.status()[0], FrameState::Ready { bytes: FRAME });
    assert_eq!(prefetcher.stats().frames_dropped, 29);
}

#[test]
fn a_seek_frees_the_only_reader() {
    let prefetcher = prefetcher(100, 1, &plenty(), |frame, cancel| match frame {
        0 => until_cancelled(cancel),
        _ => Ok(()),
    });
    prefetcher.set_plan(play(0, 1, false));
    eventually("frame 0 is being read", || prefetcher.status()[0] == FrameState::Reading);
    prefetcher.set_plan(play(60, 1, false));
    assert_eq!(prefetcher.take(60), Ok(60));
    assert_eq!(prefetcher.stats().reads_cancelled, 1);
}

fn until_cancelled(cancel: &Cancel) -> Result<(), FrameError> {
    while !cancel.is_cancelled() {
        thread::sleep(Duration::from_millis(1));
    }
    Err(error(FrameErrorKind::Cancelled))
}

#[test]
fn dropping_it_stops_running_reads_and_all_threads() {
    let source = Arc::new(Source { count: 10, on_read: |_, cancel: &Cancel| until_cancelled(cancel) });
    let options = PrefetchOptions { threads: 3, ..PrefetchOptions::default() };
    let prefetcher =
        Prefetcher::new(source.clone(), |frame| frame.index, |_| FRAME, options).expect("threads");
    prefetcher.set_plan(play(0, 1, false));
    eventually("a read runs", || prefetcher.status().contains(&FrameState::Reading));
    drop(prefetcher);
    assert_eq!(Arc::strong_count(&source), 1, "a thread still holds the source");
}

#[test]
fn a_loop_of_frames_given_back_is_read_once() {
    let reads = Arc::new(AtomicUsize::new(0));
    let counted = reads.clone();
    let prefetcher = prefetcher(10, 2, &plenty(), move |_, _| {
        counted.fetch_add(1, Ordering::Relaxed);
        Ok(())
    });
    prefetcher.set_plan(play(0, 1, true));
    for _ in 0..4 {
        for index in 0..10 {
            let frame = prefetcher.take(index).expect("a good frame");
            prefetcher.give_back(index, frame);
        }
    }
    assert_eq!(reads.load(Ordering::Relaxed), 10);
    prefetcher.give_back(11, 11);
}

#[test]
fn wrong_requests_are_named() {
    let prefetcher = prefetcher(3, 1, &plenty(), |_, _| Ok(()));
    let outside = prefetcher.take(3).expect_err("frames 0 to 2 only");
    assert_eq!(outside.kind, FrameErrorKind::Usage);
    for share in [0.0, -1.0, 1.1, f64::NAN] {
        let memory = MemoryLimit::Share(share);
        let options = PrefetchOptions { memory, ..PrefetchOptions::default() };
        let source = Arc::new(Source { count: 1, on_read: |_, _: &Cancel| Ok(()) });
        let refused = Prefetcher::new(source, |frame| frame.index, |_| 0, options);
        assert!(matches!(refused, Err(PrefetchError::MemoryShare { .. })));
    }
}

#[test]
fn a_series_without_frames_is_no_trouble() {
    let prefetcher = prefetcher(0, 2, &plenty(), |_, _| Ok(()));
    prefetcher.set_plan(play(0, 1, true));
    assert_eq!(prefetcher.status(), []);
    assert!(prefetcher.take(0).is_err());
}

/// A source on a medium that changes under it.
#[derive(Default)]
struct Medium {
    count: AtomicUsize,
    /// Frames whose files were written anew, as often as they were.
    written: Mutex<Vec<usize>>,
    /// What reading any frame waits for.
    answers: Mutex<()>,
    broken: Mutex<Vec<usize>>,
}

impl FrameSource for Medium {
    fn frame_count(&self) -> usize {
        self.count.load(Ordering::SeqCst)
    }

    fn time(&self, _index: usize) -> Option<f64> {
        None
    }

    fn estimated_bytes(&self, _index: usize) -> u64 {
        FRAME
    }

    fn read(&self, index: usize, _request: &FrameRequest, _cancel: &Cancel) -> Result<SetFrame, FrameError> {
        drop(self.answers.lock().expect("a sound lock"));
        match self.broken.lock().expect("a sound lock").contains(&index) {
            true => Err(error(FrameErrorKind::Malformed)),
            false => Ok(SetFrame { index, ..SetFrame::default() }),
        }
    }

    fn version(&self, index: usize) -> Option<u64> {
        let written = self.written.lock().expect("a sound lock");
        Some(written.iter().filter(|&&frame| frame == index).count() as u64)
    }

    fn read_coarse(
        &self,
        index: usize,
        share: u32,
        _request: &FrameRequest,
        _cancel: &Cancel,
    ) -> Result<Option<SetFrame>, FrameError> {
        Ok(Some(SetFrame { index: 1000 * share as usize + index, ..SetFrame::default() }))
    }
}

/// A medium of some frames and who reads from it.
fn medium(count: usize, options: PrefetchOptions) -> (Arc<Medium>, Prefetcher<usize>) {
    let medium = Arc::new(Medium { count: AtomicUsize::new(count), ..Medium::default() });
    let source = Arc::clone(&medium) as Arc<dyn FrameSource>;
    let free = Box::new(Free(plenty()));
    let prefetcher = Prefetcher::with_memory(source, |frame| frame.index, |_| FRAME, options, free);
    (medium, prefetcher.expect("threads"))
}

#[test]
fn a_failed_frame_is_read_again_when_its_files_have_changed() {
    let (medium, prefetcher) = medium(5, PrefetchOptions::default());
    medium.broken.lock().expect("a sound lock").push(3);
    prefetcher.set_plan(play(0, 1, false));
    eventually("frame 3 failed", || prefetcher.status()[3] == FrameState::Failed);
    let error_of = |frame: usize| prefetcher.records()[frame].error.clone();
    assert_eq!(error_of(3), Some(error(FrameErrorKind::Malformed)));
    medium.broken.lock().expect("a sound lock").clear();
    medium.written.lock().expect("a sound lock").push(3);
    eventually("it is read again", || ready(&prefetcher) == 5);
    let record = &prefetcher.records()[3];
    assert_eq!((record.error.clone(), record.reads), (None, 1));
    assert!(record.read_time.is_some());
    assert_eq!((prefetcher.take(3), prefetcher.stats().frames_changed), (Ok(3), 1));
}

#[test]
fn a_ready_frame_is_read_again_when_its_files_have_changed() {
    let (medium, prefetcher) = medium(3, PrefetchOptions::default());
    prefetcher.set_plan(play(0, 1, true));
    eventually("all are ready", || ready(&prefetcher) == 3);
    let looked_at = prefetcher.take(1).expect("a good frame");
    *medium.written.lock().expect("a sound lock") = vec![1, 2];
    eventually("what is ready is read again", || prefetcher.records()[2].reads == 2);
    prefetcher.give_back(1, looked_at);
    eventually("what was looked at is, too", || prefetcher.records()[1].reads == 2);
    // They rest from now on.
    eventually("all are ready", || ready(&prefetcher) == 3);
    thread::sleep(Duration::from_secs(1));
    let reads: Vec<u32> = prefetcher.records().iter().map(|record| record.reads).collect();
    assert_eq!(reads, [1, 2, 2]);
}

#[test]
fn frames_that_are_added_to_the_series_join_in() {
    let (medium, prefetcher) = medium(2, PrefetchOptions::default());
    prefetcher.set_plan(play(0, 1, false));
    assert_eq!((prefetcher.take(0), prefetcher.take(1)), (Ok(0), Ok(1)));
    assert!(prefetcher.take(2).is_err());
    medium.count.store(4, Ordering::SeqCst);
    eventually("there are four", || prefetcher.frame_count() == 4);
    eventually("they are read ahead", || ready(&prefetcher) == 2);
    assert_eq!(prefetcher.take(2), Ok(2));
}

#[test]
fn a_disk_that_does_not_answer_costs_its_frame_and_gives_it_back() {
    // Any patience is long enough for frames that take no time, and none for one that never comes.
    let patience = Duration::from_millis(300);
    let (medium, prefetcher) = medium(4, PrefetchOptions { threads: 1, patience, ..Default::default() });
    let lock = medium.answers.lock().expect("a sound lock");
    prefetcher.set_plan(play(0, 1, false));
    let error = prefetcher.take(0).expect_err("it does not come");
    assert_eq!(error.kind, FrameErrorKind::Io);
    assert!(error.message.contains("frame 0") && error.message.contains("does not answer"), "{error}");
    // The only reader is still waiting: nobody else waits for it.
    assert!(prefetcher.take(2).is_err() && prefetcher.take(0).is_err());
    assert!(prefetcher.records()[0].error.is_some());
    drop(lock);
    eventually("the disk is back", || prefetcher.status()[0] == FrameState::Ready { bytes: FRAME });
    assert_eq!((prefetcher.take(0), prefetcher.take(2)), (Ok(0), Ok(2)));
    assert_eq!(prefetcher.records()[0].error, None);
}

#[test]
fn the_frame_that_is_looked_at_has_a_first_impression() {
    let (medium, prefetcher) = medium(9, PrefetchOptions { coarse_share: Some(8), ..Default::default() });
    let lock = medium.answers.lock().expect("a sound lock");
    assert_eq!((prefetcher.take_ready(5), prefetcher.take_coarse(5)), (None, None));
    prefetcher.set_plan(play(5, 0, false));
    let mut coarse = None;
    eventually("it is there before the whole", || {
        coarse = prefetcher.take_coarse(5);
        coarse.is_some()
    });
    assert_eq!((coarse, prefetcher.take_coarse(5), prefetcher.take_ready(5)), (Some(8005), None, None));
    drop(lock);
    assert_eq!(prefetcher.take(5), Ok(5));
    assert_eq!(prefetcher.take_coarse(6), None, "a neighbour needs none");
    eventually("the neighbours follow", || ready(&prefetcher) == 8);
    assert_eq!(prefetcher.take_ready(6), Some(Ok(6)));
}
