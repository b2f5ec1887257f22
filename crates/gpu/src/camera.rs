use bytemuck::{Pod, Zeroable};
use glam::Mat4;
use meniscus_core::{Camera, Frustum};

use crate::{HostField, HostStruct};

/// The camera as every pass sees it; WGSL: `meniscus::camera::Camera` in `shaders/common/camera.inc.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct CameraUniform {
    /// Rigid transform into view space.
    pub view_from_world: [[f32; 4]; 4],
    /// Its inverse.
    pub world_from_view: [[f32; 4]; 4],
    /// Tangents of the half angles (perspective) or half sizes in world units (parallel).
    pub half_extent: [f32; 2],
    /// Picture size in pixels.
    pub size_px: [u32; 2],
    /// 1 for parallel projection, else 0.
    pub orthographic: u32,
    /// Nearest distance drawn, world units.
    pub near_world: f32,
    /// Pixels per world unit at distance 1 (perspective) or at any distance (parallel).
    pub px_per_world_at_one: f32,
    /// Pad to 16 bytes.
    pub pad: f32,
}

impl CameraUniform {
    /// `camera` for a picture of `size` = `[width, height]` pixels.
    pub fn new(camera: &Camera, size: [u32; 2]) -> Self {
        let view_from_world = camera.view_from_world();
        Self {
            view_from_world: view_from_world.to_cols_array_2d(),
            world_from_view: view_from_world.inverse().to_cols_array_2d(),
            half_extent: camera.half_extent(size).to_array(),
            size_px: size,
            orthographic: camera.is_orthographic().into(),
            near_world: camera.near,
            px_per_world_at_one: camera.px_per_world(size, 1.0),
            pad: 0.0,
        }
    }

    /// What the camera can see.
    pub fn frustum(&self) -> Frustum {
        let world_from_view = Mat4::from_cols_array_2d(&self.world_from_view);
        Frustum::new(world_from_view, self.half_extent.into(), self.orthographic != 0, self.near_world)
    }
}

impl HostStruct for CameraUniform {
    const WGSL_NAME: &'static str = "Camera";
    const FIELDS: &'static [HostField] = crate::host_fields!(CameraUniform {
        view_from_world,
        world_from_view,
        half_extent,
        size_px,
        orthographic,
        near_world,
        px_per_world_at_one,
        pad,
    });
}
