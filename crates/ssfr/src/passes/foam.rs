use bytemuck::{Pod, Zeroable};
use meniscus_gpu::role::{FoamDrops, FoamLayers, SceneDistance};
use meniscus_gpu::{
    Binding, Buffer, ComputePipeline, Dispatch, Gpu, HostField, HostStruct, Image, Recorder, Texture, shader,
};

use super::pipeline;
use crate::SurfaceImages;

/// How the drops of a set are drawn; WGSL: `Foam` in `shaders/ssfr/foam.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct FoamUniform {
    /// Spacing of the set's particles, which radii and depths are counted in, world units, > 0.
    pub spacing_world: f32,
    /// Factor on the drops' radii, > 0: more than 1 where some stand for others that are left out.
    pub widening: f32,
    /// Factor on their optical depth, >= 0.
    pub amount: f32,
    /// How many of the page are drawn, from the first.
    pub count: u32,
}

impl HostStruct for FoamUniform {
    const WGSL_NAME: &'static str = "Foam";
    const FIELDS: &'static [HostField] =
        meniscus_gpu::host_fields!(FoamUniform { spacing_world, widening, amount, count });
}

/// Sums drops of foam into the layers that lighting composes: in front of the surface, in it, behind it.
#[derive(Debug)]
pub struct FoamSplats {
    splat: ComputePipeline,
}

impl FoamSplats {
    /// Compiles the pass.
    pub fn new(gpu: &Gpu) -> Self {
        Self { splat: pipeline(gpu, shader!("ssfr/foam")) }
    }

    /// Writes the layers of every pixel, around the smoothed surface in `images` and up to the opaque scene. `pages`: drops and
    /// how they are drawn.
    ///
    /// # Panics
    /// If the sizes differ.
    #[expect(clippy::too_many_arguments, reason = "inputs and outputs of a pass, each used once")]
    pub fn record(
        &self,
        recorder: &mut Recorder,
        gpu: &Gpu,
        camera: &Binding,
        pages: &[(&Buffer<FoamDrops>, FoamUniform)],
        images: &SurfaceImages,
        scene_distance: &Texture<SceneDistance>,
        layers: &Image<FoamLayers>,
    ) {
        assert_eq!(layers.size(), images.size(), "size of the layers of foam");
        let [width, height] = layers.size();
        recorder.clear(gpu, "ssfr.foam", layers.buffer(), width as usize * height as usize);
        for (drops, uniform) in pages {
            let bindings = [
                ("camera", camera.clone()),
                ("foam", recorder.uniform(uniform)),
                ("drops", drops.bind()),
                ("distances", images.distance.bind()),
                ("scene_distance", scene_distance.bind()),
                ("layers", layers.bind()),
            ];
            let groups = Dispatch::Groups(u64::from(uniform.count).div_ceil(64));
            recorder.compute(gpu, "ssfr.foam", &self.splat, &bindings, groups);
        }
    }
}

#[cfg(test)]
mod tests {
    use meniscus_gpu::role::FoamDrop;

    use super::*;
    use crate::passes::INCLUDES;

    #[test]
    fn host_structs_have_the_layout_of_their_shader() {
        FoamUniform::check_layout(&shader!("ssfr/foam"), INCLUDES).unwrap();
        FoamDrop::check_layout(&shader!("ssfr/foam"), INCLUDES).unwrap();
    }
}
