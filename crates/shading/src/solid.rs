use meniscus_gpu::role::{EyeDistance, SceneColor, SceneDistance, SurfaceColor, TextureRole, ViewNormal};
use meniscus_gpu::{
    CameraUniform, Definition, DepthUse, Gpu, GpuError, Overlap, RasterPipeline, RasterPipelineDescriptor,
    Recorder, Shader, Texture, shader,
};
use meniscus_scene::Material;

use crate::pictured::Pictured;
use crate::{INCLUDES, MaterialUniform, SceneGeometry, ShadingError, SunView};

const SHADER: Shader = shader!("shading/solid");

/// The surface of particles that are drawn opaque.
#[derive(Clone, Copy, Debug)]
pub struct SolidSurface<'a> {
    /// Distance; nothing where there is none.
    pub distance: &'a Texture<EyeDistance>,
    /// Normals.
    pub normal: &'a Texture<ViewNormal>,
    /// Colour that an attribute gives it in place of the material's, or a single pixel of alpha 0 where none does.
    pub color: &'a Texture<SurfaceColor>,
    /// What it is made of; patterns are left out, for they would swim over moving particles.
    pub material: Material,
}

/// Draws opaque particle surfaces into the scene, so that water is shaded, clipped and refracted against them.
#[derive(Debug)]
pub struct SolidPass {
    pipeline: Pictured<RasterPipeline>,
}

impl SolidPass {
    /// Compiles the pass.
    ///
    /// # Errors
    /// [`ShadingError::Gpu`] when the shader does not compile.
    pub fn new(gpu: &Gpu) -> Result<Self, ShadingError> {
        let pipeline = Pictured::new(|definitions| compile(gpu, definitions))?;
        Ok(Self { pipeline })
    }

    /// Draws `surface` as `shading.solid` of `scene` over what `color` and `distance` hold; all images have the camera's size.
    /// With `shadows`, it lies in the shadow of objects.
    #[expect(clippy::too_many_arguments, reason = "two targets of one pass, each with its own role")]
    pub fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        camera: &CameraUniform,
        scene: &SceneGeometry,
        shadows: Option<&SunView<'_>>,
        surface: &SolidSurface<'_>,
        color: &Texture<SceneColor>,
        distance: &Texture<SceneDistance>,
    ) {
        let pipeline =
            self.pipeline.choose_shadowed(gpu, scene.surroundings(), shadows.is_some(), |definitions| {
                compile(gpu, definitions)
            });
        let mut bindings = vec![
            ("camera", recorder.uniform(camera)),
            ("surroundings", recorder.uniform(scene.surroundings())),
            ("environment_texels", scene.environment().texels().bind()),
            ("material", recorder.uniform(&MaterialUniform::from(&surface.material))),
            ("distances", surface.distance.bind()),
            ("normals", surface.normal.bind()),
            ("surface_colors", surface.color.bind()),
        ];
        bindings.extend(shadows.into_iter().flat_map(|sun| sun.bindings(recorder)));
        bindings.retain(|(name, _)| pipeline.binds(name));
        let targets = [(color.view(), None), (distance.view(), None)];
        recorder.raster(gpu, "shading.solid", pipeline, &bindings, &targets, None, |pass| {
            pass.draw(0..3, 0..1);
        });
    }
}

fn compile(gpu: &Gpu, definitions: &[Definition]) -> Result<RasterPipeline, GpuError> {
    gpu.raster_pipeline(&RasterPipelineDescriptor {
        shader: SHADER,
        includes: INCLUDES,
        definitions,
        vertex_buffers: &[],
        targets: &[SceneColor::FORMAT, SceneDistance::FORMAT],
        depth: DepthUse::None,
        overlap: Overlap::Last,
    })
}
