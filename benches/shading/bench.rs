//! The opaque scene, sunlight, caustics and every lighting model, over an analytic pool that fills most of the picture: the
//! same water whatever becomes of the surface stage.

use std::cell::OnceCell;

use bench_views::{GpuTime, Pool, Stage};
use criterion::{Criterion, criterion_group, criterion_main};
use glam::Vec3;
use meniscus_core::{Aabb, UpAxis};
use meniscus_gpu::role::{
    EyeDistance, NO_SURFACE, Radiance, SceneColor, SceneDepth, SceneDistance, Sunlight, SurfaceColor,
    Thickness, ViewNormal,
};
use meniscus_gpu::{CameraUniform, Covered, Gpu, Image, Recorder, Texture};
use meniscus_scene::Scene;
use meniscus_shading::{
    Caustics, CausticsPass, CausticsScratch, LightingChoice, LightingInputs, LightingPass, LightingRegistry,
    SceneGeometry, ScenePass, SunView, SunWater, SunlightPass, WaterScale, Waves,
};

/// Everything that light needs, on the GPU.
struct Studio {
    camera: CameraUniform,
    scene: ScenePass,
    geometry: SceneGeometry,
    scene_color: Texture<SceneColor>,
    scene_distance: Texture<SceneDistance>,
    scene_depth: Texture<SceneDepth>,
    covered: Covered,
    distance: Texture<EyeDistance>,
    thickness: Texture<Thickness>,
    normal: Texture<ViewNormal>,
    surface_color: Texture<SurfaceColor>,
    caustics_pass: CausticsPass,
    scratch: CausticsScratch,
    caustics: Image<Caustics>,
    sunlight_pass: SunlightPass,
    sunlight: Texture<Sunlight>,
    radiance: Texture<Radiance>,
}

const SCALE: WaterScale = WaterScale { depth_world: 0.3, spacing_world: 0.01, metres_per_world: 1.0 };

impl Studio {
    fn new(gpu: &Gpu, size: [u32; 2]) -> Self {
        let pool = Pool::new(size);
        let bounds = Aabb { min: Vec3::ZERO, max: Vec3::new(2.0, 1.0, 0.4) };
        let scene = Scene::around(bounds, UpAxis::Z, SCALE.spacing_world);
        let texture = "a texture of the picture's size";
        let image = "an image of the picture's size";
        Self {
            camera: CameraUniform::new(&Pool::camera(), size),
            scene: ScenePass::new(gpu).expect("the scene pass"),
            geometry: SceneGeometry::new(gpu, &scene).expect("the scene"),
            scene_color: Texture::new(gpu, size).expect(texture),
            scene_distance: Texture::new(gpu, size).expect(texture),
            scene_depth: Texture::new(gpu, size).expect(texture),
            covered: Covered::of(gpu, size, |i| pool.distance[i] < NO_SURFACE).expect(image),
            distance: Texture::from_texels(gpu, size, &pool.distance).expect(image),
            thickness: Texture::from_texels(gpu, size, &pool.thickness).expect(image),
            normal: Texture::from_texels(gpu, size, &pool.normal).expect(image),
            surface_color: Texture::new(gpu, [1, 1]).expect(texture),
            caustics_pass: CausticsPass::new(gpu).expect("the caustics"),
            scratch: CausticsScratch::new(gpu, size).expect("the scratch images"),
            caustics: Image::new(gpu, size).expect(image),
            sunlight_pass: SunlightPass::new(gpu).expect("the sunlight pass"),
            sunlight: Texture::new(gpu, SunlightPass::size_blocks(size)).expect(texture),
            radiance: Texture::new(gpu, size).expect(image),
        }
    }

    /// With the scene drawn and its shadow cast, so that every bench finds them also where a filter leaves those out.
    fn with_scene(time: &GpuTime, size: [u32; 2]) -> Self {
        let studio = Self::new(time.gpu(), size);
        time.measure(1, &[], |recorder, gpu| {
            studio.record_scene(recorder, gpu);
            studio.record_caustics(recorder, gpu);
            studio.record_sunlight(recorder, gpu);
        });
        studio
    }

    fn record_scene(&self, recorder: &mut Recorder, gpu: &Gpu) {
        self.scene.record(
            gpu,
            recorder,
            &self.camera,
            &self.geometry,
            None,
            &self.scene_color,
            &self.scene_distance,
            &self.scene_depth,
        );
    }

    /// The sun as if it stood where the camera does: as many pixels show water.
    fn sun_view(&self) -> SunView<'_> {
        SunView { camera: &self.camera, scene_distance: &self.scene_distance }
    }

    fn record_caustics(&self, recorder: &mut Recorder, gpu: &Gpu) {
        // One pixel: less than what single bundles of light are smoothed over.
        let spacing_world = 1.0 / self.camera.px_per_world_at_one;
        let waves = Waves { distance: &self.distance, normal: &self.normal, spacing_world, strength: 1.0 };
        self.caustics_pass.record(gpu, recorder, &self.sun_view(), &waves, &self.scratch, &self.caustics);
    }

    fn record_sunlight(&self, recorder: &mut Recorder, gpu: &Gpu) {
        let water =
            SunWater { distance: &self.distance, thickness: &self.thickness, caustics: &self.caustics };
        self.sunlight_pass.record(
            gpu,
            recorder,
            &self.camera,
            &self.sun_view(),
            &water,
            &self.distance,
            &self.scene_distance,
            true,
            &self.sunlight,
        );
    }

    fn record_water(&self, model: &dyn LightingPass, recorder: &mut Recorder, gpu: &Gpu) {
        let inputs = LightingInputs {
            camera: &self.camera,
            surroundings: self.geometry.surroundings(),
            environment: self.geometry.environment(),
            objects: None,
            scale: SCALE,
            covered: &self.covered,
            distance: &self.distance,
            thickness: &self.thickness,
            normal: &self.normal,
            surface_color: &self.surface_color,
            scene_color: &self.scene_color,
            scene_distance: &self.scene_distance,
            sunlight: &self.sunlight,
            has_sunlight: true,
        };
        model.record(gpu, recorder, &inputs, &self.radiance);
    }
}

/// Bytes per pixel that a pass cannot do without.
mod bytes_per_pixel {
    /// Colour (4 halves), distance and depth are written.
    pub const SCENE: u64 = 8 + 4 + 4;
    /// Distance and normal of the water and distance of the scene are read; light lands and is smoothed.
    pub const CAUSTICS: u64 = 4 + 4 + 4 + 4 + 4;
    /// Distance of the scene is read once, those of scene and water, thickness and caustics once more as the sun has them, for every
    /// fourth pixel.
    pub const SUNLIGHT: u64 = 4 + (4 + 4 + 4 + 4) / 4 + 8 / 4;
    /// Distance, thickness, normal, and colour and distance of the scene are read; radiance (4 halves) is written.
    pub const WATER: u64 = 4 + 4 + 4 + 8 + 4 + 8;
}

/// The default of `render`, and what films are made in.
const SIZES: [(&str, [u32; 2]); 2] = [("pool-720p", [1280, 720]), ("pool-1080p", [1920, 1080])];

fn shading(criterion: &mut Criterion) {
    let time = GpuTime::open();
    let mut stage = Stage::new(criterion, "shading");
    for (view, size) in SIZES {
        let size = if bench_views::is_measured() { size } else { [160, 90] };
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        let studio = OnceCell::new();
        let studio = || studio.get_or_init(|| Studio::with_scene(&time, size));
        stage.gpu(
            &time,
            (["scene", view], &[]),
            pixels,
            studio,
            |_| Some(pixels * bytes_per_pixel::SCENE),
            |studio, recorder, gpu| studio.record_scene(recorder, gpu),
        );
        stage.gpu(
            &time,
            (["caustics", view], &[]),
            pixels,
            studio,
            |_| Some(pixels * bytes_per_pixel::CAUSTICS),
            |studio, recorder, gpu| studio.record_caustics(recorder, gpu),
        );
        stage.gpu(
            &time,
            (["sunlight", view], &[]),
            pixels,
            studio,
            |_| Some(pixels * bytes_per_pixel::SUNLIGHT),
            |studio, recorder, gpu| studio.record_sunlight(recorder, gpu),
        );
        let registry = LightingRegistry::builtin();
        for name in registry.names() {
            let choice = LightingChoice { name: name.to_owned(), ..Default::default() };
            let model =
                registry.make(&choice).and_then(|model| model.compile(time.gpu())).expect("a built-in model");
            stage.gpu(
                &time,
                ([name, view], &[]),
                pixels,
                studio,
                |_| Some(pixels * bytes_per_pixel::WATER),
                |studio, recorder, gpu| studio.record_water(&*model, recorder, gpu),
            );
        }
    }
}

criterion_group!(benches, shading);
criterion_main!(benches);
