//! GPU base of meniscus: choosing an adapter, typed buffers and images, the pass recorder, shader imports with layout
//! checks, and readback. Stages build on this crate and never touch an encoder or open a pass themselves.
//!
//! A resource carries its [`Role`] in its type, so that wiring a distance into a thickness slot does not compile. A pass
//! is recorded by [`Recorder::compute`], [`Recorder::raster`] or [`Recorder::picture`] only; all take a name and time themselves.

mod adapter;
mod camera;
pub mod covered;
mod device;
mod error;
mod layout;
mod page;
mod pipeline;
mod ranges;
mod readback;
mod recorder;
mod resource;
pub mod role;
mod shader;
mod span;
mod tally;
mod work;

pub use adapter::{AdapterChoice, AdapterSummary, INSTALL_HINT, list_adapters};
pub use camera::CameraUniform;
pub use covered::Covered;
pub use device::{Gpu, GpuMemory};
pub use error::GpuError;
pub use layout::{HostField, HostStruct};
pub use page::Page;
pub use pipeline::{
    ComputePipeline, ComputePipelineDescriptor, DepthUse, Overlap, PicturePipeline,
    PicturePipelineDescriptor, Pixels, RasterPipeline, RasterPipelineDescriptor,
};
pub use ranges::RangeList;
pub use recorder::{Binding, Dispatch, Recorder, Submitted, Timing, process_cpu_ms};
pub use resource::{Buffer, Image, Texture};
pub use role::{Role, TextureRole};
pub use shader::{COMMON, Definition, Shader, compose};
pub use span::{Span, SpanRow};
pub use work::GpuWork;

/// Re-exported so that stages agree on one version.
pub use wgpu;
