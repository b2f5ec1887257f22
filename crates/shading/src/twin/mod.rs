//! CPU twins: the same functions as the shaders' in the same order, in `f32`, module by module
//! (`shaders/shading/<module>.inc.wgsl`). They are what the passes are tested against.

pub(crate) mod blinn_phong;
mod body;
pub mod brdf;
mod calm;
mod environment;
pub(crate) mod fluid;
mod foam;
pub(crate) mod granular;
mod medium;
mod neighbourhood;
pub(crate) mod opaque_liquid;
pub(crate) mod point_light;
mod reflected_objects;
mod reflection;
mod refraction;
mod scene_march;
mod shadow;
pub(crate) mod sky;
pub(crate) mod surroundings;
mod view;
pub(crate) mod vtk;
mod water;

pub use foam::foam;

use glam::Vec3;
use meniscus_gpu::CameraUniform;

use crate::{ObjectBounds, Surroundings, WaterScale};

/// What a lighting model's twin reads: whole images, row by row from the top left, all of the camera's size.
#[derive(Clone, Copy, Debug)]
pub struct TwinInput<'a> {
    /// The camera.
    pub camera: &'a CameraUniform,
    /// Sun, sky and floor.
    pub surroundings: &'a Surroundings,
    /// Texels of the picture of the surroundings, as [`EnvironmentMap`](crate::EnvironmentMap) packs them; empty for none.
    pub environment: &'a [[f32; 4]],
    /// Box around all objects of the scene, if there are any.
    pub objects: Option<ObjectBounds>,
    /// Lengths of the data.
    pub scale: WaterScale,
    /// Smoothed water surface along the view axis; `f32::MAX` = none.
    pub distance: &'a [f32],
    /// Length of water along the view ray.
    pub thickness: &'a [f32],
    /// Octahedral view-space normals.
    pub normal: &'a [u32],
    /// Colour that an attribute gives the water, or a single pixel of alpha 0 ([`Self::surface_color_at`]).
    pub surface_color: &'a [[f32; 4]],
    /// The opaque scene, linear radiance, as it is stored (rounded to half precision).
    pub scene_color: &'a [[f32; 4]],
    /// Distance of the opaque scene along the view axis; `f32::MAX` = sky.
    pub scene_distance: &'a [f32],
    /// What becomes of the sun's light, per block of pixels as [`Sunlight`](meniscus_gpu::role::Sunlight) has it, or a single value.
    pub sunlight: &'a [[u32; 2]],
}

impl TwinInput<'_> {
    /// What a mirror of GGX width `alpha` shows, seen from `position` (world).
    pub(crate) fn mirror_radiance(&self, position: Vec3, direction: Vec3, alpha: f32) -> Vec3 {
        surroundings::surroundings_radiance(
            self.surroundings,
            self.environment,
            position,
            direction,
            alpha.sqrt(),
        )
    }

    /// Colour that an attribute gives the water in a pixel; alpha 0 for none.
    pub fn surface_color_at(&self, index: usize) -> [f32; 4] {
        self.surface_color.get(index).or(self.surface_color.last()).copied().unwrap_or_default()
    }
}

/// WGSL's `mix` for vectors with one factor.
pub(crate) fn mix(a: Vec3, b: Vec3, t: f32) -> Vec3 {
    a * (1.0 - t) + b * t
}

/// WGSL's `smoothstep`.
pub(crate) fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
