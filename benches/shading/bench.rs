//! The opaque scene, the water's shadow and every lighting model, over an analytic pool that fills most of the picture: the
//! same water whatever becomes of the surface stage.

use std::time::Duration;

use bench_views::{GpuTime, Pool};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use meniscus_core::{Aabb, UpAxis};
use meniscus_gpu::role::{
    EyeDistance, Radiance, SceneColor, SceneDepth, SceneDistance, Thickness, ViewNormal,
};
use meniscus_gpu::{CameraUniform, Gpu, Image, Recorder, Texture};
use meniscus_scene::Scene;
use meniscus_shading::{
    LightingChoice, LightingInputs, LightingPass, LightingRegistry, SceneGeometry, ScenePass, SunPath,
    WaterScale, WaterShadow,
};

/// Everything that light needs, on the GPU.
struct Studio {
    camera: CameraUniform,
    scene: ScenePass,
    geometry: SceneGeometry,
    scene_color: Texture<SceneColor>,
    scene_distance: Texture<SceneDistance>,
    scene_depth: Texture<SceneDepth>,
    distance: Image<EyeDistance>,
    thickness: Image<Thickness>,
    normal: Image<ViewNormal>,
    shadow: WaterShadow,
    sun_path: Image<SunPath>,
    radiance: Image<Radiance>,
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
            distance: Image::from_pixels(gpu, size, &pool.distance).expect(image),
            thickness: Image::from_pixels(gpu, size, &pool.thickness).expect(image),
            normal: Image::from_pixels(gpu, size, &pool.normal).expect(image),
            shadow: WaterShadow::new(gpu).expect("the shadow pass"),
            sun_path: Image::new(gpu, WaterShadow::size_blocks(size)).expect(image),
            radiance: Image::new(gpu, size).expect(image),
        }
    }

    fn record_scene(&self, recorder: &mut Recorder, gpu: &Gpu) {
        self.scene.record(
            gpu,
            recorder,
            &self.camera,
            &self.geometry,
            &self.scene_color,
            &self.scene_distance,
            &self.scene_depth,
        );
    }

    fn record_shadow(&self, recorder: &mut Recorder, gpu: &Gpu) {
        self.shadow.record(
            gpu,
            recorder,
            &self.camera,
            self.geometry.surroundings(),
            SCALE,
            &self.distance,
            &self.thickness,
            &self.scene_distance,
            &self.sun_path,
        );
    }

    fn record_water(&self, model: &dyn LightingPass, recorder: &mut Recorder, gpu: &Gpu) {
        let inputs = LightingInputs {
            camera: &self.camera,
            surroundings: self.geometry.surroundings(),
            scale: SCALE,
            distance: &self.distance,
            thickness: &self.thickness,
            normal: &self.normal,
            scene_color: &self.scene_color,
            scene_distance: &self.scene_distance,
            sun_path: &self.sun_path,
        };
        model.record(gpu, recorder, &inputs, &self.radiance);
    }
}

fn shading(criterion: &mut Criterion) {
    let mut time = GpuTime::open();
    let size = if bench_views::is_measured() { [1280, 720] } else { [160, 90] };
    let studio = Studio::new(time.gpu(), size);
    // Every bench finds the scene drawn and its shadow cast, also where a filter leaves those benches out.
    time.measure(1, &[], |recorder, gpu| {
        studio.record_scene(recorder, gpu);
        studio.record_shadow(recorder, gpu);
    });
    let mut group = criterion.benchmark_group("shading");
    group.sample_size(10).warm_up_time(Duration::from_secs(1)).measurement_time(Duration::from_secs(3));
    group.throughput(Throughput::Elements(u64::from(size[0]) * u64::from(size[1])));
    group.bench_function("scene", |b| {
        b.iter_custom(|times| time.measure(times, &[], |recorder, gpu| studio.record_scene(recorder, gpu)));
    });
    group.bench_function("water-shadow", |b| {
        b.iter_custom(|times| time.measure(times, &[], |recorder, gpu| studio.record_shadow(recorder, gpu)));
    });
    let registry = LightingRegistry::builtin();
    for name in registry.names() {
        let choice = LightingChoice { name: name.to_owned(), ..Default::default() };
        let model =
            registry.make(&choice).and_then(|model| model.compile(time.gpu())).expect("a built-in model");
        group.bench_function(name, |b| {
            b.iter_custom(|times| {
                time.measure(times, &[], |recorder, gpu| studio.record_water(&*model, recorder, gpu))
            });
        });
    }
    group.finish();
}

criterion_group!(benches, shading);
criterion_main!(benches);
