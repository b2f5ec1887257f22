use std::fmt::Debug;

use meniscus_gpu::role::{Radiance, TextureRole};
use meniscus_gpu::{
    Definition, Gpu, GpuError, HostStruct, PicturePipeline, PicturePipelineDescriptor, Pixels, Recorder,
    Shader, Texture, shader,
};
use schemars::JsonSchema;
use serde::{Serialize, de::DeserializeOwned};

use crate::calm::CalmPass;
use crate::pictured::Pictured;
use crate::twin::TwinInput;
use crate::{
    INCLUDES, LightingInputs, LightingModel, LightingPass, Liquid, Parameters, Promises, ShadingError,
    Surroundings, WaterScale, parameters,
};

const PIXELS: Shader = shader!("shading/pixels");
/// The pass over the scene.
const DRY: &str = "shading.dry";
/// The pass over the pixels that show water.
const WATER: Definition = Definition { name: "WATER", value: 1 };
/// Where there are objects, which hide what is behind them and are mirrored.
const OBJECTS: Definition = Definition { name: "OBJECTS", value: 1 };
/// Where an attribute colours the water.
const COLORED: Definition = Definition { name: "COLORED", value: 1 };
/// What `meniscus::calm` reads.
const CALM_NORMALS: &str = "calm_normals";
/// Where nothing throws a shadow.
const NO_SUNLIGHT: Definition = Definition { name: "NO_SUNLIGHT", value: 1 };

/// The parameters of a model that shades each pixel by itself, and what becomes of them: all that such a model has
/// of its own. [`PixelModel`] makes a [`LightingModel`] of it.
///
/// Every field is written to JSON under its own name; the ranges of the schema are the ones that are checked.
pub trait Formula:
    Clone + Debug + Default + PartialEq + Serialize + DeserializeOwned + JsonSchema + Send + Sync + 'static
{
    /// Name in the registry.
    const NAME: &'static str;
    /// The module `meniscus::model`: `water_radiance` of a pixel that shows water, and `scene_radiance` of one that does not. Its own
    /// uniform is the variable `model`; all others are those of `meniscus::lighting_inputs`. `OBJECTS` is defined where the scene is
    /// more than the floor; only then `meniscus::reflected_objects` can be used. A model that imports `meniscus::calm` has the normals that
    /// this reads made for it.
    const SHADER: Shader;
    /// Whether `scene_radiance` is the colour of the scene itself where nothing throws a shadow on it: it is copied then.
    const KEEPS_SCENE: bool = false;
    /// Name of the pass over the water in reports, `stage.pass`; what is done for the scene is `shading.dry`.
    const PASS: &'static str;
    /// The parameters as the GPU sees them.
    type Uniform: HostStruct;

    /// The parameters for a kind of liquid; a model without a parameter `preset` has one kind.
    fn of_liquid(_: Liquid) -> Self {
        Self::default()
    }

    /// What the model keeps to with these parameters; nothing in particular unless it says so.
    fn promises(&self) -> Promises {
        Promises::default()
    }

    /// As [`LightingModel::body_albedo`].
    fn body_albedo(&self) -> f32 {
        0.0
    }

    /// What is defined for [`Self::SHADER`] with some parameters and not with others, the same whenever it is: software drivers run
    /// through both sides of a choice that the shader makes.
    fn kind(&self) -> Option<Definition> {
        None
    }

    /// The uniform for water of this scale; a scale without meaning (zero, NaN) gives finite numbers, too.
    fn uniform(&self, scale: WaterScale, surroundings: &Surroundings) -> Self::Uniform;

    /// What the water takes of light that comes up from inside of it ([`LightingPass::extinction`]).
    fn extinction(&self, scale: WaterScale) -> [f32; 3] {
        [scale.opaque_extinction(); 3]
    }

    /// The pass on the CPU: radiance and coverage of one pixel.
    fn shade_pixel(uniform: &Self::Uniform, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4];
}

/// A lighting model that shades every pixel by a [`Formula`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PixelModel<F> {
    parameters: F,
}

impl<F: Formula> PixelModel<F> {
    /// Name in the registry.
    pub const NAME: &'static str = F::NAME;

    /// The model with these parameters.
    ///
    /// # Errors
    /// [`ShadingError::OutOfRange`] for the first value outside of its range in the schema.
    pub fn new(parameters: F) -> Result<Self, ShadingError> {
        parameters::check(&parameters)?;
        Ok(Self { parameters })
    }

    /// The model with parameters from JSON, of which any may be left out or go by VTK's name.
    ///
    /// # Errors
    /// Unknown names, wrong types, values out of range.
    pub fn from_parameters(parameters: &Parameters) -> Result<Self, ShadingError> {
        Ok(Self { parameters: parameters::read(parameters)? })
    }

    /// As [`Self::from_parameters`], in the form that a [`LightingRegistry`](crate::LightingRegistry) takes.
    ///
    /// # Errors
    /// As there.
    pub fn make(parameters: &Parameters) -> Result<Box<dyn LightingModel>, ShadingError> {
        Ok(Box::new(Self::from_parameters(parameters)?))
    }
}

impl<F: Formula> LightingModel for PixelModel<F> {
    fn name(&self) -> &'static str {
        F::NAME
    }

    fn schema(&self) -> schemars::Schema {
        schemars::schema_for!(F)
    }

    fn parameters(&self) -> Parameters {
        parameters::write(&self.parameters)
    }

    fn promises(&self) -> Promises {
        self.parameters.promises()
    }

    fn body_albedo(&self) -> f32 {
        self.parameters.body_albedo()
    }

    fn compile(&self, gpu: &Gpu) -> Result<Box<dyn LightingPass>, ShadingError> {
        let scene = Pictured::new(|definitions| compile_scene::<F>(gpu, definitions))?;
        let water = Pictured::new(|definitions| compile_water::<F>(gpu, definitions))?;
        let calm = water.plain().binds(CALM_NORMALS).then(|| CalmPass::new(gpu)).transpose()?;
        Ok(Box::new(PixelPass { model: self.clone(), scene, water, calm }))
    }

    fn twin(&self, input: &TwinInput<'_>, pixel: [u32; 2]) -> [f32; 4] {
        F::shade_pixel(&self.parameters.uniform(input.scale, input.surroundings), input, pixel)
    }
}

fn includes<F: Formula>() -> Vec<Shader> {
    INCLUDES.iter().copied().chain([F::SHADER]).collect()
}

fn compile_scene<F: Formula>(gpu: &Gpu, definitions: &[Definition]) -> Result<PicturePipeline, GpuError> {
    gpu.picture_pipeline(&PicturePipelineDescriptor {
        shader: PIXELS,
        includes: &includes::<F>(),
        definitions,
        targets: &[Radiance::FORMAT],
        pixels: Pixels::All,
    })
}

fn compile_water<F: Formula>(gpu: &Gpu, definitions: &[Definition]) -> Result<PicturePipeline, GpuError> {
    let definitions: Vec<Definition> = definitions.iter().copied().chain([WATER]).collect();
    gpu.picture_pipeline(&PicturePipelineDescriptor {
        shader: PIXELS,
        includes: &includes::<F>(),
        definitions: &definitions,
        targets: &[Radiance::FORMAT],
        pixels: Pixels::Covered,
    })
}

struct PixelPass<F> {
    model: PixelModel<F>,
    /// Over all pixels.
    scene: Pictured<PicturePipeline>,
    /// Over those that show water.
    water: Pictured<PicturePipeline>,
    /// For models that import `meniscus::calm`.
    calm: Option<CalmPass>,
}

impl<F: Formula> LightingPass for PixelPass<F> {
    fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), ShadingError> {
        self.model = PixelModel::from_parameters(parameters)?;
        Ok(())
    }

    fn uses_sunlight(&self) -> bool {
        self.scene.plain().binds("sunlight") || self.water.plain().binds("sunlight")
    }

    fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        inputs: &LightingInputs<'_>,
        output: &Texture<Radiance>,
    ) {
        let no_sunlight = (!inputs.has_sunlight).then_some(NO_SUNLIGHT);
        let kind = self.model.parameters.kind();
        let uniform = recorder.uniform(&self.model.parameters.uniform(inputs.scale, inputs.surroundings));
        let mut bindings = inputs.bindings(recorder);
        bindings.push(("model", uniform));
        match self.calm.as_ref().map(|calm| calm.record(gpu, recorder, inputs)).transpose() {
            Ok(normals) => bindings.extend(normals.map(|normals| (CALM_NORMALS, normals))),
            Err(error) => return gpu.report(&error),
        }
        if F::KEEPS_SCENE && !inputs.has_sunlight {
            recorder.copy(gpu, DRY, inputs.scene_color, output);
        } else {
            // Where no water is, neither what it mirrors nor what it hides counts.
            let scene = self.scene.choose_unpictured(gpu, &[no_sunlight, kind], |definitions| {
                compile_scene::<F>(gpu, definitions)
            });
            let mut bindings = bindings.clone();
            bindings.retain(|(name, _)| scene.binds(name));
            recorder.picture(gpu, DRY, scene, &bindings, &[("radiance", output.view())], None);
        }
        let size = inputs.camera.size_px;
        let objects = inputs.objects.is_some().then_some(OBJECTS);
        // A picture of a single pixel has one of them in any case.
        let colored = (inputs.surface_color.size() == size).then_some(COLORED);
        let kinds = [objects, no_sunlight, colored, kind];
        let water = self
            .water
            .choose(gpu, inputs.surroundings, &kinds, |definitions| compile_water::<F>(gpu, definitions));
        bindings.retain(|(name, _)| water.binds(name));
        let targets = [("radiance", output.view())];
        recorder.picture(gpu, F::PASS, water, &bindings, &targets, Some(inputs.covered));
    }

    fn extinction(&self, scale: WaterScale) -> [f32; 3] {
        self.model.parameters.extinction(scale)
    }
}
