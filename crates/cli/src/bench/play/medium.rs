//! How fast files come: from what they lie on, or from a slower medium that is emulated.

use std::fs::File;
use std::io::Read;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use meniscus_core::{Cancel, FrameError, FrameErrorKind, FrameRequest, FrameSource, SetFrame};

/// How fast an emulated medium is.
pub enum Speed {
    /// Bytes per second.
    Rate(f64),
    /// It takes so long for a frame. Follows drawing where it is a multiple of that: other programs slow that down, too.
    FrameTime(Mutex<Duration>),
}

impl Speed {
    /// The time for `bytes` of a frame of as many.
    fn time(&self, bytes: u64) -> Duration {
        match self {
            Self::Rate(bytes_per_second) => Duration::from_secs_f64(bytes as f64 / bytes_per_second),
            Self::FrameTime(time) => *time.lock().unwrap_or_else(PoisonError::into_inner),
        }
    }

    /// From now on a frame takes `time`, unless there is a rate.
    pub fn set_frame_time(&self, new: Duration) {
        if let Self::FrameTime(time) = self {
            *time.lock().unwrap_or_else(PoisonError::into_inner) = new;
        }
    }
}

/// A source behind a medium that delivers one byte after the other at its own speed, to whichever reader comes first.
pub struct SlowSource {
    inner: Arc<dyn FrameSource>,
    speed: Arc<Speed>,
    /// Bytes of a frame's files that are decoded.
    file_bytes: Box<dyn Fn(usize) -> u64 + Send + Sync>,
    /// When the medium has delivered all that was asked of it.
    free_at: Mutex<Instant>,
    /// What it has delivered, and how long that took it.
    delivered: Mutex<(u64, Duration)>,
}

/// How long a cancelled read still waits, at most; what a real one takes for a block.
const BLOCK_TIME: Duration = Duration::from_millis(20);

impl SlowSource {
    pub fn new(
        inner: Arc<dyn FrameSource>,
        speed: Arc<Speed>,
        file_bytes: impl Fn(usize) -> u64 + Send + Sync + 'static,
    ) -> Self {
        let (free_at, delivered) = (Mutex::new(Instant::now()), Mutex::default());
        Self { inner, speed, file_bytes: Box::new(file_bytes), free_at, delivered }
    }

    /// Bytes per second that it gave while it was busy; `None` before it gave any.
    pub fn rate(&self) -> Option<f64> {
        let (bytes, time) = *self.delivered.lock().unwrap_or_else(PoisonError::into_inner);
        (bytes > 0).then(|| bytes as f64 / time.as_secs_f64())
    }

    /// Waits until the medium has delivered one in `share` bytes of frame `index`.
    fn wait_for(&self, index: usize, share: u32, cancel: &Cancel) -> Result<(), FrameError> {
        let bytes = (self.file_bytes)(index);
        let time = self.speed.time(bytes) / share;
        if self.transfer(bytes / u64::from(share), time, cancel) {
            return Ok(());
        }
        let message = format!("frame {index} was cancelled");
        Err(FrameError { kind: FrameErrorKind::Cancelled, file: None, message })
    }

    /// Waits until the medium has delivered `bytes` more, which take `time`; `false` when cancelled.
    fn transfer(&self, bytes: u64, time: Duration, cancel: &Cancel) -> bool {
        let end = {
            let mut free_at = self.free_at.lock().unwrap_or_else(PoisonError::into_inner);
            *free_at = (*free_at).max(Instant::now()) + time;
            *free_at
        };
        loop {
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                let mut delivered = self.delivered.lock().unwrap_or_else(PoisonError::into_inner);
                *delivered = (delivered.0 + bytes, delivered.1 + time);
                return true;
            }
            if cancel.is_cancelled() {
                let mut free_at = self.free_at.lock().unwrap_or_else(PoisonError::into_inner);
                // What is not delivered costs no time; those behind keep the ends that they were promised.
                *free_at = (*free_at).checked_sub(left.min(time)).unwrap_or(*free_at);
                return false;
            }
            thread::sleep(left.min(BLOCK_TIME));
        }
    }
}

impl FrameSource for SlowSource {
    fn frame_count(&self) -> usize {
        self.inner.frame_count()
    }

    fn time(&self, index: usize) -> Option<f64> {
        self.inner.time(index)
    }

    fn estimated_bytes(&self, index: usize) -> u64 {
        self.inner.estimated_bytes(index)
    }

    fn read(&self, index: usize, request: &FrameRequest, cancel: &Cancel) -> Result<SetFrame, FrameError> {
        self.wait_for(index, 1, cancel)?;
        self.inner.read(index, request, cancel)
    }

    fn version(&self, index: usize) -> Option<u64> {
        self.inner.version(index)
    }

    fn read_coarse(
        &self,
        index: usize,
        share: u32,
        request: &FrameRequest,
        cancel: &Cancel,
    ) -> Result<Option<SetFrame>, FrameError> {
        self.wait_for(index, share, cancel)?;
        self.inner.read_coarse(index, share, request, cancel)
    }
}

/// Bytes per second at which `files` come from what they lie on when they are read in turn and not looked at, for at most
/// `limit`; `None` where nothing can be read.
pub fn rate_of(files: &[PathBuf], limit: Duration) -> Option<f64> {
    let mut block = vec![0; 4 << 20];
    let (started, mut bytes) = (Instant::now(), 0_u64);
    for path in files {
        let Ok(mut file) = File::open(path) else { continue };
        while let Ok(count @ 1..) = file.read(&mut block) {
            bytes += count as u64;
        }
        if started.elapsed() > limit {
            break;
        }
    }
    (bytes > 0).then(|| bytes as f64 / started.elapsed().as_secs_f64())
}

/// Drops what the system's cache has of `files`, so that they come from the medium next; whether that could be asked for.
#[cfg(target_os = "linux")]
pub fn forget(files: &[PathBuf]) -> bool {
    let forget = |path: &PathBuf| {
        let file = File::open(path).ok()?;
        rustix::fs::fadvise(&file, 0, None, rustix::fs::Advice::DontNeed).ok()
    };
    files.iter().filter(|path| forget(path).is_some()).count() > 0
}

/// Drops what the system's cache has of `files`, so that they come from the medium next; whether that could be asked for.
#[cfg(not(target_os = "linux"))]
pub fn forget(_files: &[PathBuf]) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Empty;

    impl FrameSource for Empty {
        fn frame_count(&self) -> usize {
            10
        }

        fn time(&self, _index: usize) -> Option<f64> {
            None
        }

        fn estimated_bytes(&self, _index: usize) -> u64 {
            0
        }

        fn read(&self, index: usize, _: &FrameRequest, _: &Cancel) -> Result<SetFrame, FrameError> {
            Ok(SetFrame { index, ..Default::default() })
        }
    }

    /// Two readers get no more out of a medium than one.
    #[test]
    fn the_medium_is_shared() {
        let medium = SlowSource::new(Arc::new(Empty), Arc::new(Speed::Rate(1e6)), |_| 20_000);
        let started = Instant::now();
        thread::scope(|scope| {
            for reader in 0..2 {
                let medium = &medium;
                scope.spawn(move || {
                    (0..3).for_each(|i| {
                        let read = medium.read(2 * i + reader, &FrameRequest::default(), &Cancel::default());
                        assert!(read.is_ok());
                    });
                });
            }
        });
        // A lower bound on time cannot fail for a busy machine: six transfers of 20 ms.
        assert!(started.elapsed() >= Duration::from_millis(120), "{:?}", started.elapsed());
        assert_eq!(medium.rate(), Some(1e6));
    }

    #[test]
    fn a_cancelled_read_leaves_the_medium_to_others() {
        let bytes = |index| if index == 0 { 1_000_000 } else { 0 };
        let medium = SlowSource::new(Arc::new(Empty), Arc::new(Speed::Rate(1.0)), bytes);
        let cancel = Cancel::default();
        cancel.cancel();
        let error = medium.read(0, &FrameRequest::default(), &cancel).expect_err("cancelled");
        assert_eq!(error.kind, FrameErrorKind::Cancelled);
        // Would be there in eleven days.
        assert!(medium.read(1, &FrameRequest::default(), &Cancel::default()).is_ok());
    }
}
