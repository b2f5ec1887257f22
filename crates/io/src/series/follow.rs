//! Frames that a solver adds while the series is open.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use meniscus_core::FrameSource;
use notify::{RecommendedWatcher, RecursiveMode, Watcher};

use super::Series;

/// How long is waited after a sign of change: writers make several at once.
const SETTLE: Duration = Duration::from_millis(50);

/// The folder is looked at this often without any sign: network file systems do not tell of what other machines write.
const POLL: Duration = Duration::from_secs(2);

/// Adds frames to a series as they appear on disk, for as long as it lives.
pub struct Follow {
    /// The thread ends when nobody can call it any more.
    callers: Option<(Sender<()>, Option<RecommendedWatcher>)>,
    thread: Option<JoinHandle<()>>,
}

impl Follow {
    pub(super) fn new(series: Arc<Series>) -> Self {
        let (caller, calls) = mpsc::channel();
        // Where the system has no watchers left, looking every now and then is enough.
        let watcher = watch(&folders(&series), caller.clone()).ok();
        let thread = thread::Builder::new().name("meniscus-follow".to_owned());
        let thread = thread.spawn(move || look_again_when_called(&series, &calls)).ok();
        Self { callers: Some((caller, watcher)), thread }
    }
}

impl Drop for Follow {
    fn drop(&mut self) {
        drop(self.callers.take());
        if let Some(thread) = self.thread.take() {
            // A panic has been reported on its thread.
            let _ = thread.join();
        }
    }
}

fn look_again_when_called(series: &Series, calls: &Receiver<()>) {
    loop {
        match calls.recv_timeout(POLL) {
            Ok(()) => {
                thread::sleep(SETTLE);
                // What has been signalled meanwhile is seen by the same look.
                while calls.try_recv().is_ok() {}
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
        // A folder that cannot be looked through now may be back at the next look.
        let _ = series.look_again();
    }
}

/// The folders of the input and of its last frame.
fn folders(series: &Series) -> BTreeSet<PathBuf> {
    let input = &series.place.input;
    let last = series.files(series.frame_count().saturating_sub(1));
    let parents =
        [input.as_path()].into_iter().chain(last.iter().map(PathBuf::as_path)).filter_map(Path::parent);
    let parents = parents.map(|parent| if parent.as_os_str().is_empty() { Path::new(".") } else { parent });
    parents.chain([input.as_path()]).filter(|folder| folder.is_dir()).map(Path::to_owned).collect()
}

fn watch(folders: &BTreeSet<PathBuf>, caller: Sender<()>) -> notify::Result<RecommendedWatcher> {
    let mut watcher = notify::recommended_watcher(move |event: notify::Result<notify::Event>| {
        // Reading frames is an event, too. Errors are signs of change: events were lost.
        if event.map_or(true, |event| !event.kind.is_access()) {
            let _ = caller.send(());
        }
    })?;
    for folder in folders {
        watcher.watch(folder, RecursiveMode::NonRecursive)?;
    }
    Ok(watcher)
}
