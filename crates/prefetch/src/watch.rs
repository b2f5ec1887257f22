//! What changes on the medium while frames are shown: files of failed frames, and frames that are added to the series.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use crossbeam::channel::{Receiver, RecvTimeoutError, Sender};
use meniscus_core::FrameSource;

use crate::coordinator::Message;

/// How often the medium is looked at. A file that changed is read again after it has rested for one more look, so that one
/// which is being written is not read over and over.
const INTERVAL: Duration = Duration::from_millis(250);

/// A frame that failed, and the version of its files then.
pub(crate) struct Failed {
    pub frame: usize,
    pub version: Option<u64>,
}

/// The versions of a failed frame's files.
struct Versions {
    when_read: Option<u64>,
    last_seen: Option<u64>,
}

/// Looks at the medium until nobody tells of failed frames any more. On a thread of its own: a medium that is gone may take for
/// ever to answer.
pub(crate) fn run<P>(
    source: &Arc<dyn FrameSource>,
    mut frame_count: usize,
    failures: &Receiver<Failed>,
    coordinator: &Sender<Message<P>>,
) {
    let mut failed: BTreeMap<usize, Versions> = BTreeMap::new();
    loop {
        match failures.recv_timeout(INTERVAL) {
            Ok(Failed { frame, version }) => {
                failed.insert(frame, Versions { when_read: version, last_seen: version });
                continue;
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
        let mut news = Vec::new();
        failed.retain(|&frame, versions| {
            let now = source.version(frame);
            let rests = std::mem::replace(&mut versions.last_seen, now) == now;
            let is_news = rests && now != versions.when_read;
            if is_news {
                news.push(Message::Changed { frame, source_bytes: source.estimated_bytes(frame) });
            }
            !is_news
        });
        let count = source.frame_count();
        if count > frame_count {
            let bytes = (frame_count..count).map(|frame| source.estimated_bytes(frame)).collect();
            news.push(Message::Grown(bytes));
            frame_count = count;
        }
        // Nobody listens any more when everything ends.
        if news.into_iter().any(|message| coordinator.send(message).is_err()) {
            return;
        }
    }
}
