use meniscus_core::Look;
use meniscus_gpu::{Binding, CameraUniform, Gpu, Recorder};
use meniscus_scene::Material;
use meniscus_shading::{SceneGeometry, SolidPass, SolidSurface};
use meniscus_ssfr::filter::NoFilter;
use meniscus_ssfr::{FilterChoice, SplatSet, Ssfr, SsfrParams, SurfaceImages};

use crate::images::FrameImages;
use crate::{PipelineError, Registry};

/// Draws the sets that are not water into the opaque scene; made when a frame first has such a set.
pub(crate) struct OpaqueSets {
    solid: Ssfr,
    spheres: Ssfr,
    pass: SolidPass,
    images: SurfaceImages,
}

impl OpaqueSets {
    /// `params` are those of the water, whose filter smooths solids as well.
    pub(crate) fn new(
        gpu: &Gpu,
        registry: &Registry,
        params: &SsfrParams,
        size: [u32; 2],
    ) -> Result<Self, PipelineError> {
        let unfiltered = FilterChoice { name: NoFilter::NAME.to_owned(), ..Default::default() };
        let spheres = SsfrParams { filter: unfiltered, ..params.clone() };
        Ok(Self {
            solid: Ssfr::new(gpu, &registry.filters, params)?,
            spheres: Ssfr::new(gpu, &registry.filters, &spheres)?,
            pass: SolidPass::new(gpu)?,
            images: SurfaceImages::new(gpu, size, params)?,
        })
    }

    pub(crate) fn size(&self) -> [u32; 2] {
        self.images.size()
    }

    /// Draws all `sets` of one look into the images of `scene` in `frame`.
    #[expect(
        clippy::too_many_arguments,
        reason = "the camera comes as values for one stage and as a binding for the other"
    )]
    pub(crate) fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        (camera, camera_binding): (&CameraUniform, &Binding),
        scene: &SceneGeometry,
        look: Look,
        sets: &[SplatSet<'_>],
        frame: &FrameImages,
    ) {
        let (stage, material) = match look {
            Look::Solid => (&self.solid, "soil"),
            Look::Spheres => (&self.spheres, "plain"),
            Look::Water | Look::Hidden => return,
        };
        stage.record_opaque(recorder, gpu, camera_binding, sets, &frame.scene_distance, &self.images);
        let surface = SolidSurface {
            distance: &self.images.distance,
            normal: &self.images.normal,
            material: Material::named(material).unwrap_or_default(),
        };
        self.pass.record(gpu, recorder, camera, scene, &surface, &frame.scene_color, &frame.scene_distance);
    }
}
