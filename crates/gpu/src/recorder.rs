//! Records passes. There is no other way to run one, and it always has a name and a clock.

use std::borrow::Cow;
use std::collections::HashMap;
use std::num::NonZeroU64;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use meniscus_core::StageCost;
use wgpu_profiler::{GpuProfiler, GpuProfilerSettings, GpuTimerQueryResult};

use crate::pipeline::{Bindings, PictureForm};
use crate::resource::Accounted;
use crate::span::{Span, SpanRow, Spans};
use crate::tally::Tallies;
use crate::{
    Buffer, ComputePipeline, Covered, Gpu, GpuError, GpuWork, PicturePipeline, Pixels, RasterPipeline, Role,
    Texture, TextureRole,
};

/// A resource in a binding slot.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Binding {
    /// Part of a uniform or storage buffer.
    Buffer {
        /// The buffer.
        buffer: wgpu::Buffer,
        /// First byte.
        offset: u64,
        /// Number of bytes; `None` = to the end.
        size: Option<NonZeroU64>,
    },
    /// A texture that is read, or written by a compute pass.
    Texture(wgpu::TextureView),
}

impl Binding {
    pub(crate) fn whole(buffer: &wgpu::Buffer) -> Self {
        Self::Buffer { buffer: buffer.clone(), offset: 0, size: None }
    }

    fn resource(&self) -> wgpu::BindingResource<'_> {
        match self {
            Self::Buffer { buffer, offset, size } => {
                wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: *offset, size: *size })
            }
            Self::Texture(view) => wgpu::BindingResource::TextureView(view),
        }
    }
}

/// Size of a compute dispatch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dispatch {
    /// One invocation per pixel of a `[width, height]` picture; the shader checks the border.
    Pixels([u32; 2]),
    /// This many workgroups of a one-dimensional pass, folded into rows where one dimension does not hold them: the
    /// shader's index is `group.y * num_workgroups.x + group.x`, and it checks the end.
    Groups(u64),
    /// Workgroups of a one-dimensional pass that share out a list whose length only the GPU knows, each of which walks on through
    /// it in steps of all of them: this many at most, fewer where that is enough to keep the adapter busy.
    Shares(u64),
}

/// Workgroups that keep any GPU busy several times over.
const GPU_SHARES: u64 = 4096;
/// Enough to spread over the cores of a processor evenly; one that finds nothing to do costs three microseconds there.
const SOFTWARE_SHARES: u64 = 128;

impl Dispatch {
    fn groups(self, workgroup: [u32; 3], gpu: &Gpu) -> [u32; 3] {
        let max = gpu.limits().max_compute_workgroups_per_dimension;
        match self {
            Self::Pixels(size) => [size[0].div_ceil(workgroup[0]), size[1].div_ceil(workgroup[1]), 1],
            Self::Groups(count) => {
                let x = count.min(u64::from(max)) as u32;
                [x, if x == 0 { 0 } else { count.div_ceil(u64::from(x)) as u32 }, 1]
            }
            Self::Shares(most) => {
                let busy = if gpu.summary().is_software() { SOFTWARE_SHARES } else { GPU_SHARES };
                [most.min(busy) as u32, 1, 1]
            }
        }
    }
}

/// How passes are timed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Timing {
    /// Time stamps at pass boundaries, read after the frame; the frame runs as it does in production. Nothing is timed
    /// where [`Gpu::trusts_time_stamps`] is false.
    #[default]
    Stamps,
    /// Every pass is submitted and waited for on its own, with wall and CPU clocks beside the time stamps. Slower as a whole;
    /// shows what each pass costs the machine, which is what matters on software drivers.
    Isolated,
}

/// A layout's id and what is in each of its slots.
type BindKey = (u64, Vec<(u32, Binding)>);

/// Bind groups of earlier frames, so that the steady state makes none.
#[derive(Debug, Default)]
pub(crate) struct BindCache(Mutex<HashMap<BindKey, wgpu::BindGroup>>);

impl BindCache {
    /// Entries hold their resources alive; this many cover a frame several times over.
    const CAPACITY: usize = 512;

    fn get(
        &self,
        device: &wgpu::Device,
        name: &str,
        bindings: &Bindings,
        given: &[(&str, Binding)],
    ) -> wgpu::BindGroup {
        assert_eq!(given.len(), bindings.slots.len(), "pass {name}: bindings given {:?}", names(given));
        let slots: Vec<(u32, Binding)> = bindings
            .slots
            .iter()
            .map(|slot| {
                let (_, binding) = given.iter().find(|(given, _)| *given == slot.name).unwrap_or_else(|| {
                    panic!("pass {name}: no binding {}, given {:?}", slot.name, names(given))
                });
                (slot.index, binding.clone())
            })
            .collect();
        let key = (bindings.id, slots);
        let mut cache = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(group) = cache.get(&key) {
            return group.clone();
        }
        let entries: Vec<_> = key
            .1
            .iter()
            .map(|(index, binding)| wgpu::BindGroupEntry { binding: *index, resource: binding.resource() })
            .collect();
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(name),
            layout: &bindings.layout,
            entries: &entries,
        });
        if cache.len() >= Self::CAPACITY {
            cache.clear();
        }
        cache.insert(key, group.clone());
        group
    }

    /// Forgets all groups, and with them what keeps dropped resources alive.
    pub(crate) fn clear(&self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }
}

fn names<'a>(given: &[(&'a str, Binding)]) -> Vec<&'a str> {
    given.iter().map(|(name, _)| *name).collect()
}

/// A target that is cleared before it is drawn to, or drawn over.
fn attachment(view: &wgpu::TextureView, clear: Option<wgpu::Color>) -> wgpu::RenderPassColorAttachment<'_> {
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations {
            load: clear.map_or(wgpu::LoadOp::Load, wgpu::LoadOp::Clear),
            store: wgpu::StoreOp::Store,
        },
    }
}

/// Records the passes of a frame and keeps their clocks. Made once and reused: [`Recorder::submit`] ends a frame.
pub struct Recorder {
    encoder: Option<wgpu::CommandEncoder>,
    profiler: Option<GpuProfiler>,
    timing: Timing,
    isolated: Vec<StageCost>,
    uniforms: Vec<u8>,
    uniform_buffer: wgpu::Buffer,
    _accounted: Accounted,
    tallies: Option<Tallies>,
    /// Whether the next pass is the first of its frame.
    is_new_frame: bool,
    spans: Spans,
    /// Put before the names of passes.
    view: &'static str,
}

/// A frame that was handed to the GPU.
#[derive(Debug)]
#[must_use]
pub struct Submitted(pub(crate) Option<wgpu::SubmissionIndex>);

/// Bytes of uniforms that one frame may use; a frame has some 50 passes with less than 512 bytes each.
const UNIFORM_BYTES: u64 = 1 << 18;

impl Recorder {
    /// A recorder for `gpu`.
    pub fn new(gpu: &Gpu, timing: Timing) -> Self {
        let stamps = gpu.trusts_time_stamps();
        let profiler =
            stamps.then(|| GpuProfiler::new(&gpu.device, GpuProfilerSettings::default()).ok()).flatten();
        let uniform_buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("uniforms"),
            size: UNIFORM_BYTES,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self {
            encoder: None,
            profiler,
            timing,
            isolated: Vec::new(),
            uniforms: Vec::new(),
            uniform_buffer,
            _accounted: Accounted::new(gpu, UNIFORM_BYTES),
            tallies: None,
            is_new_frame: true,
            spans: Spans::default(),
            view: "",
        }
    }

    /// Whether the following frames note when their passes ran ([`Self::take_spans`]).
    pub fn set_tracing(&mut self, tracing: bool) {
        self.spans.trace(tracing);
    }

    /// Notes something that the host did for this frame from `begin` until now; only while tracing.
    pub fn note(&mut self, name: &str, begin: Instant) {
        self.spans.push(SpanRow::Host, name, begin);
    }

    /// What ran since the last call; none without [`Self::set_tracing`]. Passes by time stamps are there after
    /// [`Self::take_costs`].
    pub fn take_spans(&mut self) -> Vec<Span> {
        self.spans.take()
    }

    /// Whether passes count their own work in the following frames ([`Self::tallies`]). Slower: every invocation then adds
    /// to one sum of all.
    pub fn set_counting(&mut self, gpu: &Gpu, counting: bool) {
        self.tallies = counting.then(|| self.tallies.take().unwrap_or_else(|| Tallies::new(gpu)));
        self.is_new_frame = true;
    }

    /// What the passes of the last submitted frame counted, by name; none without [`Self::set_counting`]. Waits for the GPU.
    ///
    /// # Errors
    /// The GPU's.
    pub fn tallies(&self, gpu: &Gpu) -> Result<Vec<(&'static str, u64)>, GpuError> {
        self.tallies.as_ref().map_or(Ok(Vec::new()), |tallies| tallies.read(gpu))
    }

    /// Puts `view` before the names of the following passes, which draw for something else than the picture itself, such as what the
    /// sun sees. They count no work ([`Self::set_counting`]). Empty for the picture.
    pub fn set_view(&mut self, view: &'static str) {
        self.view = view;
    }

    /// Changes how the following frames are timed.
    pub fn set_timing(&mut self, timing: Timing) {
        self.timing = timing;
    }

    /// A uniform for one pass of this frame.
    pub fn uniform<T: bytemuck::Pod>(&mut self, value: &T) -> Binding {
        // 256 is the largest alignment that WebGPU lets a device ask for.
        let offset = self.uniforms.len().next_multiple_of(256);
        let size = size_of::<T>().next_multiple_of(16);
        assert!(
            (offset + size) as u64 <= UNIFORM_BYTES,
            "a frame used more than {UNIFORM_BYTES} bytes of uniforms; the recorder was not submitted"
        );
        self.uniforms.resize(offset, 0);
        self.uniforms.extend_from_slice(bytemuck::bytes_of(value));
        self.uniforms.resize(offset + size, 0);
        Binding::Buffer {
            buffer: self.uniform_buffer.clone(),
            offset: offset as u64,
            size: NonZeroU64::new(size as u64),
        }
    }

    /// Runs `pipeline` over `dispatch`, timed as `name` (`stage.pass`); passes of one name are summed. `bindings` gives a
    /// resource for every variable that the shader declares, by name.
    ///
    /// # Panics
    /// If a binding is missing or superfluous: a mistake in the stage, not in any input.
    pub fn compute(
        &mut self,
        gpu: &Gpu,
        name: &str,
        pipeline: &ComputePipeline,
        bindings: &[(&str, Binding)],
        dispatch: Dispatch,
    ) {
        let Some(composed) = pipeline.composed() else { return };
        let groups = dispatch.groups(composed.workgroup_size, gpu);
        if groups.contains(&0) {
            return;
        }
        self.begin_frame(gpu);
        let tallies = self.tallies.as_mut().filter(|_| self.view.is_empty());
        let counting = tallies.and_then(|tallies| {
            let (variant, counter) = pipeline.counting()?;
            Some((variant.composed()?, tallies.slot(counter)?))
        });
        let mut bindings = bindings.to_vec();
        let composed = match counting {
            Some((variant, tally)) => {
                bindings.push(("tally", tally));
                variant
            }
            None => composed,
        };
        let bind_group = gpu.bind_cache.get(&gpu.device, pipeline.name, &composed.bindings, &bindings);
        gpu.work.add(|work| {
            work.compute_passes += 1;
            work.workgroups += groups.iter().map(|&n| u64::from(n)).product::<u64>();
        });
        // Compiled here, when it is drawn first, and not in the time of the pass.
        let compiled: &wgpu::ComputePipeline = &composed.pipeline;
        self.timed(gpu, name, |encoder, query| {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some(name),
                timestamp_writes: query.and_then(|q| q.compute_pass_timestamp_writes()),
            });
            pass.set_pipeline(compiled);
            pass.set_bind_group(0, &bind_group, &[]);
            pass.dispatch_workgroups(groups[0], groups[1], groups[2]);
        });
    }

    /// Runs a raster pass, timed as `name`, into `targets` (each with its clear value, `None` to draw over what is there) and
    /// `depth` (what becomes of it, the pipeline says). `draw` issues the draw calls; pipeline and bindings are set.
    ///
    /// # Panics
    /// As [`Self::compute`].
    #[expect(
        clippy::too_many_arguments,
        reason = "a raster pass is all of these, and a struct would only rename them"
    )]
    pub fn raster(
        &mut self,
        gpu: &Gpu,
        name: &str,
        pipeline: &RasterPipeline,
        bindings: &[(&str, Binding)],
        targets: &[(&wgpu::TextureView, Option<wgpu::Color>)],
        depth: Option<&wgpu::TextureView>,
        draw: impl FnOnce(&mut wgpu::RenderPass<'_>),
    ) {
        let bind_group = gpu.bind_cache.get(&gpu.device, pipeline.name, &pipeline.bindings, bindings);
        self.begin_frame(gpu);
        gpu.work.add(|work| work.raster_passes += 1);
        let attachments: Vec<_> =
            targets.iter().map(|(view, clear)| Some(attachment(view, *clear))).collect();
        self.timed(gpu, name, |encoder, query| {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(name),
                color_attachments: &attachments,
                depth_stencil_attachment: depth.map(|view| wgpu::RenderPassDepthStencilAttachment {
                    view,
                    depth_ops: pipeline.depth.operations(),
                    stencil_ops: None,
                }),
                timestamp_writes: query.and_then(|q| q.render_pass_timestamp_writes()),
                ..Default::default()
            });
            pass.set_pipeline(&pipeline.pipeline);
            pass.set_bind_group(0, &bind_group, &[]);
            draw(&mut pass);
        });
    }

    /// Runs `picture` over pixels of `targets`, which have one size, timed as `name`: in the order of the pipeline, with the names
    /// of their variables. `covered` is of that size, for pipelines of other [`Pixels`] than all.
    ///
    /// # Panics
    /// As [`Self::compute`], and without `covered` where there has to be one.
    pub fn picture(
        &mut self,
        gpu: &Gpu,
        name: &str,
        picture: &PicturePipeline,
        bindings: &[(&str, Binding)],
        targets: &[(&str, &wgpu::TextureView)],
        covered: Option<&Covered>,
    ) {
        if let (Pixels::Marked, Some(covered)) = (picture.pixels, covered) {
            covered.note_marks(matches!(picture.form, PictureForm::Compute(_)));
        }
        match &picture.form {
            PictureForm::Compute(pipeline) => {
                let Some((_, target)) = targets.first() else { return };
                let wgpu::Extent3d { width, height, .. } = target.texture().size();
                let all = Dispatch::Pixels([width, height]);
                let (dispatch, list) = match (picture.pixels, covered) {
                    (Pixels::Covered, Some(covered)) => (covered.dispatch(), Some(covered.list(self, gpu))),
                    (Pixels::Marked, Some(covered)) => (all, Some(covered.room())),
                    _ => (all, None),
                };
                let written = targets.iter().map(|&(name, view)| (name, Binding::Texture(view.clone())));
                let list = list.map(|list| ("covered", list));
                let bindings: Vec<_> = bindings.iter().cloned().chain(written).chain(list).collect();
                self.compute(gpu, name, pipeline, &bindings, dispatch);
            }
            PictureForm::Raster(pipeline) => {
                let targets: Vec<_> = targets.iter().map(|&(_, view)| (view, None)).collect();
                let mask = covered.map(Covered::mask);
                self.raster(gpu, name, pipeline, bindings, &targets, mask, |pass| pass.draw(0..3, 0..1));
            }
        }
    }

    /// Sets the first `count` elements of `buffer` to the role's empty value, timed as `name`.
    pub fn clear<R: Role>(&mut self, gpu: &Gpu, name: &str, buffer: &Buffer<R>, count: usize)
    where
        R::Element: bytemuck::Pod,
    {
        let empty = R::EMPTY;
        let bytes = bytemuck::bytes_of(&empty);
        let mut words = bytes.chunks_exact(4).map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]]));
        let value = words.next().unwrap_or(0);
        assert!(words.all(|w| w == value), "{} is not cleared word by word", R::NAME);
        let count = (count * size_of::<R::Element>() / 4) as u32;
        let fill = self.uniform(&[value, count]);
        let groups = Dispatch::Groups(u64::from(count).div_ceil(256));
        self.compute(gpu, name, &gpu.fill, &[("fill", fill), ("words", buffer.bind())], groups);
    }

    /// Sets all texels of `textures`, which have one size, each to its value, timed as `name`: at most eight, of 32 bytes a texel
    /// together. Software drivers do this by the row, and pay for every number that a compute pass stores.
    pub fn clear_textures(&mut self, gpu: &Gpu, name: &str, textures: &[(&wgpu::TextureView, [f64; 4])]) {
        self.begin_frame(gpu);
        gpu.work.add(|work| work.raster_passes += 1);
        let color = |[r, g, b, a]: [f64; 4]| wgpu::Color { r, g, b, a };
        let attachments: Vec<_> =
            textures.iter().map(|(view, value)| Some(attachment(view, Some(color(*value))))).collect();
        self.timed(gpu, name, |encoder, query| {
            encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(name),
                color_attachments: &attachments,
                timestamp_writes: query.and_then(|q| q.render_pass_timestamp_writes()),
                ..Default::default()
            });
        });
    }

    /// Copies all texels of `from` to `to`, timed as `name`.
    ///
    /// # Panics
    /// If the sizes or the formats differ.
    pub fn copy<A: TextureRole, B: TextureRole>(
        &mut self,
        gpu: &Gpu,
        name: &str,
        from: &Texture<A>,
        to: &Texture<B>,
    ) {
        assert_eq!((from.size(), A::FORMAT), (to.size(), B::FORMAT), "{} to {}", A::NAME, B::NAME);
        self.begin_frame(gpu);
        self.timed(gpu, name, |encoder, _| {
            encoder.copy_texture_to_texture(
                from.raw.as_image_copy(),
                to.raw.as_image_copy(),
                from.raw.size(),
            );
        });
    }

    /// Copies all texels of `from` to the start of `to`, row by row, timed as `name`.
    ///
    /// # Panics
    /// If `to` is too small.
    pub fn copy_rows<A: TextureRole, B: Role>(
        &mut self,
        gpu: &Gpu,
        name: &str,
        from: &Texture<A>,
        to: &Buffer<B>,
    ) {
        let [width, height] = from.size();
        let row_bytes = width * size_of::<A::Texel>() as u32;
        assert!(u64::from(row_bytes) * u64::from(height) <= to.bytes(), "{} to {}", A::NAME, B::NAME);
        // Several rows at once have to be multiples of 256 bytes.
        let rows = if row_bytes.is_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT) { height } else { 1 };
        self.begin_frame(gpu);
        self.timed(gpu, name, |encoder, _| {
            for y in (0..height).step_by(rows as usize) {
                let mut source = from.raw.as_image_copy();
                source.origin.y = y;
                let layout = wgpu::TexelCopyBufferLayout {
                    offset: u64::from(y) * u64::from(row_bytes),
                    bytes_per_row: (rows > 1).then_some(row_bytes),
                    rows_per_image: None,
                };
                let target = wgpu::TexelCopyBufferInfo { buffer: to.raw(), layout };
                let size = wgpu::Extent3d { width, height: rows, depth_or_array_layers: 1 };
                encoder.copy_texture_to_buffer(source, target, size);
            }
        });
    }

    /// Sets the first `count` elements of `buffer` to zero, timed as `name`.
    pub fn zero<R: Role>(&mut self, gpu: &Gpu, name: &str, buffer: &Buffer<R>, count: usize) {
        let bytes = (count * size_of::<R::Element>()).next_multiple_of(4) as u64;
        self.begin_frame(gpu);
        self.timed(gpu, name, |encoder, _| encoder.clear_buffer(buffer.raw(), 0, Some(bytes)));
    }

    fn begin_frame(&mut self, gpu: &Gpu) {
        if std::mem::take(&mut self.is_new_frame)
            && let Some(tallies) = &mut self.tallies
        {
            let mut encoder =
                self.encoder.take().unwrap_or_else(|| gpu.device.create_command_encoder(&Default::default()));
            tallies.restart(&mut encoder);
            self.encoder = Some(encoder);
        }
    }

    fn timed(
        &mut self,
        gpu: &Gpu,
        name: &str,
        record: impl FnOnce(&mut wgpu::CommandEncoder, Option<&wgpu_profiler::GpuProfilerQuery>),
    ) {
        let name = &*match self.view {
            "" => Cow::Borrowed(name),
            view => Cow::Owned(format!("{view}{name}")),
        };
        let mut encoder =
            self.encoder.take().unwrap_or_else(|| gpu.device.create_command_encoder(&Default::default()));
        let query = self.profiler.as_ref().map(|p| p.begin_pass_query(name, &mut encoder));
        record(&mut encoder, query.as_ref());
        if let (Some(profiler), Some(query)) = (&self.profiler, query) {
            profiler.end_query(&mut encoder, query);
        }
        self.encoder = Some(encoder);
        if self.timing == Timing::Isolated {
            self.run_isolated(gpu, name);
        }
    }

    /// Submits what is recorded, waits, and notes the clocks.
    fn run_isolated(&mut self, gpu: &Gpu, name: &str) {
        let (wall, cpu) = (Instant::now(), process_cpu_ms());
        let _ = self.flush(gpu);
        // An error is kept by the device and comes out of `submit`.
        let _ = gpu.device.poll(wgpu::PollType::wait_indefinitely());
        self.spans.push(SpanRow::Isolated, name, wall);
        let wall_ms = wall.elapsed().as_secs_f64() * 1e3;
        let cpu_ms = process_cpu_ms() - cpu;
        add_cost(&mut self.isolated, name, |cost| {
            *cost.wall_ms.get_or_insert(0.0) += wall_ms;
            *cost.cpu_ms.get_or_insert(0.0) += cpu_ms;
        });
    }

    fn flush(&mut self, gpu: &Gpu) -> Submitted {
        Submitted(self.encoder.take().map(|encoder| {
            gpu.write_buffer(GpuWork::UNIFORMS, &self.uniform_buffer, 0, &self.uniforms);
            gpu.submit(Some(encoder.finish()))
        }))
    }

    /// Hands the frame to the GPU without waiting for it.
    ///
    /// # Errors
    /// [`GpuError::Driver`] with the first error that the driver reported.
    pub fn submit(&mut self, gpu: &Gpu) -> Result<Submitted, GpuError> {
        let submitted = if let Some(profiler) = &mut self.profiler {
            let mut encoder =
                self.encoder.take().unwrap_or_else(|| gpu.device.create_command_encoder(&Default::default()));
            profiler.resolve_queries(&mut encoder);
            self.encoder = Some(encoder);
            let submitted = self.flush(gpu);
            profiler_end(self.profiler.as_mut());
            submitted
        } else {
            self.flush(gpu)
        };
        self.uniforms.clear();
        self.is_new_frame = true;
        gpu.take_error()?;
        Ok(submitted)
    }

    /// Cost of the oldest frame whose time stamps have arrived, one entry per pass name in the order run; empty when none
    /// has. Never waits.
    pub fn take_costs(&mut self, gpu: &Gpu) -> Vec<StageCost> {
        let mut costs = std::mem::take(&mut self.isolated);
        let period = gpu.queue.get_timestamp_period();
        if let Some(results) = self.profiler.as_mut().and_then(|p| p.process_finished_frame(period)) {
            let mut stamps = Vec::new();
            for GpuTimerQueryResult { label, time, .. } in results {
                let Some(time) = time else { continue };
                // A wrapped counter gives a negative or absurd range (examples-to-follow.md 9.7): no figure beats a wrong one.
                let ms = (time.end - time.start) * 1e3;
                if (0.0..1e6).contains(&ms) {
                    add_cost(&mut costs, &label, |cost| *cost.gpu_ms.get_or_insert(0.0) += ms);
                    stamps.push((label, time.start, time.end));
                }
            }
            self.spans.push_stamps(&stamps);
        }
        costs
    }
}

fn profiler_end(profiler: Option<&mut GpuProfiler>) {
    if let Some(Err(error)) = profiler.map(GpuProfiler::end_frame) {
        tracing::warn!("time stamps of this frame are lost: {error}");
    }
}

fn add_cost(costs: &mut Vec<StageCost>, name: &str, add: impl FnOnce(&mut StageCost)) {
    let index = costs.iter().position(|c| c.name == name).unwrap_or_else(|| {
        costs.push(StageCost { name: name.to_owned(), ..Default::default() });
        costs.len() - 1
    });
    add(&mut costs[index]);
}

/// User + system milliseconds of this process so far.
pub fn process_cpu_ms() -> f64 {
    let t = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    t.tv_sec as f64 * 1e3 + t.tv_nsec as f64 / 1e6
}
