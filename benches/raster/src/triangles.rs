use bench_ssfr_splat::{Spheres, Splats};
use meniscus_gpu::role::{NO_SURFACE, SceneDepth};
use meniscus_gpu::{
    CameraUniform, DepthUse, Gpu, RasterPipeline, RasterPipelineDescriptor, Recorder, Shader, Texture, shader,
};

const SHADER: Shader = Shader { name: "raster.triangles", source: include_str!("triangles.wgsl") };

/// The pass that draws spheres as triangles with a depth buffer.
pub(crate) struct TrianglePass(RasterPipeline);

impl TrianglePass {
    /// Its name.
    pub(crate) const NAME: &str = SHADER.name;

    pub(crate) fn new(gpu: &Gpu) -> Self {
        let pipeline = gpu.raster_pipeline(&RasterPipelineDescriptor {
            shader: SHADER,
            includes: &[shader!(include "ssfr/splat")],
            definitions: &[],
            vertex_buffers: &[],
            targets: &[],
            depth: DepthUse::Scene,
        });
        Self(pipeline.expect("the pass"))
    }

    /// Records the pass over the particles of `splats`.
    pub(crate) fn record(&self, recorder: &mut Recorder, gpu: &Gpu, splats: &Splats, target: &Target) {
        let mut pages = splats.pages();
        let (Some(particles), None) = (pages.next(), pages.next()) else {
            panic!("the triangles are drawn from one page")
        };
        let bindings = [
            ("camera", recorder.uniform(&target.camera)),
            ("radius_world", recorder.uniform(&target.radius_world)),
            ("page", particles.bind()),
        ];
        let depth = Some(target.depth.view());
        recorder.raster(gpu, Self::NAME, &self.0, &bindings, &[], depth, |pass| {
            pass.draw(0..3 * particles.len() as u32, 0..1);
        });
    }
}

/// What the nearest spheres are drawn to, and how they are seen.
pub(crate) struct Target {
    depth: Texture<SceneDepth>,
    camera: CameraUniform,
    radius_world: f32,
}

impl Target {
    pub(crate) fn new(gpu: &Gpu, spheres: &Spheres) -> Self {
        Self {
            depth: Texture::new(gpu, spheres.size).expect("a texture of the picture's size"),
            camera: CameraUniform::new(&spheres.camera, spheres.size),
            radius_world: spheres.radius_world,
        }
    }

    /// Distance along the view axis of every pixel, `NO_SURFACE` where there is no sphere.
    pub(crate) fn distances(&self, gpu: &Gpu) -> Vec<f32> {
        let depths = self.depth.read(gpu).expect("the depth buffer");
        // Reversed z: the shader leaves the near distance over the distance.
        let distance = |depth| if depth > 0.0 { self.camera.near_world / depth } else { NO_SURFACE };
        depths.into_iter().map(distance).collect()
    }
}
