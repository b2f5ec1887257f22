//! The surface stage over spheres of one radius, as level of detail would hand them over.

use bench_views::View;
use meniscus_core::Camera;
use meniscus_gpu::role::{KeptRange, NO_SURFACE, PackedParticle, Particles, SceneDistance};
use meniscus_gpu::{CameraUniform, Gpu, Page, RangeList, Recorder, Texture};
use meniscus_ssfr::{
    FilterChoice, FilterRegistry, Radii, SplatInput, SplatParams, SplatSet, Ssfr, SsfrParams, SurfaceImages,
};

/// Most particles of a range: those of level of detail (`meniscus_lod`) have as many.
const RANGE_PARTICLES: u32 = 512;

/// Spheres of one radius and the picture that they are drawn in.
#[derive(Clone, Debug)]
pub struct Spheres {
    /// Centres, world space, neighbours together.
    pub positions: Vec<[f32; 3]>,
    /// Radius, world units, > 0.
    pub radius_world: f32,
    /// Distance of neighbours, world units, > 0.
    pub spacing_world: f32,
    /// The camera.
    pub camera: Camera,
    /// `[width, height]` in pixels.
    pub size: [u32; 2],
}

impl Spheres {
    /// Every particle of `view`.
    pub fn of(view: &View) -> Self {
        let space = view.space();
        Self {
            positions: view.ordered_positions(),
            radius_world: space.radius as f32,
            spacing_world: space.spacing as f32,
            camera: view.camera(),
            size: view.size,
        }
    }
}

/// The surface stage without a filter.
pub struct Stage {
    params: SsfrParams,
    passes: Ssfr,
}

impl Stage {
    /// Compiles the stage, which draws splats as `splats` say.
    pub fn new(gpu: &Gpu, splats: SplatParams) -> Self {
        let filter = FilterChoice { name: "none".into(), ..Default::default() };
        let params = SsfrParams { splats, filter, ..Default::default() };
        let passes = Ssfr::new(gpu, &FilterRegistry::builtin(), &params).expect("built-in passes");
        Self { params, passes }
    }

    /// Records all passes of the stage.
    pub fn record(&self, recorder: &mut Recorder, gpu: &Gpu, splats: &Splats) {
        splats.with_set(|set| {
            let camera = recorder.uniform(&splats.camera);
            self.passes.record(recorder, gpu, &camera, &[set], &splats.sky, &splats.images);
        });
    }

    /// As [`Self::record`], without thickness.
    pub fn record_opaque(&self, recorder: &mut Recorder, gpu: &Gpu, splats: &Splats) {
        splats.with_set(|set| {
            let camera = recorder.uniform(&splats.camera);
            self.passes.record_opaque(recorder, gpu, &camera, &[set], &splats.sky, &splats.images);
        });
    }
}

/// [`Spheres`] on the GPU and the images they are drawn to.
pub struct Splats {
    images: SurfaceImages,
    pages: Vec<(Page<Particles>, RangeList)>,
    sky: Texture<SceneDistance>,
    camera: CameraUniform,
    radius_world: f32,
    volume_world: f32,
    most_half_px: f32,
    most_radius_px: f32,
    front_half_px: f32,
}

impl Splats {
    /// Uploads `spheres` and makes images for `stage`.
    ///
    /// # Panics
    /// If the device lacks room.
    pub fn new(gpu: &Gpu, stage: &Stage, spheres: &Spheres) -> Self {
        let numbered = spheres.positions.iter().enumerate();
        let particles: Vec<_> = numbered.map(|(i, &p)| PackedParticle::new(p, i as u16)).collect();
        let pages = particles.chunks(Page::<Particles>::most_elements(gpu)).map(|page| {
            let count = page.len() as u32;
            let ranges: Vec<KeptRange> = (0..count)
                .step_by(RANGE_PARTICLES as usize)
                .map(|first| KeptRange {
                    first,
                    count: (count - first).min(RANGE_PARTICLES),
                    keep: KeptRange::KEEP_ALL,
                    shape: 0,
                })
                .collect();
            let particles = Page::from_slice(gpu, page).expect("a page");
            (particles, RangeList::from_slice(gpu, &ranges).expect("its ranges"))
        });
        let pages = pages.collect();
        let size = spheres.size;
        let sky = Texture::new(gpu, size).expect("a texture of the picture's size");
        sky.write(gpu, &vec![NO_SURFACE; (size[0] * size[1]) as usize]);
        let [most_half_px, most_radius_px, front_half_px] = half_sizes(spheres);
        Self {
            images: SurfaceImages::new(gpu, size, &stage.params).expect("images of the picture's size"),
            pages,
            sky,
            camera: CameraUniform::new(&spheres.camera, size),
            radius_world: spheres.radius_world,
            volume_world: spheres.spacing_world.powi(3),
            most_half_px,
            most_radius_px,
            front_half_px,
        }
    }

    /// What the stage makes.
    pub fn images(&self) -> &SurfaceImages {
        &self.images
    }

    fn with_set(&self, record: impl FnOnce(SplatSet)) {
        let input = |(particles, ranges)| SplatInput {
            particles,
            shapes: None,
            front: ranges,
            tested: None,
            mass: ranges,
            stand_ins: None,
        };
        let pages: Vec<SplatInput> =
            self.pages.iter().map(|(particles, ranges)| input((particles, ranges))).collect();
        record(SplatSet {
            pages: &pages,
            radius_world: self.radius_world,
            volume_world: self.volume_world,
            radii: Radii::Equal,
            is_uniform_mass: true,
            is_in_front: false,
            most_half_px: self.most_half_px,
            most_radius_px: self.most_radius_px,
            front_half_px: self.front_half_px,
            most_thickness: f64::INFINITY,
        });
    }
}

/// Radii of `spheres` in pixels: a bound of all, stretched outlines towards the corners of the picture included, one at the points
/// nearest to the eye, and the root of the mean square.
fn half_sizes(spheres: &Spheres) -> [f32; 3] {
    /// More than outlines are stretched by in fields of view of up to a right angle.
    const STRETCH: f32 = 1.8;
    let Spheres { positions, radius_world, camera, size, .. } = spheres;
    let view = camera.view_from_world();
    let half_px = |distance: f32| radius_world * camera.px_per_world(*size, distance.max(camera.near));
    let (mut most, mut most_near, mut squares) = (0.0f32, 0.0f32, 0.0f64);
    for position in positions {
        let distance = -view.transform_point3((*position).into()).z;
        most = most.max(half_px(distance));
        most_near = most_near.max(half_px(distance - radius_world));
        squares += f64::from(half_px(distance)).powi(2);
    }
    [STRETCH * most, most_near, (squares / positions.len().max(1) as f64).sqrt() as f32]
}
