use meniscus_core::Look;
use meniscus_gpu::role::{SceneColor, SceneDistance, SurfaceColor};
use meniscus_gpu::{Binding, CameraUniform, Gpu, Recorder, Texture};
use meniscus_scene::Material;
use meniscus_shading::{SceneGeometry, SolidPass, SolidSurface, SunView};
use meniscus_ssfr::filter::NoFilter;
use meniscus_ssfr::{AnisotropyParams, ColoredSet, FilterChoice, SplatSet, Ssfr, SsfrParams, SurfaceImages};

use crate::colors::SurfaceColors;
use crate::{PipelineError, Registry};

/// A drawn scene, which sets become part of.
pub(crate) struct Scene<'a> {
    pub(crate) geometry: &'a SceneGeometry,
    pub(crate) shadows: Option<SunView<'a>>,
    pub(crate) color: &'a Texture<SceneColor>,
    pub(crate) distance: &'a Texture<SceneDistance>,
}

/// Draws the sets that are not water into the opaque scene; made when a frame first has such a set.
pub(crate) struct OpaqueSets {
    solid: Ssfr,
    spheres: Ssfr,
    pass: SolidPass,
    images: SurfaceImages,
    /// A single pixel, for sets that no attribute colours.
    no_color: Texture<SurfaceColor>,
}

impl OpaqueSets {
    /// `params` are those of the water, whose filter smooths solids as well; their particles are spheres.
    pub(crate) fn new(
        gpu: &Gpu,
        registry: &Registry,
        params: &SsfrParams,
        size: [u32; 2],
    ) -> Result<Self, PipelineError> {
        let params = &SsfrParams { anisotropy: AnisotropyParams::default(), ..params.clone() };
        let unfiltered = FilterChoice { name: NoFilter::NAME.to_owned(), ..Default::default() };
        let spheres = SsfrParams { filter: unfiltered, ..params.clone() };
        Ok(Self {
            solid: Ssfr::new(gpu, &registry.filters, params)?,
            spheres: Ssfr::new(gpu, &registry.filters, &spheres)?,
            pass: SolidPass::new(gpu)?,
            images: SurfaceImages::new(gpu, size, params)?,
            no_color: Texture::new(gpu, [1, 1])?,
        })
    }

    pub(crate) fn size(&self) -> [u32; 2] {
        self.images.size()
    }

    /// Draws `sets` of one look into `scene`, with `colors` coloured by their values. The camera comes as values for one stage and as
    /// a binding for the other.
    #[expect(clippy::too_many_arguments, reason = "it draws a whole picture")]
    pub(crate) fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        (camera, camera_binding): (&CameraUniform, &Binding),
        scene: &Scene<'_>,
        look: Look,
        sets: &[ColoredSet<'_>],
        colors: Option<&SurfaceColors>,
    ) {
        let (stage, material) = match look {
            Look::Solid => (&self.solid, "soil"),
            Look::Spheres => (&self.spheres, "plain"),
            Look::Water | Look::Hidden => return,
        };
        let splats: Vec<SplatSet> = sets.iter().map(|set| set.set).collect();
        stage.record_opaque(recorder, gpu, camera_binding, &splats, scene.distance, &self.images);
        if let Some(colors) = colors {
            colors.record(gpu, recorder, camera_binding, sets, &self.images);
        }
        let surface = SolidSurface {
            distance: &self.images.distance,
            normal: &self.images.normal,
            color: colors.map_or(&self.no_color, |colors| &colors.image),
            material: Material::named(material).unwrap_or_default(),
        };
        let shadows = scene.shadows.as_ref();
        self.pass.record(
            gpu,
            recorder,
            camera,
            scene.geometry,
            shadows,
            &surface,
            scene.color,
            scene.distance,
        );
    }
}
