//! Pipelines whose bindings and workgroup sizes come from the shader itself.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use crate::error::ErrorSink;
use crate::role::{CoverMask, SceneDepth};
use crate::{Definition, Gpu, GpuError, Shader, TextureRole, shader};

/// Slot of a named binding.
#[derive(Clone, Debug)]
pub(crate) struct Slot {
    pub(crate) name: String,
    pub(crate) index: u32,
}

/// Bind group layout of group 0 as reflected from a shader.
#[derive(Debug)]
pub(crate) struct Bindings {
    pub(crate) id: u64,
    pub(crate) slots: Vec<Slot>,
    pub(crate) layout: wgpu::BindGroupLayout,
}

/// What a compute pass is made of.
#[derive(Clone, Debug)]
pub struct ComputePipelineDescriptor<'a> {
    /// The pass; its entry point is `main`.
    pub shader: Shader,
    /// What it imports besides the common includes, dependencies first.
    pub includes: &'a [Shader],
    /// Preprocessor constants. `HARDWARE` is added on GPUs.
    pub definitions: &'a [Definition],
    /// Name of the counter that the pass adds its work to, of [`WorkCounters`](meniscus_core::WorkCounters) to be reported;
    /// its shader then calls `meniscus::tally::count`. Passes may share one.
    pub counts: Option<&'static str>,
}

impl ComputePipelineDescriptor<'_> {
    /// `shader` without further includes or definitions.
    pub fn new(shader: Shader) -> Self {
        Self { shader, includes: &[], definitions: &[], counts: None }
    }
}

/// A compute pass. The driver compiles it when it is first recorded: of the variants of a pass, few runs draw all.
#[derive(Debug)]
pub struct ComputePipeline {
    pub(crate) name: &'static str,
    composed: Arc<LazyComposed>,
    /// The variant that counts its work, and the name of the counter.
    counting: Option<(&'static str, Box<ComputePipeline>)>,
}

type LazyComposed = LazyLock<Option<Composed>, ComposePass>;
type ComposePass = Box<dyn FnOnce() -> Option<Composed> + Send + Sync>;
type CompilePass = Box<dyn FnOnce() -> wgpu::ComputePipeline + Send + Sync>;

/// A compute pass whose shader is known to be right.
#[derive(Debug)]
pub(crate) struct Composed {
    pub(crate) pipeline: LazyLock<wgpu::ComputePipeline, CompilePass>,
    pub(crate) bindings: Bindings,
    pub(crate) workgroup_size: [u32; 3],
}

impl Composed {
    fn new(
        device: &wgpu::Device,
        cache: Option<&wgpu::PipelineCache>,
        descriptor: &ComputePipelineDescriptor<'_>,
    ) -> Result<Self, GpuError> {
        let name = descriptor.shader.name;
        let module = shader::compose(&descriptor.shader, descriptor.includes, descriptor.definitions)?;
        let entry = module
            .entry_points
            .iter()
            .find(|e| e.stage == naga::ShaderStage::Compute && e.name == "main")
            .ok_or_else(|| GpuError::Shader {
                shader: name.into(),
                message: "has no compute entry point `main`".into(),
            })?;
        let workgroup_size = entry.workgroup_size;
        let bindings = reflect(device, name, &module, wgpu::ShaderStages::COMPUTE)?;
        let layout = pipeline_layout(device, name, &bindings);
        let (device, cache, shader) = (device.clone(), cache.cloned(), descriptor.shader);
        let compile = move || {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: Some(&layout),
                module: &shader::module(&device, &shader, module),
                entry_point: Some("main"),
                compilation_options: Default::default(),
                cache: cache.as_ref(),
            })
        };
        Ok(Self { pipeline: LazyLock::new(Box::new(compile) as CompilePass), bindings, workgroup_size })
    }
}

/// What passes are made with.
#[derive(Debug)]
pub(crate) struct PassMaker {
    pub(crate) device: wgpu::Device,
    pub(crate) cache: Option<wgpu::PipelineCache>,
    /// Whether passes are for a GPU rather than a software driver: `HARDWARE` of the shaders.
    pub(crate) is_hardware: bool,
    /// Where it is told what keeps a variant from composing.
    pub(crate) errors: ErrorSink,
    /// The variants that were asked for: stages that draw the same way share them, and so does what replaces a stage.
    variants: Mutex<HashMap<VariantKey, Arc<LazyComposed>>>,
}

/// The sources of a pass and its includes, by where they lie, and its definitions.
type VariantKey = (Vec<(usize, usize)>, Vec<Definition>);

impl PassMaker {
    pub(crate) fn new(
        device: wgpu::Device,
        cache: Option<wgpu::PipelineCache>,
        is_hardware: bool,
        errors: ErrorSink,
    ) -> Self {
        Self { device, cache, is_hardware, errors, variants: Mutex::default() }
    }

    /// `definitions`, and what the adapter adds.
    pub(crate) fn with_adapter(&self, definitions: &[Definition]) -> Vec<Definition> {
        let of_adapter = self.is_hardware.then_some(shader::HARDWARE);
        definitions.iter().copied().chain(of_adapter).collect()
    }

    /// Composes at once.
    pub(crate) fn pass(
        &self,
        descriptor: &ComputePipelineDescriptor<'_>,
    ) -> Result<ComputePipeline, GpuError> {
        let definitions = self.with_adapter(descriptor.definitions);
        let of_adapter = ComputePipelineDescriptor { definitions: &definitions, ..descriptor.clone() };
        let composed = Composed::new(&self.device, self.cache.as_ref(), &of_adapter)?;
        let compose = Box::new(move || Some(composed)) as ComposePass;
        let counting = self.counting(descriptor);
        Ok(ComputePipeline {
            name: descriptor.shader.name,
            composed: Arc::new(LazyLock::new(compose)),
            counting,
        })
    }

    /// Composes when the pass is first wanted.
    pub(crate) fn variant(&self, descriptor: &ComputePipelineDescriptor<'_>) -> ComputePipeline {
        let place = |shader: &Shader| (shader.source.as_ptr() as usize, shader.source.len());
        let sources = std::iter::once(&descriptor.shader).chain(descriptor.includes).map(place).collect();
        let definitions = self.with_adapter(descriptor.definitions);
        let mut variants = self.variants.lock().unwrap_or_else(PoisonError::into_inner);
        let composed = variants.entry((sources, definitions.clone())).or_insert_with(|| {
            let (device, cache, errors) = (self.device.clone(), self.cache.clone(), self.errors.clone());
            let (shader, includes) = (descriptor.shader, descriptor.includes.to_vec());
            let compose = move || {
                let descriptor = ComputePipelineDescriptor {
                    includes: &includes,
                    definitions: &definitions,
                    ..ComputePipelineDescriptor::new(shader)
                };
                let composed = Composed::new(&device, cache.as_ref(), &descriptor);
                composed.inspect_err(|error| errors.report(error.to_string())).ok()
            };
            Arc::new(LazyLock::new(Box::new(compose) as ComposePass))
        });
        let composed = Arc::clone(composed);
        drop(variants);
        ComputePipeline { name: descriptor.shader.name, composed, counting: self.counting(descriptor) }
    }

    /// Composes all variants that were asked for.
    pub(crate) fn compose_all(&self) {
        let variants: Vec<_> =
            self.variants.lock().unwrap_or_else(PoisonError::into_inner).values().cloned().collect();
        for variant in variants {
            LazyLock::force(&variant);
        }
    }

    fn counting(
        &self,
        descriptor: &ComputePipelineDescriptor<'_>,
    ) -> Option<(&'static str, Box<ComputePipeline>)> {
        let counter = descriptor.counts?;
        let definitions = [descriptor.definitions, &[shader::COUNT]].concat();
        let descriptor =
            ComputePipelineDescriptor { definitions: &definitions, counts: None, ..descriptor.clone() };
        Some((counter, Box::new(self.variant(&descriptor))))
    }
}

impl ComputePipeline {
    /// `None` where it does not compose, which [`Gpu::wait`] then tells.
    pub(crate) fn composed(&self) -> Option<&Composed> {
        LazyLock::force(&self.composed).as_ref()
    }

    /// The variant that counts and the name of its counter, where the pass has one.
    pub(crate) fn counting(&self) -> Option<(&Self, &'static str)> {
        self.counting.as_ref().map(|(counter, variant)| (&**variant, *counter))
    }

    /// Workgroup size as written in the shader; 0 where it does not compose.
    pub fn workgroup_size(&self) -> [u32; 3] {
        self.composed().map_or([0; 3], |composed| composed.workgroup_size)
    }

    /// Whether the shader uses a variable of this name that a binding is needed for: of those that an include declares, it
    /// has only the ones it imports.
    pub fn binds(&self, name: &str) -> bool {
        self.composed().is_some_and(|composed| composed.bindings.slots.iter().any(|slot| slot.name == name))
    }
}

/// What a raster pass is made of: `vertex` and `fragment` entry points in one shader.
pub struct RasterPipelineDescriptor<'a> {
    /// The pass.
    pub shader: Shader,
    /// What it imports besides the common includes, dependencies first.
    pub includes: &'a [Shader],
    /// Preprocessor constants. `HARDWARE` is added on GPUs.
    pub definitions: &'a [Definition],
    /// Vertex buffer layouts.
    pub vertex_buffers: &'a [wgpu::VertexBufferLayout<'a>],
    /// Formats of the colour targets, in order (from [`TextureRole::FORMAT`]).
    pub targets: &'a [wgpu::TextureFormat],
    /// The depth attachment.
    pub depth: DepthUse,
    /// What becomes of a target where several triangles cover a pixel.
    pub overlap: Overlap,
}

/// What a raster pass leaves in pixels that several of its triangles cover.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overlap {
    /// What was drawn last and passed the depth test.
    Last,
    /// The least of all numbers, what was there before among them; only where the adapter can ([`Gpu::keeps_least`]).
    Least,
}

impl Overlap {
    fn blend(self) -> Option<wgpu::BlendState> {
        let one = wgpu::BlendFactor::One;
        let least =
            wgpu::BlendComponent { src_factor: one, dst_factor: one, operation: wgpu::BlendOperation::Min };
        (self == Self::Least).then_some(wgpu::BlendState { color: least, alpha: least })
    }
}

/// What a raster pass does with its depth attachment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DepthUse {
    /// It has none.
    None,
    /// A [`SceneDepth`], emptied, tested and written, reversed z: greater wins.
    Scene,
    /// The mask of a [`Covered`](crate::Covered): its pixels get the depth that the shader gives, 1 for fluid, 0 for none.
    MarksCovered,
    /// The same mask: only pixels are drawn that show fluid.
    Covered,
}

impl DepthUse {
    fn state(self) -> Option<wgpu::DepthStencilState> {
        let (format, writes, compare) = match self {
            Self::None => return None,
            Self::Scene => (SceneDepth::FORMAT, true, wgpu::CompareFunction::GreaterEqual),
            Self::MarksCovered => (CoverMask::FORMAT, true, wgpu::CompareFunction::Always),
            // Pictures are drawn at a depth of one half.
            Self::Covered => (CoverMask::FORMAT, false, wgpu::CompareFunction::Less),
        };
        Some(wgpu::DepthStencilState {
            format,
            depth_write_enabled: Some(writes),
            depth_compare: Some(compare),
            stencil: Default::default(),
            bias: Default::default(),
        })
    }

    /// What is done with the attachment; `None` to read it only.
    pub(crate) fn operations(self) -> Option<wgpu::Operations<f32>> {
        let load = wgpu::LoadOp::Clear(0.0);
        (self != Self::Covered).then_some(wgpu::Operations { load, store: wgpu::StoreOp::Store })
    }
}

/// A compiled raster pass.
#[derive(Debug)]
pub struct RasterPipeline {
    pub(crate) name: &'static str,
    pub(crate) pipeline: wgpu::RenderPipeline,
    pub(crate) bindings: Bindings,
    pub(crate) depth: DepthUse,
}

/// A pass that fills textures, each pixel by itself. Software drivers draw it as a triangle: a number that a compute pass
/// stores costs them some 30 cycles a lane. GPUs compute it: those without displays have next to nothing that fills pixels. Which it is,
/// its shader tells by `HARDWARE`: with it, it has the entry point `main` and storage textures, else `vertex` and `fragment`.
#[derive(Debug)]
pub struct PicturePipeline {
    pub(crate) form: PictureForm,
    pub(crate) pixels: Pixels,
}

#[derive(Debug)]
pub(crate) enum PictureForm {
    /// With `HARDWARE`.
    Compute(ComputePipeline),
    /// Without.
    Raster(RasterPipeline),
}

/// The pixels that a [`PicturePipeline`] is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pixels {
    /// All of the picture.
    All,
    /// All, and it finds out which of them show fluid: computed, it fills the list of a [`Covered`](crate::Covered), bound as `covered`;
    /// drawn, it gives those a depth of 1 and others 0.
    Marked,
    /// Those that show fluid: computed, it walks through that list.
    Covered,
}

/// What a [`PicturePipeline`] is made of.
#[derive(Clone, Debug)]
pub struct PicturePipelineDescriptor<'a> {
    /// The pass.
    pub shader: Shader,
    /// What it imports besides the common includes, dependencies first.
    pub includes: &'a [Shader],
    /// Preprocessor constants. `HARDWARE` is added on GPUs.
    pub definitions: &'a [Definition],
    /// Formats of the textures, in order (from [`TextureRole::FORMAT`]).
    pub targets: &'a [wgpu::TextureFormat],
    /// Which pixels it is for.
    pub pixels: Pixels,
}

impl Gpu {
    /// Whether a [`PicturePipeline`] is computed here, not drawn.
    pub fn computes_pictures(&self) -> bool {
        self.passes.is_hardware
    }

    /// Compiles a pass that fills textures.
    ///
    /// # Errors
    /// [`GpuError::Shader`] when the shader does not compose or validate.
    pub fn picture_pipeline(
        &self,
        descriptor: &PicturePipelineDescriptor<'_>,
    ) -> Result<PicturePipeline, GpuError> {
        let &PicturePipelineDescriptor { shader, includes, definitions, targets, pixels } = descriptor;
        if self.computes_pictures() {
            let compute =
                ComputePipelineDescriptor { includes, definitions, ..ComputePipelineDescriptor::new(shader) };
            return Ok(PicturePipeline::computed(self.compute_pipeline(&compute)?, pixels));
        }
        let raster = RasterPipelineDescriptor {
            shader,
            includes,
            definitions,
            vertex_buffers: &[],
            targets,
            depth: match pixels {
                Pixels::All => DepthUse::None,
                Pixels::Marked => DepthUse::MarksCovered,
                Pixels::Covered => DepthUse::Covered,
            },
            overlap: Overlap::Last,
        };
        Ok(PicturePipeline { form: PictureForm::Raster(self.raster_pipeline(&raster)?), pixels })
    }

    /// Compiles a raster pass.
    ///
    /// # Errors
    /// [`GpuError::Shader`] when the shader does not compose or validate.
    pub fn raster_pipeline(
        &self,
        descriptor: &RasterPipelineDescriptor<'_>,
    ) -> Result<RasterPipeline, GpuError> {
        let name = descriptor.shader.name;
        let definitions = self.passes.with_adapter(descriptor.definitions);
        let module = shader::compose(&descriptor.shader, descriptor.includes, &definitions)?;
        let bindings = reflect(&self.device, name, &module, wgpu::ShaderStages::VERTEX_FRAGMENT)?;
        let layout = pipeline_layout(&self.device, name, &bindings);
        let module = shader::module(&self.device, &descriptor.shader, module);
        let targets: Vec<_> = descriptor
            .targets
            .iter()
            .map(|&format| {
                Some(wgpu::ColorTargetState { blend: descriptor.overlap.blend(), ..format.into() })
            })
            .collect();
        let vertex_buffers: Vec<_> = descriptor.vertex_buffers.iter().cloned().map(Some).collect();
        let pipeline = self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(name),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &vertex_buffers,
            },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fragment"),
                compilation_options: Default::default(),
                targets: &targets,
            }),
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: descriptor.depth.state(),
            multisample: Default::default(),
            multiview_mask: None,
            cache: self.pipeline_cache(),
        });
        Ok(RasterPipeline { name, pipeline, bindings, depth: descriptor.depth })
    }

    /// As [`Self::raster_pipeline`] while a frame is recorded, for a pass that few runs draw. Should it not compile, there is none and
    /// [`Self::wait`] tells why.
    pub fn late_raster_pipeline(&self, descriptor: &RasterPipelineDescriptor<'_>) -> Option<RasterPipeline> {
        let pipeline = self.raster_pipeline(descriptor);
        pipeline.inspect_err(|error| self.passes.errors.report(error.to_string())).ok()
    }
}

impl RasterPipeline {
    /// As [`ComputePipeline::binds`].
    pub fn binds(&self, name: &str) -> bool {
        self.bindings.slots.iter().any(|slot| slot.name == name)
    }
}

impl PicturePipeline {
    /// One that is computed, whatever the adapter; `HARDWARE` is defined in its shader.
    pub fn computed(pipeline: ComputePipeline, pixels: Pixels) -> Self {
        Self { form: PictureForm::Compute(pipeline), pixels }
    }

    /// As [`ComputePipeline::binds`].
    pub fn binds(&self, name: &str) -> bool {
        match &self.form {
            PictureForm::Compute(pipeline) => pipeline.binds(name),
            PictureForm::Raster(pipeline) => pipeline.binds(name),
        }
    }
}

fn pipeline_layout(device: &wgpu::Device, name: &str, bindings: &Bindings) -> wgpu::PipelineLayout {
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(name),
        bind_group_layouts: &[Some(&bindings.layout)],
        immediate_size: 0,
    })
}

/// The bind group layout that the shader's global variables of group 0 declare.
fn reflect(
    device: &wgpu::Device,
    shader: &'static str,
    module: &naga::Module,
    visibility: wgpu::ShaderStages,
) -> Result<Bindings, GpuError> {
    static NEXT_ID: AtomicU64 = AtomicU64::new(0);
    let fail = |message: String| GpuError::Shader { shader: shader.to_owned(), message };
    let mut slots = Vec::new();
    let mut entries = Vec::new();
    for (_, variable) in module.global_variables.iter() {
        let Some(binding) = &variable.binding else { continue };
        let name = variable.name.clone().unwrap_or_default();
        // Of a variable that an include declares, naga_oil makes the name its own.
        let name = name.split("X_naga_oil_mod_X").next().unwrap_or_default().to_owned();
        if binding.group != 0 {
            return Err(fail(format!(
                "binding {name} is in group {}, meniscus passes use group 0 only",
                binding.group
            )));
        }
        let ty = match (&variable.space, &module.types[variable.ty].inner) {
            (naga::AddressSpace::Uniform, _) => buffer_type(wgpu::BufferBindingType::Uniform),
            (naga::AddressSpace::Storage { access }, _) => buffer_type(wgpu::BufferBindingType::Storage {
                read_only: !access.contains(naga::StorageAccess::STORE),
            }),
            (_, naga::TypeInner::Image { dim: naga::ImageDimension::D2, arrayed: false, class }) => {
                texture_type(*class)
                    .ok_or_else(|| fail(format!("texture {name} is of the unsupported kind {class:?}")))?
            }
            (space, inner) => {
                return Err(fail(format!("binding {name} is of an unsupported kind: {space:?} {inner:?}")));
            }
        };
        slots.push(Slot { name, index: binding.binding });
        entries.push(wgpu::BindGroupLayoutEntry { binding: binding.binding, visibility, ty, count: None });
    }
    // Raster stages may not write storage from the vertex stage on every device; none of ours does.
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(shader),
        entries: &entries,
    });
    Ok(Bindings { id: NEXT_ID.fetch_add(1, Ordering::Relaxed), slots, layout })
}

/// Binding of a texture in two dimensions; `None` for kinds that no pass has.
fn texture_type(class: naga::ImageClass) -> Option<wgpu::BindingType> {
    let read = |sample_type| wgpu::BindingType::Texture {
        sample_type,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let written = |format| wgpu::BindingType::StorageTexture {
        access: wgpu::StorageTextureAccess::WriteOnly,
        format,
        view_dimension: wgpu::TextureViewDimension::D2,
    };
    Some(match class {
        naga::ImageClass::Sampled { kind: naga::ScalarKind::Float, multi: false } => {
            read(wgpu::TextureSampleType::Float { filterable: false })
        }
        naga::ImageClass::Sampled { kind: naga::ScalarKind::Uint, multi: false } => {
            read(wgpu::TextureSampleType::Uint)
        }
        naga::ImageClass::Depth { multi: false } => read(wgpu::TextureSampleType::Depth),
        naga::ImageClass::Storage { format, access: naga::StorageAccess::STORE } => match format {
            naga::StorageFormat::Rgba16Float => written(wgpu::TextureFormat::Rgba16Float),
            naga::StorageFormat::R32Float => written(wgpu::TextureFormat::R32Float),
            naga::StorageFormat::Rg32Uint => written(wgpu::TextureFormat::Rg32Uint),
            naga::StorageFormat::Rg32Float => written(wgpu::TextureFormat::Rg32Float),
            naga::StorageFormat::Rgba32Float => written(wgpu::TextureFormat::Rgba32Float),
            naga::StorageFormat::Rgba32Uint => written(wgpu::TextureFormat::Rgba32Uint),
            naga::StorageFormat::R32Uint => written(wgpu::TextureFormat::R32Uint),
            _ => return None,
        },
        _ => return None,
    })
}

fn buffer_type(ty: wgpu::BufferBindingType) -> wgpu::BindingType {
    wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::AdapterChoice;

    const PASS: Shader = Shader { name: "test/pass", source: "@compute @workgroup_size(1) fn main() {}" };

    #[test]
    fn who_asks_for_the_same_variant_shares_it() {
        let gpu = Gpu::new(&AdapterChoice::default()).expect("an adapter, at least mesa-vulkan-drivers");
        let variant = |names: &[&'static str]| {
            let definitions: Vec<_> = names.iter().map(|&name| Definition { name, value: 1 }).collect();
            let of = ComputePipelineDescriptor {
                definitions: &definitions,
                ..ComputePipelineDescriptor::new(PASS)
            };
            gpu.compute_variant(&of).composed
        };
        assert!(Arc::ptr_eq(&variant(&["A"]), &variant(&["A"])));
        assert!(!Arc::ptr_eq(&variant(&["A"]), &variant(&["A", "B"])));
        assert!(!Arc::ptr_eq(&variant(&["A"]), &variant(&[])));
    }
}
