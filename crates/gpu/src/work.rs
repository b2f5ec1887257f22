//! What the device was asked to do, counted where it is asked, so that nothing can be left out.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// Work since the last [`crate::Gpu::restart_work`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct GpuWork {
    /// Bytes copied to the device by what they are: the role's name, `Uniforms` for parameters of passes.
    pub uploaded: BTreeMap<&'static str, u64>,
    /// Buffers and textures made, also those that read results back. What the driver and wgpu make for themselves (staging,
    /// time stamps) is not seen from here.
    pub allocations: u64,
    /// Their bytes.
    pub bytes_allocated: u64,
    /// Compute passes, one dispatch each.
    pub compute_passes: u64,
    /// Workgroups of all dispatches.
    pub workgroups: u64,
    /// Raster passes.
    pub raster_passes: u64,
    /// Submissions.
    pub submissions: u64,
}

impl GpuWork {
    /// Name under which parameters of passes are uploaded.
    pub const UNIFORMS: &'static str = "Uniforms";
}

#[derive(Debug, Default)]
pub(crate) struct WorkMeter(Mutex<GpuWork>);

impl WorkMeter {
    pub(crate) fn add(&self, add: impl FnOnce(&mut GpuWork)) {
        add(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner));
    }

    pub(crate) fn read(&self) -> GpuWork {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub(crate) fn restart(&self) {
        self.add(|work| *work = GpuWork::default());
    }
}
