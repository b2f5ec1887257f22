//! The opaque scene pass: sky, floor and objects with their distance.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use meniscus_core::Aabb;
use meniscus_gpu::role::{Role, SceneColor, SceneDepth, SceneDistance, TextureRole};
use meniscus_gpu::{
    Buffer, CameraUniform, Definition, DepthUse, Gpu, GpuError, HostField, HostStruct, Overlap,
    PicturePipeline, PicturePipelineDescriptor, Pixels, RasterPipeline, RasterPipelineDescriptor, Recorder,
    Shader, Texture, host_fields, shader,
};
use meniscus_scene::{Scene, Sides};

use crate::pictured::{Pictured, SHADOWED};
use crate::{EnvironmentMap, INCLUDES, MaterialUniform, ShadingError, SunView, Surroundings};

pub(crate) const BACKGROUND: Shader = shader!("shading/background");
const FLOORLESS: Definition = Definition { name: "FLOORLESS", value: 1 };
const OBJECTS: Shader = shader!("shading/objects");

/// A vertex of an object; WGSL: `SceneVertex` in `shaders/shading/objects.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
struct SceneVertex {
    position_world: [f32; 3],
    material: u32,
    normal_world: [f32; 3],
    front_only: u32,
}

impl HostStruct for SceneVertex {
    const WGSL_NAME: &'static str = "SceneVertex";
    const FIELDS: &'static [HostField] =
        host_fields!(SceneVertex { position_world, material, normal_world, front_only });
}

#[derive(Debug)]
enum Vertices {}

impl Role for Vertices {
    type Element = SceneVertex;
    const NAME: &'static str = "SceneVertices";
    const UNIT: &'static str = "world";
    const EMPTY: SceneVertex =
        SceneVertex { position_world: [0.0; 3], material: 0, normal_world: [0.0; 3], front_only: 0 };
}

#[derive(Debug)]
enum Triangles {}

impl Role for Triangles {
    type Element = u32;
    const NAME: &'static str = "SceneTriangles";
    const UNIT: &'static str = "vertex index";
    const EMPTY: u32 = 0;
}

#[derive(Debug)]
enum Materials {}

impl Role for Materials {
    type Element = MaterialUniform;
    const NAME: &'static str = "SceneMaterials";
    const UNIT: &'static str = "linear Rec. 709";
    const EMPTY: MaterialUniform = MaterialUniform::GREY;
}

/// The objects of a scene on the GPU.
#[derive(Debug)]
pub struct SceneGeometry {
    vertices: Buffer<Vertices>,
    triangles: Buffer<Triangles>,
    materials: Buffer<Materials>,
    surroundings: Surroundings,
    environment: EnvironmentMap,
    runs: Vec<Run>,
    objects: Aabb,
}

/// Triangles of a run: few enough to leave out much of a terrain that is not in view, and enough to be worth the question.
const RUN_TRIANGLES: usize = 8192;

/// Triangles that are drawn together, or not at all.
#[derive(Debug)]
struct Run {
    /// Of `triangles`.
    indices: Range<u32>,
    /// World.
    bounds: Aabb,
}

/// Fewer are filled up by a triangle without size: given three vertices in all, lavapipe of Mesa 22.3.6 on processors without AVX (vectors of
/// four) writes a fourth one and corrupts the heap.
const FEWEST_INDICES: usize = 6;

impl SceneGeometry {
    /// Uploads `scene`.
    ///
    /// # Errors
    /// [`ShadingError::Gpu`] when the objects exceed the device's limits.
    pub fn new(gpu: &Gpu, scene: &Scene) -> Result<Self, ShadingError> {
        let mut bounds = Aabb::EMPTY;
        let (mut vertices, mut triangles, mut materials) = (Vec::new(), Vec::new(), Vec::new());
        let mut runs = Vec::new();
        for object in &scene.objects {
            bounds = bounds.union(Aabb::of_points(&object.mesh.positions));
            let first = vertices.len() as u32;
            let material = materials.len() as u32;
            materials.push((&object.material).into());
            let front_only = (object.sides == Sides::Front).into();
            vertices.extend(object.mesh.positions.iter().zip(&object.mesh.normals).map(
                |(&position_world, &normal_world)| SceneVertex {
                    position_world,
                    material,
                    normal_world,
                    front_only,
                },
            ));
            for run in object.mesh.indices.chunks(3 * RUN_TRIANGLES) {
                let start = triangles.len() as u32;
                triangles.extend(run.iter().map(|i| first + i));
                triangles.resize(triangles.len().max(start as usize + FEWEST_INDICES), first);
                let corner = |&i: &u32| Vec3::from(object.mesh.positions[i as usize]);
                let bounds = run.iter().map(corner).fold(Aabb::EMPTY, Aabb::with_point);
                runs.push(Run { indices: start..triangles.len() as u32, bounds });
            }
        }
        Ok(Self {
            vertices: Buffer::from_slice(gpu, &vertices)?,
            triangles: Buffer::from_slice(gpu, &triangles)?,
            materials: Buffer::from_slice(gpu, &materials)?,
            surroundings: Surroundings::new(scene),
            environment: EnvironmentMap::new(gpu, scene)?,
            runs,
            objects: bounds,
        })
    }

    /// Sun, sky and floor of the same scene, which lighting models need too.
    pub fn surroundings(&self) -> &Surroundings {
        &self.surroundings
    }

    /// Box around all objects, world; empty without any.
    pub fn objects(&self) -> Aabb {
        self.objects
    }

    /// The picture of the surroundings of the same scene, if it has one.
    pub fn environment(&self) -> &EnvironmentMap {
        &self.environment
    }
}

/// Draws sky, floor and objects.
#[derive(Debug)]
pub struct ScenePass {
    background: Pictured<PicturePipeline>,
    objects: Pictured<RasterPipeline>,
}

impl ScenePass {
    /// Compiles the passes.
    ///
    /// # Errors
    /// [`ShadingError::Gpu`] when a shader does not compile.
    pub fn new(gpu: &Gpu) -> Result<Self, ShadingError> {
        Ok(Self {
            background: Pictured::new(|definitions| compile_background(gpu, definitions))?,
            objects: Pictured::new(|definitions| compile_objects(gpu, definitions))?,
        })
    }

    /// Draws `scene` into targets of the camera's size: linear radiance (alpha 0 where there is only sky), distance along the
    /// view axis (`f32::MAX` for sky) and reversed depth of the objects (near / distance). Sky and floor are
    /// `shading.background`; where there are objects, `shading.objects` draws them over it.
    ///
    /// With `shadows`, objects throw shadows.
    #[expect(clippy::too_many_arguments, reason = "three targets of one picture, each with its own role")]
    pub fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        camera: &CameraUniform,
        scene: &SceneGeometry,
        shadows: Option<&SunView<'_>>,
        color: &Texture<SceneColor>,
        distance: &Texture<SceneDistance>,
        depth: &Texture<SceneDepth>,
    ) {
        let surroundings = scene.surroundings();
        let shadowed = shadows.is_some();
        let compile = |defined: &_| compile_background(gpu, defined);
        let kinds = match surroundings.has_floor {
            // Nothing that a shadow could fall on.
            0 => [None, Some(FLOORLESS)],
            _ => [shadowed.then_some(SHADOWED), None],
        };
        let pipeline = self.background.choose(gpu, surroundings, &kinds, compile);
        let mut bindings = vec![
            ("camera", recorder.uniform(camera)),
            ("surroundings", recorder.uniform(surroundings)),
            ("environment_texels", scene.environment.texels().bind()),
        ];
        bindings.extend(shadows.into_iter().flat_map(|sun| sun.bindings(recorder)));
        bindings.retain(|(name, _)| pipeline.binds(name));
        let targets = [("scene_color", color.view()), ("scene_distance", distance.view())];
        recorder.picture(gpu, "shading.background", pipeline, &bindings, &targets, None);
        if scene.triangles.is_empty() {
            return;
        }
        let frustum = camera.frustum();
        let compile = |defined: &_| compile_objects(gpu, defined);
        let pipeline = self.objects.choose_shadowed(gpu, surroundings, shadowed, compile);
        let mut bindings = vec![
            ("camera", recorder.uniform(camera)),
            ("surroundings", recorder.uniform(surroundings)),
            ("environment_texels", scene.environment.texels().bind()),
            ("vertices", scene.vertices.bind()),
            ("materials", scene.materials.bind()),
        ];
        bindings.extend(shadows.into_iter().flat_map(|sun| sun.bindings(recorder)));
        bindings.retain(|(name, _)| pipeline.binds(name));
        let targets = [(color.view(), None), (distance.view(), None)];
        recorder.raster(gpu, "shading.objects", pipeline, &bindings, &targets, Some(depth.view()), |pass| {
            // Indexed: most vertices are shared by six triangles.
            scene.triangles.set_as_indices(pass);
            for run in scene.runs.iter().filter(|run| frustum.sees(&run.bounds, 0.0)) {
                pass.draw_indexed(run.indices.clone(), 0, 0..1);
            }
        });
    }
}

fn compile_background(gpu: &Gpu, definitions: &[Definition]) -> Result<PicturePipeline, GpuError> {
    gpu.picture_pipeline(&PicturePipelineDescriptor {
        shader: BACKGROUND,
        includes: INCLUDES,
        definitions,
        targets: &[SceneColor::FORMAT, SceneDistance::FORMAT],
        pixels: Pixels::All,
    })
}

fn compile_objects(gpu: &Gpu, definitions: &[Definition]) -> Result<RasterPipeline, GpuError> {
    gpu.raster_pipeline(&RasterPipelineDescriptor {
        shader: OBJECTS,
        includes: INCLUDES,
        definitions,
        vertex_buffers: &[],
        targets: &[SceneColor::FORMAT, SceneDistance::FORMAT],
        depth: DepthUse::Scene,
        overlap: Overlap::Last,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_match_their_shader() {
        SceneVertex::check_layout(&OBJECTS, INCLUDES).unwrap();
    }
}
