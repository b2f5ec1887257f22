use meniscus_core::Aabb;
use meniscus_gpu::role::{
    EyeDistance, Radiance, SceneColor, SceneDistance, Sunlight, SurfaceColor, Thickness, ViewNormal,
};
use meniscus_gpu::{Binding, CameraUniform, Covered, Gpu, Recorder, Texture};

use crate::twin::TwinInput;
use crate::{EnvironmentMap, ObjectBounds, ShadingError, Surroundings};

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

impl WaterScale {
    /// 1 / the depth that optical depths act over, which is `given` or else the representative one, 1 / world units; 0 for one
    /// without meaning.
    pub fn per_depth(&self, given: Option<f32>) -> f32 {
        let depth = given.unwrap_or(self.depth_world);
        let usable = depth.is_normal() && depth > 0.0;
        if usable { depth.recip() } else { 0.0 }
    }

    /// The spacing, 0 for one without meaning.
    pub fn usable_spacing(&self) -> f32 {
        if self.spacing_world.is_finite() { self.spacing_world.max(0.0) } else { 0.0 }
    }

    /// Extinction of what light does not get through: a spacing of it is dark. 1 / world units.
    pub fn opaque_extinction(&self) -> f32 {
        3.0 * Self { depth_world: self.usable_spacing(), ..*self }.per_depth(None)
    }
}

/// What a lighting model reads. All images but `sunlight` and an empty `surface_color` have the camera's size.
#[derive(Clone, Copy, Debug)]
pub struct LightingInputs<'a> {
    /// The camera that everything was drawn with.
    pub camera: &'a CameraUniform,
    /// Sun, sky and floor.
    pub surroundings: &'a Surroundings,
    /// The picture of the surroundings, if there is one.
    pub environment: &'a EnvironmentMap,
    /// Box around everything opaque but the floor, world units; `None` where there is nothing.
    pub objects: Option<Aabb>,
    /// Lengths of the data.
    pub scale: WaterScale,
    /// The pixels that may show water, as `shaders/common/covered.inc.wgsl` has them.
    pub covered: &'a Covered,
    /// Smoothed water surface.
    pub distance: &'a Texture<EyeDistance>,
    /// Length of water along the view ray, up to the opaque scene.
    pub thickness: &'a Texture<Thickness>,
    /// Normals of the smoothed surface.
    pub normal: &'a Texture<ViewNormal>,
    /// Colour that an attribute gives the water; a single pixel of alpha 0 where nothing is coloured:
    /// shaders ask `meniscus::lighting_inputs::attribute_color`.
    pub surface_color: &'a Texture<SurfaceColor>,
    /// The opaque scene; alpha 0 where there is only sky.
    pub scene_color: &'a Texture<SceneColor>,
    /// Its distance.
    pub scene_distance: &'a Texture<SceneDistance>,
    /// What becomes of the sun's light on its way to scene and water, from [`SunlightPass`](crate::SunlightPass), or a single pixel
    /// of [`Sunlight::UNCHANGED`] where nothing throws a shadow.
    pub sunlight: &'a Texture<Sunlight>,
    /// Whether something throws one.
    pub has_sunlight: bool,
}

impl LightingInputs<'_> {
    /// Everything under its name in `meniscus::lighting_inputs`, for a pass of this frame, but for [`Self::covered`].
    pub fn bindings(&self, recorder: &mut Recorder) -> Vec<(&'static str, Binding)> {
        let mut bindings = vec![
            ("camera", recorder.uniform(self.camera)),
            ("surroundings", recorder.uniform(self.surroundings)),
            ("environment_texels", self.environment.texels().bind()),
            ("distances", self.distance.bind()),
            ("thicknesses", self.thickness.bind()),
            ("normals", self.normal.bind()),
            ("surface_colors", self.surface_color.bind()),
            ("scene_color", self.scene_color.bind()),
            ("scene_distance", self.scene_distance.bind()),
            ("sunlight", self.sunlight.bind()),
        ];
        let objects = self.objects.map(ObjectBounds::from);
        bindings.extend(objects.map(|objects| ("objects", recorder.uniform(&objects))));
        bindings
    }
}

/// What a lighting model keeps to beside what every model does; the conformance suite holds it to that.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Promises {
    /// Water as thin as nothing shows the scene: no hard edges.
    pub fades_with_thickness: bool,
    /// In surroundings of one radiance, which the scene has as well, no pixel is brighter than that.
    pub makes_no_light: bool,
    /// Calm water without absorption and scattering reflects by Fresnel's equations, and the rest of the light comes through.
    /// The model has the parameters `refractive_index`, `attenuation_scale` and `turbidity`.
    pub reflects_by_fresnel: bool,
    /// Light comes through the water by Beer-Lambert's law. The model has the parameters `attenuation_color`,
    /// `attenuation_depth` and `attenuation_scale`.
    pub absorbs_by_beer_lambert: bool,
    /// The colour that an attribute gives the water can be read off it.
    pub shows_attributes: bool,
}

/// A way to shade water, with its parameters: a plain value without GPU resources.
pub trait LightingModel: Send + Sync {
    /// Name in the registry, in flags and in reports.
    fn name(&self) -> &'static str;

    /// JSON schema of the parameters, with descriptions and ranges.
    fn schema(&self) -> schemars::Schema;

    /// The parameters, all of them.
    fn parameters(&self) -> Parameters;

    /// What the model keeps to; nothing in particular unless it says so.
    fn promises(&self) -> Promises {
        Promises::default()
    }

    /// Share of the light on it that a deep body gives back, 0 to 1, in the channel in which it is most; next to nothing for liquids
    /// that are seen through. White bodies ask for a shorter exposure.
    fn body_albedo(&self) -> f32 {
        0.0
    }

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

    /// Whether the pass looks at [`LightingInputs::sunlight`]; if not, it need not be found.
    fn uses_sunlight(&self) -> bool {
        true
    }

    /// Writes linear radiance for every pixel: water over scene where there is water, the scene elsewhere. Alpha is the
    /// coverage by water or objects.
    fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        inputs: &LightingInputs<'_>,
        output: &Texture<Radiance>,
    );

    /// What the water takes of light that comes up from inside of it, per channel, 1 / world unit: how deep bubbles show. Unless a
    /// model says otherwise, light does not get through its water.
    fn extinction(&self, scale: WaterScale) -> [f32; 3] {
        [scale.opaque_extinction(); 3]
    }
}
