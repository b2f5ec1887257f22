//! A frame of the surface stage from plain numbers.
#![allow(dead_code, reason = "each test binary uses a part")]

use meniscus_core::{Aabb, Camera, Projection};
use meniscus_gpu::role::{
    KeptRange, NO_SURFACE, Occludee, Occludees, PackedParticle, Particles, SceneDistance, Shapes, StandIn,
    StandIns,
};
use meniscus_gpu::{AdapterChoice, Buffer, CameraUniform, Gpu, Page, RangeList, Recorder, Texture, Timing};
use meniscus_ssfr::twin::{HostSet, HostView};
use meniscus_ssfr::{
    AnisotropyParams, FilterChoice, FilterRegistry, Radii, ShapePage, ShapePasses, ShapeWork, SplatInput,
    SplatParams, SplatSet, Ssfr, SsfrParams, SurfaceImages, Tested, ThicknessParams,
};

pub fn gpu() -> Gpu {
    Gpu::new(&AdapterChoice::default()).expect("an adapter, at least mesa-vulkan-drivers")
}

/// What is drawn: one set in one page.
#[derive(Clone)]
pub struct Scene {
    pub camera: Camera,
    pub size: [u32; 2],
    pub particles: Vec<PackedParticle>,
    pub ranges: Vec<KeptRange>,
    pub radius: f32,
    pub spacing: f32,
    pub radii: Radii,
    pub most_half_px: f32,
    pub most_radius_px: f32,
    pub most_thickness: f64,
    pub is_in_front: bool,
    /// Shapes of all particles; none: spheres.
    pub shapes: Option<AnisotropyParams>,
    /// Ranges that are drawn where `ranges` do not hide them.
    pub occludees: Vec<Occludee>,
    /// Counted in the thickness beside `ranges` and `occludees`.
    pub stand_ins: Vec<StandIn>,
    pub scene_distance: Vec<f32>,
}

impl Scene {
    /// All of `positions`, under an open sky.
    pub fn new(camera: Camera, size: [u32; 2], positions: &[[f32; 3]], radius: f32, spacing: f32) -> Self {
        let particles: Vec<_> = positions
            .iter()
            .enumerate()
            .map(|(i, &p)| PackedParticle::new(p, (i * 40503 % 65536) as u16))
            .collect();
        let ranges = ranges_of(particles.len(), KeptRange::KEEP_ALL);
        let scene_distance = vec![NO_SURFACE; (size[0] * size[1]) as usize];
        Self {
            camera,
            size,
            particles,
            ranges,
            radius,
            spacing,
            radii: Radii::Equal,
            is_in_front: false,
            most_half_px: f32::INFINITY,
            most_radius_px: f32::INFINITY,
            most_thickness: f64::INFINITY,
            shapes: None,
            occludees: Vec::new(),
            stand_ins: Vec::new(),
            scene_distance,
        }
    }

    pub fn uniform(&self) -> CameraUniform {
        CameraUniform::new(&self.camera, self.size)
    }

    pub fn view(&self) -> HostView {
        HostView::new(&self.uniform())
    }

    pub fn host_set(&self) -> HostSet<'_> {
        HostSet {
            particles: &self.particles,
            shapes: &[],
            ranges: &self.ranges,
            radius_world: self.radius,
            volume_world: self.spacing.powi(3),
        }
    }

    pub fn render(&self, gpu: &Gpu, params: &SsfrParams) -> Frame {
        self.render_timed(gpu, params, 1).0
    }

    /// Renders `frames` times; costs of the last.
    pub fn render_timed(
        &self,
        gpu: &Gpu,
        params: &SsfrParams,
        frames: usize,
    ) -> (Frame, Vec<meniscus_core::StageCost>) {
        render_together(gpu, &[self], params, frames)
    }
}

/// Renders the sets of `scenes` in one picture, with the camera and the surroundings of the first, `frames` times; costs of the
/// last.
pub fn render_together(
    gpu: &Gpu,
    scenes: &[&Scene],
    params: &SsfrParams,
    frames: usize,
) -> (Frame, Vec<meniscus_core::StageCost>) {
    let mut recorder = Recorder::new(gpu, if frames > 1 { Timing::Isolated } else { Timing::Stamps });
    let (images, costs) = draw(gpu, &mut recorder, scenes, params, frames);
    let front = images.front.read(gpu).unwrap();
    let frame = Frame {
        size: images.size(),
        unfiltered: front.iter().map(|sphere| sphere[0]).collect(),
        distance: images.distance.read(gpu).unwrap(),
        radius: front.iter().map(|sphere| sphere[1]).collect(),
        thickness: images.thickness.read(gpu).unwrap(),
        normal: images.normal.read(gpu).unwrap(),
        covered_pixels: images.covered_pixels(gpu).unwrap(),
    };
    (frame, costs)
}

/// Pixels that the compute passes look at to find the nearest sphere.
pub fn visited_pixels(gpu: &Gpu, scene: &Scene, params: &SsfrParams) -> u64 {
    let mut recorder = Recorder::new(gpu, Timing::Stamps);
    recorder.set_counting(gpu, true);
    draw(gpu, &mut recorder, &[scene], params, 1);
    let tallies = recorder.tallies(gpu).unwrap();
    tallies.into_iter().find_map(|(name, count)| (name == "splat_pixels_depth").then_some(count)).unwrap()
}

fn draw(
    gpu: &Gpu,
    recorder: &mut Recorder,
    scenes: &[&Scene],
    params: &SsfrParams,
    frames: usize,
) -> (SurfaceImages, Vec<meniscus_core::StageCost>) {
    let &[first, ..] = scenes else { panic!("nothing to render") };
    let stage = Ssfr::new(gpu, &FilterRegistry::builtin(), params).unwrap();
    let images = SurfaceImages::new(gpu, first.size, params).unwrap();
    let scene_distance = Texture::<SceneDistance>::new(gpu, first.size).unwrap();
    scene_distance.write(gpu, &first.scene_distance);
    let uploaded: Vec<Uploaded> = scenes.iter().map(|scene| Uploaded::new(gpu, scene)).collect();
    let pages: Vec<[SplatInput<'_>; 1]> = uploaded.iter().map(|set| [set.page()]).collect();
    let sets: Vec<SplatSet<'_>> = std::iter::zip(scenes, &pages)
        .map(|(scene, pages)| SplatSet {
            pages,
            radius_world: scene.radius,
            volume_world: scene.spacing.powi(3),
            radii: scene.radii,
            is_uniform_mass: scene.radii == Radii::Equal,
            is_in_front: scene.is_in_front,
            most_half_px: scene.most_half_px,
            most_radius_px: scene.most_radius_px,
            front_half_px: 1.0,
            most_thickness: scene.most_thickness,
        })
        .collect();
    let mut costs = Vec::new();
    for _ in 0..frames {
        let camera = recorder.uniform(&first.uniform());
        stage.record(recorder, gpu, &camera, &sets, &scene_distance, &images);
        let _ = recorder.submit(gpu).unwrap();
        gpu.wait().unwrap();
        costs = recorder.take_costs(gpu);
    }
    (images, costs)
}

/// A scene's set on the GPU.
struct Uploaded {
    particles: Page<Particles>,
    front: RangeList,
    occludees: Buffer<Occludees>,
    visible: RangeList,
    mass: RangeList,
    spheres: Page<StandIns>,
    of_spheres: RangeList,
    shapes: Option<Buffer<Shapes>>,
}

impl Uploaded {
    fn new(gpu: &Gpu, scene: &Scene) -> Self {
        let mut visible = RangeList::new(gpu).unwrap();
        visible.reserve(gpu, scene.occludees.len()).unwrap();
        let tested = scene.occludees.iter().map(|occludee| occludee.range);
        let all: Vec<KeptRange> = scene.ranges.iter().copied().chain(tested).collect();
        let of_spheres = ranges_of(scene.stand_ins.len(), KeptRange::KEEP_ALL);
        Self {
            particles: Page::from_slice(gpu, &scene.particles).unwrap(),
            front: RangeList::from_slice(gpu, &scene.ranges).unwrap(),
            occludees: Buffer::from_slice(gpu, &scene.occludees).unwrap(),
            visible,
            mass: RangeList::from_slice(gpu, &all).unwrap(),
            spheres: Page::from_slice(gpu, &scene.stand_ins).unwrap(),
            of_spheres: RangeList::from_slice(gpu, &of_spheres).unwrap(),
            shapes: scene.shapes.map(|params| shapes_on_gpu(gpu, scene, &params)),
        }
    }

    fn page(&self) -> SplatInput<'_> {
        SplatInput {
            particles: &self.particles,
            shapes: self.shapes.as_ref(),
            front: &self.front,
            tested: Some(Tested { occludees: &self.occludees, visible: &self.visible }),
            mass: &self.mass,
            stand_ins: Some((&self.spheres, &self.of_spheres)),
        }
    }
}

/// The shapes of all particles of `scene`, one after the other.
pub fn shapes_on_gpu(gpu: &Gpu, scene: &Scene, params: &AnisotropyParams) -> Buffer<Shapes> {
    let particles = Page::from_slice(gpu, &scene.particles).unwrap();
    let shapes = Buffer::from_slice(gpu, &vec![[0; 4]; scene.particles.len()]).unwrap();
    let all: Vec<KeptRange> = ranges_of(scene.particles.len(), KeptRange::KEEP_ALL)
        .into_iter()
        .map(|range| KeptRange { shape: 1 + range.first, ..range })
        .collect();
    let lists = [RangeList::from_slice(gpu, &all).unwrap()];
    let work = ShapeWork {
        bounds: Aabb::of_points(scene.particles.iter().map(|particle| &particle.position_world)),
        targets: &lists,
        sources: &lists,
        source_particles: scene.particles.len(),
    };
    let pages = [ShapePage { particles: &particles, shapes: &shapes }];
    let mut recorder = Recorder::new(gpu, Timing::Stamps);
    let mut passes = ShapePasses::new(gpu).unwrap();
    let lengths = (scene.radius, scene.spacing);
    passes.record(&mut recorder, gpu, &pages, &work, params, lengths).unwrap();
    let _ = recorder.submit(gpu).unwrap();
    gpu.wait().unwrap();
    shapes
}

/// Ranges of at most 1024 over `count` particles.
pub fn ranges_of(count: usize, keep: u32) -> Vec<KeptRange> {
    (0..count)
        .step_by(1024)
        .map(|first| KeptRange {
            first: first as u32,
            count: (count - first).min(1024) as u32,
            keep,
            shape: 0,
        })
        .collect()
}

/// The images of a frame on the host.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    pub size: [u32; 2],
    pub unfiltered: Vec<f32>,
    pub distance: Vec<f32>,
    pub radius: Vec<f32>,
    pub thickness: Vec<f32>,
    pub normal: Vec<u32>,
    pub covered_pixels: u32,
}

pub fn params(filter: &str, scale: u32, smoothing: f32) -> SsfrParams {
    SsfrParams {
        filter: FilterChoice { name: filter.into(), ..Default::default() },
        thickness: ThicknessParams { scale, smoothing },
        ..Default::default()
    }
}

/// `params` with what is drawn first drawn as triangles, or never.
pub fn triangles(params: SsfrParams, always: bool) -> SsfrParams {
    let from_px = if always { 0.0 } else { f32::MAX };
    SsfrParams { splats: SplatParams { triangles_from_px: Some(from_px) }, ..params }
}

/// Looks along -z from (0, 0, `distance`).
pub fn perspective(distance: f32, fovy_rad: f32) -> Camera {
    Camera { projection: Projection::Perspective { fovy_rad }, ..parallel(distance, 1.0) }
}

/// Looks along -z from (0, 0, `distance`), `height` world units high.
pub fn parallel(distance: f32, height: f32) -> Camera {
    Camera {
        eye: [0.0, 0.0, distance].into(),
        target: [0.0, 0.0, distance - 1.0].into(),
        up: [0.0, 1.0, 0.0].into(),
        projection: Projection::Orthographic { height_world: height },
        near: 0.01,
    }
}

pub fn is_fluid(distance: f32) -> bool {
    distance < NO_SURFACE
}
