use meniscus_gpu::role::SceneDistance;
use meniscus_gpu::{Binding, Gpu, Recorder, Texture};

use crate::passes::{NormalPass, SurfacePasses, ThicknessPasses};
use crate::splats::Common;
use crate::{FilterImages, FilterRegistry, SplatSet, SsfrError, SsfrParams, SurfaceFilter, SurfaceImages};

/// The surface stage: its pipelines and its filter.
pub struct Ssfr {
    params: SsfrParams,
    surface: SurfacePasses,
    thickness: ThicknessPasses,
    normal: NormalPass,
    filter: Box<dyn SurfaceFilter>,
}

impl Ssfr {
    /// Compiles the passes and makes the filter that `params` names out of `filters`.
    ///
    /// # Errors
    /// A parameter out of range, an unknown filter, or a shader that the driver does not take.
    pub fn new(gpu: &Gpu, filters: &FilterRegistry, params: &SsfrParams) -> Result<Self, SsfrError> {
        params.validate()?;
        Ok(Self {
            params: params.clone(),
            surface: SurfacePasses::new(gpu, params)?,
            thickness: ThicknessPasses::new(gpu)?,
            normal: NormalPass::new(gpu)?,
            filter: filters.create(gpu, &params.filter)?,
        })
    }

    /// Changes parameters; what is compiled stays, only a filter that changed is made anew.
    ///
    /// # Errors
    /// As [`Self::new`]; the stage then stays as it was.
    pub fn set_params(
        &mut self,
        gpu: &Gpu,
        filters: &FilterRegistry,
        params: &SsfrParams,
    ) -> Result<(), SsfrError> {
        params.validate()?;
        if params.filter != self.params.filter {
            self.filter = filters.create(gpu, &params.filter)?;
        }
        let of_splats = |params: &SsfrParams| (params.splats, params.anisotropy.is_on());
        if of_splats(params) != of_splats(&self.params) {
            self.surface.fit(gpu, params);
        }
        self.params = params.clone();
        Ok(())
    }

    /// The parameters in use.
    pub fn params(&self) -> &SsfrParams {
        &self.params
    }

    /// Records the passes of a frame. `camera` is a [`CameraUniform`](meniscus_gpu::CameraUniform) for pictures of the
    /// size of `images` and of `scene_distance`, which hides what lies behind it.
    ///
    /// # Panics
    /// If the sizes differ or `images` were made for another thickness scale ([`SurfaceImages::fit`]).
    pub fn record(
        &self,
        recorder: &mut Recorder,
        gpu: &Gpu,
        camera: &Binding,
        sets: &[SplatSet<'_>],
        scene_distance: &Texture<SceneDistance>,
        images: &SurfaceImages,
    ) {
        let common = self.record_splats(recorder, gpu, camera, sets, scene_distance, images);
        self.thickness.record(recorder, gpu, camera, sets, &common, scene_distance, images, &self.params);
        self.record_smoothing(recorder, gpu, camera, &common, images);
    }

    /// As [`Self::record`] for a surface that nothing shines through: without thickness.
    ///
    /// # Panics
    /// As [`Self::record`].
    pub fn record_opaque(
        &self,
        recorder: &mut Recorder,
        gpu: &Gpu,
        camera: &Binding,
        sets: &[SplatSet<'_>],
        scene_distance: &Texture<SceneDistance>,
        images: &SurfaceImages,
    ) {
        let common = self.record_splats(recorder, gpu, camera, sets, scene_distance, images);
        self.record_smoothing(recorder, gpu, camera, &common, images);
    }

    fn record_splats(
        &self,
        recorder: &mut Recorder,
        gpu: &Gpu,
        camera: &Binding,
        sets: &[SplatSet<'_>],
        scene_distance: &Texture<SceneDistance>,
        images: &SurfaceImages,
    ) -> Common {
        assert!(images.fit(scene_distance.size(), &self.params), "surface images of another size or scale");
        let common = Common::of(sets, &self.params);
        self.surface.record(recorder, gpu, camera, sets, &common, scene_distance, images);
        common
    }

    fn record_smoothing(
        &self,
        recorder: &mut Recorder,
        gpu: &Gpu,
        camera: &Binding,
        common: &Common,
        images: &SurfaceImages,
    ) {
        self.filter.record(
            recorder,
            gpu,
            camera,
            &FilterImages {
                front: &images.front,
                target: &images.distance,
                covered: &images.covered,
                steps: [&images.steps[0], &images.steps[1]],
                scratch: [&images.nearest, &images.radius],
                spacing_per_radius: common.spacing_per_radius,
                most_radius_px: common.most_radius_px,
                typical_radius_px: common.typical_radius_px,
            },
        );
        self.normal.record(recorder, gpu, camera, images);
    }
}
