use meniscus_gpu::role::{
    EyeDistance, Radiance, SceneColor, SceneDistance, SurfaceColor, Thickness, ViewNormal,
};
use meniscus_gpu::{CameraUniform, Gpu, Image, Recorder, Texture};

use crate::twin::TwinInput;
use crate::{ShadingError, SunPath, Surroundings};

/// A model's parameters as JSON: what flags, files and panels deal in.
pub type Parameters = serde_json::Map<String, serde_json::Value>;

/// Lengths of the data that automatic parameters are scaled by; fixed for a whole series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaterScale {
    /// A representative depth of the water, e.g. its vertical extent, world units.
    pub depth_world: f32,
    /// Physical spacing of the particles, world units.
    pub spacing_world: f32,
    /// Metres per world unit; 1 unless the user says otherwise, since files do not state it.
    pub metres_per_world: f32,
}

/// What a lighting model reads. All images but `sun_path` and an empty `surface_color` have the camera's size.
#[derive(Clone, Copy, Debug)]
pub struct LightingInputs<'a> {
    /// The camera that everything was drawn with.
    pub camera: &'a CameraUniform,
    /// Sun, sky and floor.
    pub surroundings: &'a Surroundings,
    /// Lengths of the data.
    pub scale: WaterScale,
    /// Smoothed water surface.
    pub distance: &'a Image<EyeDistance>,
    /// Length of water along the view ray, up to the opaque scene.
    pub thickness: &'a Image<Thickness>,
    /// Normals of the smoothed surface.
    pub normal: &'a Image<ViewNormal>,
    /// Colour that an attribute gives the water; a single pixel of alpha 0 where nothing is coloured, so that shaders read
    /// `surface_colors[min(index, arrayLength(&surface_colors) - 1u)]`.
    pub surface_color: &'a Image<SurfaceColor>,
    /// The opaque scene; alpha 0 where there is only sky.
    pub scene_color: &'a Texture<SceneColor>,
    /// Its distance.
    pub scene_distance: &'a Texture<SceneDistance>,
    /// Length of water between scene and sun, from [`WaterShadow`](crate::WaterShadow); zeros for no shadow.
    pub sun_path: &'a Image<SunPath>,
}

/// A way to shade water, with its parameters: a plain value without GPU resources.
pub trait LightingModel: Send + Sync {
    /// Name in the registry, in flags and in reports.
    fn name(&self) -> &'static str;

    /// JSON schema of the parameters, with descriptions and ranges.
    fn schema(&self) -> schemars::Schema;

    /// The parameters, all of them.
    fn parameters(&self) -> Parameters;

    /// Compiles the model for `gpu`; once per program and model.
    ///
    /// # Errors
    /// [`ShadingError::Gpu`] when the shader does not compile.
    fn compile(&self, gpu: &Gpu) -> Result<Box<dyn LightingPass>, ShadingError>;

    /// The same formula on the CPU: radiance and coverage of one pixel. The specification of the pass, and what it is tested
    /// against.
    fn twin(&self, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4];
}

/// A compiled lighting model.
pub trait LightingPass: Send + Sync {
    /// Replaces the parameters; what is left out gets its default.
    ///
    /// # Errors
    /// Unknown names, wrong types, values out of range; the old parameters then stay.
    fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), ShadingError>;

    /// Writes linear radiance for every pixel: water over scene where there is water, the scene elsewhere. Alpha is the
    /// coverage by water or objects.
    fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        inputs: &LightingInputs<'_>,
        output: &Image<Radiance>,
    );
}
