//! The one crate that knows all stages: settings, registry, the world around the water, and the frame loop.
//!
//! ```text
//! SetFrame --Preparer--> PreparedFrame --Renderer--> Picture
//!   io       reader        chunks         GPU         pixels + report
//!            threads
//! ```

mod colors;
mod counters;
mod develop;
mod drawn;
mod error;
mod exposure;
mod foam;
mod identity;
mod images;
mod layers;
mod lod_view;
mod measure;
mod metering;
mod opaque_sets;
mod prepare;
mod registry;
mod renderer;
mod settings;
mod shapes;
mod sun_view;
mod upload;
mod world;

pub use colors::ColorSettings;
pub use error::PipelineError;
pub use exposure::Exposure;
pub use foam::FoamSettings;
pub use layers::Layer;
pub use lod_view::LodView;
pub use meniscus_compositor::Meter;
pub use meniscus_lod::{
    LodParams, Mode as LodMode, Policy as LodPolicy, RateGovernor, Refinement, SetStoreStats,
};
pub use meniscus_shading::ShadingError;
pub use meniscus_ssfr::SsfrError;
pub use prepare::{PreparedFrame, PreparedSet, Preparer};
pub use registry::Registry;
pub use renderer::{Picture, Renderer};
pub use settings::{SceneSettings, Settings, SettingsError};
pub use upload::UploadAhead;
pub use world::World;
