//! Where the sun's light gets to, from a picture of scene and water as the sun sees them.

use bytemuck::{Pod, Zeroable};
use meniscus_gpu::role::{EyeDistance, Role, SceneDistance, Sunlight, Thickness, ViewNormal};
use meniscus_gpu::{
    Binding, CameraUniform, ComputePipeline, ComputePipelineDescriptor, Definition, Dispatch, Gpu, HostField,
    HostStruct, Image, Recorder, Shader, Texture, host_fields, shader,
};

use crate::{INCLUDES, ShadingError};

const SUNLIGHT: Shader = shader!("shading/sunlight");
/// Objects throw shadows on the water.
const OBJECTS: Definition = Definition { name: "OBJECTS", value: 1 };
const PHOTONS: Shader = shader!("shading/photons");
const CAUSTICS: Shader = shader!("shading/caustics");
/// Of the two runs of a Gaussian the second.
const COLUMNS: Definition = Definition { name: "COLUMNS", value: 1 };
/// How far caustics are blurred, spacings: enough to leave a ten-thousandth of a pattern that repeats every 1.4 of them, as rows
/// of particles do.
const CAUSTICS_SIGMA: f32 = 0.9;
/// And at least, pixels: single bundles of light leave gaps.
const LEAST_SIGMA_PX: f32 = 0.9;
/// And at most: what takes longer is not seen either.
const MOST_SIGMA_PX: f32 = 24.0;

/// Light that landed in a pixel of the sun's picture.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Landed {}

impl Role for Landed {
    type Element = u32;
    const NAME: &'static str = "Landed";
    const UNIT: &'static str = "1/4096 of a pixel's light";
    const EMPTY: u32 = 0;
}

/// How much brighter waves make the scene, in the sun's picture.
#[derive(Clone, Copy, Debug)]
pub enum Caustics {}

impl Role for Caustics {
    type Element = f32;
    const NAME: &'static str = "Caustics";
    const UNIT: &'static str = "irradiance / irradiance without waves";
    const EMPTY: f32 = 1.0;
}

/// The opaque scene as the sun sees it.
#[derive(Clone, Copy, Debug)]
pub struct SunView<'a> {
    /// A parallel projection along the sun's rays.
    pub camera: &'a CameraUniform,
    /// Distance, of the camera's size.
    pub scene_distance: &'a Texture<SceneDistance>,
}

/// The water as the sun sees it; all images have the size of the [`SunView`]'s camera.
#[derive(Clone, Copy, Debug)]
pub struct SunWater<'a> {
    /// Smoothed surface.
    pub distance: &'a Texture<EyeDistance>,
    /// Length of water along the sun's rays, up to the opaque scene.
    pub thickness: &'a Texture<Thickness>,
    /// From [`CausticsPass`], or 1 everywhere.
    pub caustics: &'a Image<Caustics>,
}

impl SunView<'_> {
    /// What `meniscus::sun_view` declares.
    pub(crate) fn bindings(&self, recorder: &mut Recorder) -> [(&'static str, Binding); 2] {
        [("sun_camera", recorder.uniform(self.camera)), ("sun_scene_distance", self.scene_distance.bind())]
    }
}

/// Finds what sunlight arrives where the picture shows scene or water.
#[derive(Debug)]
pub struct SunlightPass {
    /// With water and the floor only, and with objects.
    pipelines: [ComputePipeline; 2],
}

impl SunlightPass {
    /// Pixels per side of a block that shares one value.
    pub const BLOCK_PX: u32 = 2;

    /// Compiles the pass.
    ///
    /// # Errors
    /// [`ShadingError::Gpu`] when the shader does not compile.
    pub fn new(gpu: &Gpu) -> Result<Self, ShadingError> {
        Ok(Self { pipelines: [compile(gpu, SUNLIGHT, &[])?, compile(gpu, SUNLIGHT, &[OBJECTS])?] })
    }

    /// Size of the [`Sunlight`] image for a picture of `size` pixels.
    pub fn size_blocks(size: [u32; 2]) -> [u32; 2] {
        size.map(|pixels| pixels.div_ceil(Self::BLOCK_PX))
    }

    /// Records `shading.sunlight`; `has_objects`: whether anything but the floor may throw a shadow on the water. `distance` and `scene_distance` have the camera's size, `output` has [`Self::size_blocks`]
    /// of it.
    #[expect(clippy::too_many_arguments, reason = "each is a different image or a different space")]
    pub fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        camera: &CameraUniform,
        sun: &SunView<'_>,
        water: &SunWater<'_>,
        distance: &Texture<EyeDistance>,
        scene_distance: &Texture<SceneDistance>,
        has_objects: bool,
        output: &Texture<Sunlight>,
    ) {
        let pipeline = &self.pipelines[usize::from(has_objects)];
        let mut bindings = vec![
            ("camera", recorder.uniform(camera)),
            ("distances", distance.bind()),
            ("scene_distance", scene_distance.bind()),
            ("sun_distances", water.distance.bind()),
            ("sun_thicknesses", water.thickness.bind()),
            ("caustics", water.caustics.bind()),
            ("sunlight", output.bind()),
        ];
        bindings.extend(sun.bindings(recorder));
        bindings.retain(|(name, _)| pipeline.binds(name));
        let size = Dispatch::Pixels(output.size());
        recorder.compute(gpu, "shading.sunlight", pipeline, &bindings, size);
    }
}

/// WGSL: `Caustics` in `shaders/shading/caustics.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
struct CausticsUniform {
    strength: f32,
    sigma_px: f32,
    pad_a: f32,
    pad_b: f32,
}

impl HostStruct for CausticsUniform {
    const WGSL_NAME: &'static str = "Caustics";
    const FIELDS: &'static [HostField] = host_fields!(CausticsUniform { strength, sigma_px, pad_a, pad_b });
}

/// What [`CausticsPass`] makes caustics of.
#[derive(Clone, Copy, Debug)]
pub struct Waves<'a> {
    /// Surface of the water as the sun sees it.
    pub distance: &'a Texture<EyeDistance>,
    /// Its normals.
    pub normal: &'a Texture<ViewNormal>,
    /// Of the particles, world units: nothing finer is known.
    pub spacing_world: f32,
    /// How much of what is found, 0 to 1.
    pub strength: f32,
}

/// What [`CausticsPass`] writes on the way.
#[derive(Debug)]
pub struct CausticsScratch {
    landed: Image<Landed>,
    rows: Image<Caustics>,
}

impl CausticsScratch {
    /// For pictures of the sun of `size` pixels.
    ///
    /// # Errors
    /// [`ShadingError::Gpu`] when there is no memory for it.
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, ShadingError> {
        Ok(Self { landed: Image::new(gpu, size)?, rows: Image::new(gpu, size)? })
    }
}

/// Finds how the waves gather and scatter the sun's light on the scene (Shah, Konttinen & Pattanaik 2007).
#[derive(Debug)]
pub struct CausticsPass {
    photons: ComputePipeline,
    /// Along rows and columns.
    blur: [ComputePipeline; 2],
}

impl CausticsPass {
    /// Compiles the passes.
    ///
    /// # Errors
    /// [`ShadingError::Gpu`] when a shader does not compile.
    pub fn new(gpu: &Gpu) -> Result<Self, ShadingError> {
        let blur = [compile(gpu, CAUSTICS, &[])?, compile(gpu, CAUSTICS, &[COLUMNS])?];
        Ok(Self { photons: compile(gpu, PHOTONS, &[])?, blur })
    }

    /// Records `shading.photons`, and `shading.caustics` twice, into `output`. All images have the size of `sun`'s camera.
    pub fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        sun: &SunView<'_>,
        waves: &Waves<'_>,
        scratch: &CausticsScratch,
        output: &Image<Caustics>,
    ) {
        let CausticsScratch { landed, rows } = scratch;
        recorder.clear(gpu, "shading.photons", landed.buffer(), landed.buffer().len());
        let mut bindings = vec![
            ("distances", waves.distance.bind()),
            ("normals", waves.normal.bind()),
            ("landed", landed.bind()),
        ];
        bindings.extend(sun.bindings(recorder));
        let size = Dispatch::Pixels(output.size());
        recorder.compute(gpu, "shading.photons", &self.photons, &bindings, size);
        let sigma_px = CAUSTICS_SIGMA * waves.spacing_world * sun.camera.px_per_world_at_one;
        let uniform = CausticsUniform {
            strength: waves.strength,
            sigma_px: sigma_px.clamp(LEAST_SIGMA_PX, MOST_SIGMA_PX),
            pad_a: 0.0,
            pad_b: 0.0,
        };
        let images = [("landed", landed.bind()), ("rows", rows.bind()), ("caustics", output.bind())];
        for blur in &self.blur {
            let mut bindings = vec![
                ("sun_camera", recorder.uniform(sun.camera)),
                ("parameters", recorder.uniform(&uniform)),
            ];
            bindings.extend(images.iter().filter(|(name, _)| blur.binds(name)).cloned());
            recorder.compute(gpu, "shading.caustics", blur, &bindings, size);
        }
    }
}

fn compile(gpu: &Gpu, shader: Shader, definitions: &[Definition]) -> Result<ComputePipeline, ShadingError> {
    Ok(gpu.compute_pipeline(&ComputePipelineDescriptor {
        includes: INCLUDES,
        definitions,
        ..ComputePipelineDescriptor::new(shader)
    })?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uniform_matches_its_shader() {
        CausticsUniform::check_layout(&CAUSTICS, &[]).unwrap();
        assert_eq!(SunlightPass::size_blocks([1, 9]), [1, 5]);
        assert_eq!(Sunlight::pack(0.0, 1.0, 1.0), Sunlight::UNCHANGED);
        assert_eq!(Sunlight::unpack(Sunlight::UNCHANGED), [0.0, 1.0, 1.0]);
    }
}
