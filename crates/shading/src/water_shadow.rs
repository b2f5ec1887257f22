//! What the water takes from the sunlight that falls on the scene.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use meniscus_gpu::role::{EyeDistance, Role, SceneDistance, Thickness};
use meniscus_gpu::{
    CameraUniform, ComputePipeline, ComputePipelineDescriptor, Dispatch, Gpu, HostField, HostStruct, Image,
    Recorder, Shader, Texture, host_fields, shader,
};

use crate::{ShadingError, Surroundings, WaterScale};

const SHADER: Shader = shader!("shading/water_shadow");

/// Length of water between a point of the opaque scene and the sun, one value per [`WaterShadow::BLOCK_PX`] squared pixels.
#[derive(Clone, Copy, Debug)]
pub enum SunPath {}

impl Role for SunPath {
    type Element = f32;
    const NAME: &'static str = "SunPath";
    const UNIT: &'static str = "world units towards the sun";
    const EMPTY: f32 = 0.0;
}

/// The parameters as the GPU sees them; WGSL: `WaterShadow` in `shaders/shading/water_shadow.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct WaterShadowUniform {
    pub sun_direction_view: [f32; 3],
    pub reach_world: f32,
    pub size_blocks: [u32; 2],
    pub pad_a: u32,
    pub pad_b: u32,
}

impl HostStruct for WaterShadowUniform {
    const WGSL_NAME: &'static str = "WaterShadow";
    const FIELDS: &'static [HostField] =
        host_fields!(WaterShadowUniform { sun_direction_view, reach_world, size_blocks, pad_a, pad_b });
}

impl WaterShadowUniform {
    pub(crate) fn new(camera: &CameraUniform, surroundings: &Surroundings, scale: WaterScale) -> Self {
        let sun = Vec3::from(surroundings.sky.sun_direction);
        let view_from_world = glam::Mat4::from_cols_array_2d(&camera.view_from_world);
        // A ray from the ground leaves water of this depth after depth / sine; half as much is left for what splashes above
        // it. A sun near the horizon would need too many samples.
        let sine = sun.dot(surroundings.sky.up.into()).max(0.3);
        let usable = scale.depth_world.is_normal() && scale.depth_world > 0.0;
        Self {
            sun_direction_view: view_from_world.transform_vector3(sun).to_array(),
            reach_world: if usable { 1.5 * scale.depth_world / sine } else { 0.0 },
            size_blocks: WaterShadow::size_blocks(camera.size_px),
            pad_a: 0,
            pad_b: 0,
        }
    }
}

/// Finds how much water lies between the scene and the sun, by marching through the water as the camera sees it.
#[derive(Debug)]
pub struct WaterShadow {
    pipeline: ComputePipeline,
}

impl WaterShadow {
    /// Pixels per side of a block that shares one value.
    pub const BLOCK_PX: u32 = 4;

    /// Compiles the pass.
    ///
    /// # Errors
    /// [`ShadingError::Gpu`] when the shader does not compile.
    pub fn new(gpu: &Gpu) -> Result<Self, ShadingError> {
        Ok(Self { pipeline: gpu.compute_pipeline(&ComputePipelineDescriptor::new(SHADER))? })
    }

    /// Size of the [`SunPath`] image for a picture of `size` pixels.
    pub fn size_blocks(size: [u32; 2]) -> [u32; 2] {
        size.map(|pixels| pixels.div_ceil(Self::BLOCK_PX))
    }

    /// Records `shading.water_shadow`. The inputs have the camera's size, `output` has [`Self::size_blocks`] of it.
    #[expect(clippy::too_many_arguments, reason = "each is a different image or a different space")]
    pub fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        camera: &CameraUniform,
        surroundings: &Surroundings,
        scale: WaterScale,
        distance: &Image<EyeDistance>,
        thickness: &Image<Thickness>,
        scene_distance: &Texture<SceneDistance>,
        output: &Image<SunPath>,
    ) {
        let bindings = [
            ("camera", recorder.uniform(camera)),
            ("shadow", recorder.uniform(&WaterShadowUniform::new(camera, surroundings, scale))),
            ("distances", distance.bind()),
            ("thicknesses", thickness.bind()),
            ("scene_distance", scene_distance.bind()),
            ("sun_paths", output.bind()),
        ];
        let size = Dispatch::Pixels(output.size());
        recorder.compute(gpu, "shading.water_shadow", &self.pipeline, &bindings, size);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uniform_matches_its_shader() {
        WaterShadowUniform::check_layout(&SHADER, &[]).unwrap();
    }

    #[test]
    fn a_scale_without_meaning_throws_no_shadow() {
        let camera = CameraUniform::zeroed();
        for depth_world in [0.0, -3.0, f32::NAN, f32::INFINITY] {
            let scale = WaterScale { depth_world, spacing_world: 1.0, metres_per_world: 1.0 };
            let uniform = WaterShadowUniform::new(&camera, &Surroundings::zeroed(), scale);
            assert_eq!(uniform.reach_world, 0.0);
        }
        assert_eq!(WaterShadow::size_blocks([1, 9]), [1, 3]);
    }
}
