use std::io;
use std::sync::Arc;
use std::thread::{self, JoinHandle};

use crossbeam::channel::{Receiver, Sender, TrySendError, bounded};
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
    frames: Option<Sender<Arc<PreparedFrame>>>,
    /// The frame that waits for the thread.
    waiting: Receiver<Arc<PreparedFrame>>,
    thread: Option<JoinHandle<()>>,
}

impl UploadAhead {
    pub(crate) fn new(gpu: Arc<Gpu>, store: Arc<SetStore>) -> io::Result<Self> {
        // One may wait: with more, frames that are drawn by now would be uploaded before the next one.
        let (frames, waiting) = bounded(1);
        let inbox = waiting.clone();
        let thread =
            thread::Builder::new().name("meniscus-upload".into()).spawn(move || run(&gpu, &store, &inbox))?;
        Ok(Self { frames: Some(frames), waiting, thread: Some(thread) })
    }

    /// Begins to upload `frame`, in place of one that the thread has not come to: that one is drawn by now, or will be before
    /// this one. Never waits; what is not uploaded when it is drawn is uploaded then.
    pub fn begin(&self, frame: Arc<PreparedFrame>) {
        let Some(frames) = &self.frames else { return };
        let mut sent = frames.try_send(frame);
        while let Err(TrySendError::Full(frame)) = sent {
            // Empty where the thread was faster.
            drop(self.waiting.try_recv());
            sent = frames.try_send(frame);
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
