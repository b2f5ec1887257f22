use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, mpsc};

use etcetera::BaseStrategy;
use meniscus_core::Flaw;

use crate::adapter::{self, AdapterChoice, AdapterSummary};
use crate::error::ErrorSink;
use crate::pipeline::ComputePipelineDescriptor;
use crate::pipeline::PassMaker;
use crate::readback::Readback;
use crate::recorder::{BindCache, Submitted};
use crate::work::{GpuWork, WorkMeter};
use crate::{ComputePipeline, GpuError, shader};

/// Bytes of GPU memory that live resources of this crate hold, and the largest sum so far.
#[derive(Debug, Default)]
pub struct GpuMemory {
    current: AtomicU64,
    peak: AtomicU64,
}

impl GpuMemory {
    pub(crate) fn add(&self, bytes: u64) {
        let now = self.current.fetch_add(bytes, Ordering::Relaxed) + bytes;
        self.peak.fetch_max(now, Ordering::Relaxed);
    }

    pub(crate) fn remove(&self, bytes: u64) {
        self.current.fetch_sub(bytes, Ordering::Relaxed);
    }

    /// Bytes held now.
    pub fn current(&self) -> u64 {
        self.current.load(Ordering::Relaxed)
    }

    /// Largest sum so far.
    pub fn peak(&self) -> u64 {
        self.peak.load(Ordering::Relaxed)
    }
}

/// The device that draws, with what every stage needs of it. One per process is enough; not cloned.
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    /// Only for [`Self::write_buffer`], [`Self::submit`] and textures, which count.
    pub(crate) queue: wgpu::Queue,
    summary: AdapterSummary,
    flaw: Option<Flaw>,
    limits: wgpu::Limits,
    features: wgpu::Features,
    pub(crate) memory: Arc<GpuMemory>,
    pub(crate) work: WorkMeter,
    pub(crate) readback: Readback,
    pub(crate) bind_cache: BindCache,
    pub(crate) fill: ComputePipeline,
    pub(crate) list_covered: ComputePipeline,
    pub(crate) passes: PassMaker,
    cache: Option<(wgpu::PipelineCache, PathBuf)>,
}

/// What atomic operations on 64 bits need.
const WIDE_ATOMICS: wgpu::Features =
    wgpu::Features::SHADER_INT64.union(wgpu::Features::SHADER_INT64_ATOMIC_ALL_OPS);

impl Gpu {
    /// Opens the adapter that `choice` names, with all its limits and the optional features that stages know to use.
    ///
    /// # Errors
    /// No adapter, none that fits `choice`, or one that lacks what every stage needs.
    pub fn new(choice: &AdapterChoice) -> Result<Self, GpuError> {
        let instance = adapter::instance();
        let (adapter, flaw) = adapter::choose(&instance, choice)?;
        let info = adapter.get_info();
        let summary = AdapterSummary::of(&info);
        let limits = adapter.limits();
        // Eight storage buffers is WebGPU's guaranteed minimum and what our widest pass binds.
        for (name, found, needed) in [
            ("max_storage_buffers_per_shader_stage", limits.max_storage_buffers_per_shader_stage, 8),
            ("max_compute_invocations_per_workgroup", limits.max_compute_invocations_per_workgroup, 256),
        ] {
            if found < needed {
                let adapter = summary.name.clone();
                return Err(GpuError::Limit { adapter, name, found: found.into(), needed: needed.into() });
            }
        }
        let wanted = wgpu::Features::TIMESTAMP_QUERY
            | wgpu::Features::PIPELINE_CACHE
            | wgpu::Features::FLOAT32_FILTERABLE
            | wgpu::Features::FLOAT32_BLENDABLE;
        // Where there is one memory for both, large data is written where the GPU reads it (`Buffer::write`). Elsewhere such
        // buffers would lie in memory that the GPU reads slowly.
        let shared = wgpu::Features::MAPPABLE_PRIMARY_BUFFERS;
        let of_type = match info.device_type {
            // What an atomic operation costs a software driver hardly depends on its width. An H100 gains 0.02 ms of 0.87 at a million
            // particles and nothing at 18 million (benches/RESULTS.md): too little for passes of its own.
            wgpu::DeviceType::Cpu => shared | WIDE_ATOMICS,
            wgpu::DeviceType::IntegratedGpu => shared,
            _ => wgpu::Features::empty(),
        };
        let features = adapter.features() & (wanted | of_type);
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("meniscus"),
            required_features: features,
            required_limits: limits.clone(),
            ..Default::default()
        }))
        .map_err(|e| GpuError::Device { adapter: summary.name.clone(), message: e.to_string() })?;

        let errors = ErrorSink::default();
        let sink = errors.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            tracing::error!("{error}");
            sink.report(error.to_string());
        }));

        let cache =
            features.contains(wgpu::Features::PIPELINE_CACHE).then(|| open_cache(&device, &info)).flatten();
        let fill_descriptor = ComputePipelineDescriptor::new(shader!("gpu/fill"));
        let passes = PassMaker::new(
            device.clone(),
            cache.as_ref().map(|c| c.0.clone()),
            !summary.is_software(),
            errors,
        );
        let fill = passes.pass(&fill_descriptor)?;
        let list_descriptor = ComputePipelineDescriptor::new(shader!("gpu/list_covered"));
        let list_covered = passes.variant(&list_descriptor);
        Ok(Self {
            device,
            queue,
            summary,
            flaw,
            limits,
            features,
            memory: Arc::default(),
            work: WorkMeter::default(),
            readback: Readback::default(),
            bind_cache: BindCache::default(),
            fill,
            list_covered,
            passes,
            cache,
        })
    }

    /// Composes a compute pass, which is compiled when it is first recorded.
    ///
    /// # Errors
    /// [`GpuError::Shader`] when the shader does not compose or validate.
    pub fn compute_pipeline(
        &self,
        descriptor: &ComputePipelineDescriptor,
    ) -> Result<ComputePipeline, GpuError> {
        self.passes.pass(descriptor)
    }

    /// As [`Self::compute_pipeline`] for a pass of which there are many variants, of which few runs draw all: composed when it is
    /// first recorded, and only once for all who ask for the same. Should it not compose, it does nothing and [`Self::wait`] tells
    /// why; tests of stages call [`Self::compose_variants`].
    pub fn compute_variant(&self, descriptor: &ComputePipelineDescriptor) -> ComputePipeline {
        self.passes.variant(descriptor)
    }

    /// Composes all variants that were asked for.
    ///
    /// # Errors
    /// The first one that does not.
    pub fn compose_variants(&self) -> Result<(), GpuError> {
        self.passes.compose_all();
        self.take_error()
    }

    pub(crate) fn pipeline_cache(&self) -> Option<&wgpu::PipelineCache> {
        self.cache.as_ref().map(|(cache, _)| cache)
    }

    /// Adapter and driver in words.
    pub fn summary(&self) -> &AdapterSummary {
        &self.summary
    }

    /// What is wrong with the choice of adapter, if anything.
    pub fn flaw(&self) -> Option<&Flaw> {
        self.flaw.as_ref()
    }

    /// The device's limits (the adapter's own, all requested).
    pub fn limits(&self) -> &wgpu::Limits {
        &self.limits
    }

    /// Whether raster passes may keep the least of several floats: [`Overlap::Least`](crate::Overlap::Least).
    pub fn keeps_least(&self) -> bool {
        self.features.contains(wgpu::Features::FLOAT32_BLENDABLE)
    }

    /// Whether shaders may, and had better, add to words of 64 bits.
    pub fn has_wide_atomics(&self) -> bool {
        self.features.contains(WIDE_ATOMICS)
    }

    /// The optional features that are on.
    pub fn features(&self) -> wgpu::Features {
        self.features
    }

    /// Whether time stamps of this driver can be believed: on llvmpipe before Mesa 25, a compute pass with one dispatch
    /// reports about zero once a render pass has run. Without them, only [`Timing::Isolated`](crate::Timing) tells what a
    /// pass costs.
    pub fn trusts_time_stamps(&self) -> bool {
        self.features.contains(wgpu::Features::TIMESTAMP_QUERY) && believable_stamps(&self.summary.driver)
    }

    /// Memory held by live buffers, images and textures.
    pub fn memory(&self) -> &GpuMemory {
        &self.memory
    }

    /// What the device was asked to do since [`Self::restart_work`].
    pub fn work(&self) -> GpuWork {
        self.work.read()
    }

    /// Counts from zero: a frame begins.
    pub fn restart_work(&self) {
        self.work.restart();
    }

    /// Whether large buffers are written in place instead of through a copy.
    pub fn writes_in_place(&self) -> bool {
        self.features.contains(wgpu::Features::MAPPABLE_PRIMARY_BUFFERS)
    }

    /// Writes to a mappable buffer in place. Waits for what uses it, and for nothing else.
    pub(crate) fn write_in_place(
        &self,
        what: &'static str,
        buffer: &wgpu::Buffer,
        bytes: &[u8],
    ) -> Result<(), GpuError> {
        let failed = |message: String| GpuError::Driver(format!("{what}: {message}"));
        let (done, mapped) = mpsc::channel();
        let range = ..bytes.len() as u64;
        buffer.slice(range).map_async(wgpu::MapMode::Write, move |result| {
            // Nobody listens any more where waiting failed.
            let _ = done.send(result);
        });
        let mut poll = wgpu::PollType::Poll;
        let result = loop {
            self.device.poll(poll).map_err(|e| failed(e.to_string()))?;
            match mapped.try_recv() {
                Ok(result) => break result,
                Err(mpsc::TryRecvError::Empty) => poll = wgpu::PollType::wait_indefinitely(),
                Err(mpsc::TryRecvError::Disconnected) => return Err(failed("it cannot be mapped".into())),
            }
        };
        result.map_err(|e| failed(e.to_string()))?;
        buffer.get_mapped_range_mut(range).map_err(|e| failed(e.to_string()))?.copy_from_slice(bytes);
        buffer.unmap();
        self.work.add(|work| *work.uploaded.entry(what).or_default() += bytes.len() as u64);
        Ok(())
    }

    pub(crate) fn write_buffer(&self, what: &'static str, buffer: &wgpu::Buffer, offset: u64, bytes: &[u8]) {
        self.work.add(|work| *work.uploaded.entry(what).or_default() += bytes.len() as u64);
        self.queue.write_buffer(buffer, offset, bytes);
    }

    pub(crate) fn submit(&self, commands: Option<wgpu::CommandBuffer>) -> wgpu::SubmissionIndex {
        self.work.add(|work| work.submissions += 1);
        self.queue.submit(commands)
    }

    /// Begins what was written to buffers, which else waits for the next frame.
    pub fn begin_writes(&self) {
        self.submit(None);
    }

    /// Forgets which resources were bound together, which keeps dropped ones alive.
    pub fn forget_bindings(&self) {
        self.bind_cache.clear();
    }

    /// Most elements of `T` that one storage binding may hold.
    pub fn page_elements<T>(&self) -> usize {
        (self.limits.max_storage_buffer_binding_size.min(self.limits.max_buffer_size) as usize)
            / size_of::<T>()
    }

    /// Waits until what was submitted up to `submitted` has run, and not for what another thread uploads meanwhile.
    ///
    /// # Errors
    /// As [`Self::wait`].
    pub fn wait_for(&self, submitted: Submitted) -> Result<(), GpuError> {
        let until = wgpu::PollType::Wait { submission_index: submitted.0, timeout: None };
        self.device.poll(until).map_err(|e| GpuError::Driver(e.to_string()))?;
        self.take_error()
    }

    /// Waits until everything submitted has run.
    ///
    /// # Errors
    /// [`GpuError::Driver`] with the first error the driver reported since the last call.
    pub fn wait(&self) -> Result<(), GpuError> {
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| GpuError::Driver(e.to_string()))?;
        self.take_error()
    }

    /// Keeps `error` for [`Self::wait`], as if the driver had reported it.
    pub fn report(&self, error: &GpuError) {
        self.passes.errors.report(error.to_string());
    }

    pub(crate) fn take_error(&self) -> Result<(), GpuError> {
        self.passes.errors.take().map_or(Ok(()), |message| Err(GpuError::Driver(message)))
    }
}

impl Drop for Gpu {
    /// Keeps compiled pipelines for the next run; failing to is not worth a word.
    fn drop(&mut self) {
        let Some((cache, path)) = &self.cache else { return };
        let Some(data) = cache.get_data() else { return };
        if fs::metadata(path).is_ok_and(|m| m.len() == data.len() as u64) {
            return;
        }
        let beside = path.with_extension(format!("tmp{}", std::process::id()));
        if path.parent().is_some_and(|dir| fs::create_dir_all(dir).is_ok())
            && fs::write(&beside, data).is_ok()
        {
            let _ = fs::rename(&beside, path);
        }
    }
}

/// `driver` as in [`AdapterSummary::driver`], e.g. `llvmpipe Mesa 22.3.6 (LLVM 15.0.6)`.
fn believable_stamps(driver: &str) -> bool {
    let mesa_major = driver.split_once("Mesa ").and_then(|(_, v)| v.split('.').next()?.parse::<u32>().ok());
    !driver.starts_with("llvmpipe") || mesa_major.is_some_and(|major| major >= 25)
}

fn open_cache(device: &wgpu::Device, info: &wgpu::AdapterInfo) -> Option<(wgpu::PipelineCache, PathBuf)> {
    let key = wgpu::util::pipeline_cache_key(info)?;
    let path = etcetera::choose_base_strategy().ok()?.cache_dir().join("meniscus").join(key);
    let data = fs::read(&path).ok();
    // SAFETY: the file was written by `get_data` under the key of this adapter and driver; with `fallback`, a driver that
    // does not like it starts empty.
    let cache = unsafe {
        device.create_pipeline_cache(&wgpu::PipelineCacheDescriptor {
            label: None,
            data: data.as_deref(),
            fallback: true,
        })
    };
    Some((cache, path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn old_llvmpipe_is_not_believed() {
        assert!(!believable_stamps("llvmpipe Mesa 22.3.6 (LLVM 15.0.6)"));
        assert!(!believable_stamps("llvmpipe"));
        assert!(believable_stamps("llvmpipe Mesa 25.0.7-2 (LLVM 19.1.7)"));
        assert!(believable_stamps("NVIDIA 580.95"));
    }
}
