//! What changes on the medium while frames are shown: files of frames that were read or failed, and frames that are added to the
//! series.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crossbeam::channel::{Receiver, RecvTimeoutError, Sender};
use meniscus_core::FrameSource;

use crate::coordinator::Message;

/// How often the medium is looked at. A file that changed is read again after it has rested for one more look, so that one
/// which is being written is not read over and over.
const INTERVAL: Duration = Duration::from_millis(250);

/// Frames in memory whose files are looked at in one turn, one after the other: asking for a file takes microseconds on a local
/// disk and milliseconds on a network, where a long series must not keep it busy.
const AT_A_TIME: usize = 64;

/// A read that has ended.
pub(crate) struct Seen {
    pub frame: usize,
    /// [`FrameSource::version`] before it was read.
    pub version: Option<u64>,
    /// Whether there is no frame.
    pub failed: bool,
}

/// The versions of a frame's files.
struct Versions {
    when_read: Option<u64>,
    last_seen: Option<u64>,
    failed: bool,
}

impl Versions {
    /// Whether somebody may be waiting for the next look.
    fn is_urgent(&self) -> bool {
        self.failed || self.last_seen != self.when_read
    }
}

/// Looks at the medium until nobody tells of reads any more. On a thread of its own: a medium that is gone may take for ever to
/// answer.
pub(crate) fn run<P>(
    source: &Arc<dyn FrameSource>,
    mut frame_count: usize,
    reads: &Receiver<Seen>,
    coordinator: &Sender<Message<P>>,
) {
    let mut known: BTreeMap<usize, Versions> = BTreeMap::new();
    let mut turn = 0;
    let mut next_look = Instant::now() + INTERVAL;
    loop {
        match reads.recv_deadline(next_look) {
            Ok(Seen { frame, version, failed }) => {
                known.insert(frame, Versions { when_read: version, last_seen: version, failed });
                continue;
            }
            Err(RecvTimeoutError::Timeout) => next_look = Instant::now() + INTERVAL,
            Err(RecvTimeoutError::Disconnected) => return,
        }
        let mut news = Vec::new();
        for frame in to_look_at(&known, &mut turn) {
            let Some(versions) = known.get_mut(&frame) else { continue };
            let now = source.version(frame);
            let rests = std::mem::replace(&mut versions.last_seen, now) == now;
            if rests && now != versions.when_read {
                known.remove(&frame);
                news.push(Message::Changed { frame, source_bytes: source.estimated_bytes(frame) });
            }
        }
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

/// The urgent frames, and of the others [`AT_A_TIME`] whose turn it is.
fn to_look_at(known: &BTreeMap<usize, Versions>, turn: &mut usize) -> Vec<usize> {
    let from_turn = known.range(*turn..).chain(known.range(..*turn));
    let (mut frames, mut others) = (Vec::new(), Vec::new());
    for (&frame, versions) in from_turn {
        if versions.is_urgent() { frames.push(frame) } else { others.push(frame) }
    }
    others.truncate(AT_A_TIME);
    *turn = others.last().map_or(0, |last| last + 1);
    frames.extend(others);
    frames
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_frame_has_its_turn_and_urgent_ones_have_all() {
        let versions = |now| Versions { when_read: Some(0), last_seen: Some(now), failed: false };
        let mut known: BTreeMap<usize, Versions> = (0..150).map(|frame| (frame, versions(0))).collect();
        known.insert(20, Versions { failed: true, ..versions(0) });
        known.insert(149, versions(1));
        let mut turn = 0;
        let turns: Vec<Vec<usize>> = (0..3).map(|_| to_look_at(&known, &mut turn)).collect();
        for looked in &turns {
            assert!(looked.contains(&20) && looked.contains(&149) && looked.len() == 2 + AT_A_TIME);
        }
        let mut all = turns.concat();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 150, "148 others in three turns of 64");
        assert_eq!(to_look_at(&BTreeMap::new(), &mut turn), [0; 0]);
    }
}
