use std::io;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::{self, JoinHandle};

use meniscus_gpu::Gpu;
use meniscus_lod::{SetPages, SetStore};

use crate::PreparedFrame;

/// Uploads frames before they are drawn, on a thread of its own: copying particles into memory that the GPU can read, and its
/// copying them from there, take place while another frame is drawn.
///
/// What is uploaded waits within the budget of [`Renderer::set_gpu_memory`](crate::Renderer::set_gpu_memory); the frame uploaded
/// last stays there until another one is.
pub struct UploadAhead {
    /// `None` once there will be no more.
    frames: Option<SyncSender<Arc<PreparedFrame>>>,
    thread: Option<JoinHandle<()>>,
}

impl UploadAhead {
    pub(crate) fn new(gpu: Arc<Gpu>, store: Arc<SetStore>) -> io::Result<Self> {
        // One may wait: with more, frames that are drawn by now would be uploaded before the next one.
        let (frames, inbox) = sync_channel(1);
        let thread =
            thread::Builder::new().name("meniscus-upload".into()).spawn(move || run(&gpu, &store, &inbox))?;
        Ok(Self { frames: Some(frames), thread: Some(thread) })
    }

    /// Begins to upload `frame`, unless this is behind already; it is then uploaded when it is drawn. Never waits.
    pub fn begin(&self, frame: Arc<PreparedFrame>) {
        match self.frames.as_ref().map(|frames| frames.try_send(frame)) {
            // Without the thread, too, frames are uploaded when they are drawn.
            None | Some(Ok(()) | Err(TrySendError::Full(_) | TrySendError::Disconnected(_))) => {}
        }
    }
}

impl Drop for UploadAhead {
    fn drop(&mut self) {
        self.frames = None;
        if let Some(thread) = self.thread.take() {
            // A panic has been reported on its thread.
            let _ = thread.join();
        }
    }
}

fn run(gpu: &Gpu, store: &SetStore, frames: &Receiver<Arc<PreparedFrame>>) {
    let mut uploaded: Vec<Arc<SetPages>> = Vec::new();
    for frame in frames {
        // Drawn by now, or not wanted any more.
        uploaded.clear();
        for set in &frame.sets {
            // What fails here fails again when it is drawn, where somebody is told.
            uploaded.extend(store.get_ahead(gpu, &set.chunked).ok().flatten());
        }
        gpu.begin_writes();
    }
}
