//! What surrounds the water: floor, walls, boxes, materials, sun and sky, cameras. Nothing here knows the GPU.
//!
//! A [`Scene`] is complete and in world space. It comes from [`Scene::around`] (the automatic scene) or from a
//! [`Description`], the TOML file in which everything is optional and which is completed by the same automatic choices.
//! Everything scales with the extent of the data: no length is assumed to be in metres.

mod absorption;
mod camera;
mod camera_path;
mod description;
mod environment;
mod error;
mod lens;
mod material;
mod mesh;
mod physical_sky;
mod scene;
mod terrain;
mod up_frame;

pub use absorption::{CLEAR_WATER_OPTICAL_DEPTH, PURE_WATER_PER_METRE};
pub use camera::{FOVY_RAD, NamedView, above_ground, automatic_camera};
pub use camera_path::{CameraKey, CameraPath, Clock, Curve};
pub use description::{
    BoxDescription, Description, EnvironmentDescription, FloorDescription, SkyDescription, SunDescription,
    TerrainDescription, WallsDescription,
};
pub use environment::Environment;
pub use error::SceneError;
pub use lens::Lens;
pub use material::{Material, Pattern};
pub use mesh::{Mesh, Sides};
pub use physical_sky::physical_sky;
pub use scene::{Floor, Object, Scene, Sky, Sun};
pub use terrain::Terrain;
pub use up_frame::UpFrame;
