//! Splats: nearest distance and thickness of every particle of a view at full detail, each pass run on its own. Level of
//! detail hands over neighbours in short runs; the view's cells stand in for it. Every committed view is an input, since each
//! has splats of another size: 1.5 px (`fjord-tsunami`), 2.5 (`dam-break`), 6 (`sphere-entry`), 18 (`close-up`).

use std::cell::OnceCell;

use bench_views::{GpuTime, Stage, View};
use criterion::{Criterion, criterion_group, criterion_main};
use meniscus_gpu::role::{KeptRange, NO_SURFACE, PackedParticle, Particles, SceneDistance};
use meniscus_gpu::{Buffer, CameraUniform, Gpu, RangeList, Recorder, Texture};
use meniscus_ssfr::{
    FilterChoice, FilterRegistry, Radii, SplatInput, SplatSet, Ssfr, SsfrParams, SurfaceImages,
};

/// The surface stage and a view's particles on the GPU.
struct Splats {
    stage: Ssfr,
    images: SurfaceImages,
    pages: Vec<(Buffer<Particles>, RangeList)>,
    sky: Texture<SceneDistance>,
    camera: CameraUniform,
    radius_world: f32,
    volume_world: f32,
}

impl Splats {
    fn new(gpu: &Gpu, view: &View) -> Self {
        let filter = FilterChoice { name: "none".into(), ..Default::default() };
        let params = SsfrParams { filter, ..Default::default() };
        let positions = view.ordered_positions();
        let particles: Vec<PackedParticle> =
            positions.iter().enumerate().map(|(i, &p)| PackedParticle::new(p, i as u16)).collect();
        let pages = particles.chunks(gpu.page_elements::<PackedParticle>()).map(|page| {
            let count = page.len() as u32;
            let ranges: Vec<KeptRange> = (0..count)
                .step_by(1024)
                .map(|first| KeptRange {
                    first,
                    count: (count - first).min(1024),
                    keep: KeptRange::KEEP_ALL,
                    shape: 0,
                })
                .collect();
            let particles = Buffer::from_slice(gpu, page).expect("a page");
            (particles, RangeList::from_slice(gpu, &ranges).expect("its ranges"))
        });
        let pages = pages.collect();
        let sky = Texture::new(gpu, view.size).expect("a texture of the picture's size");
        let pixels = (view.size[0] * view.size[1]) as usize;
        sky.write(gpu, &vec![NO_SURFACE; pixels]);
        let space = view.space();
        Self {
            stage: Ssfr::new(gpu, &FilterRegistry::builtin(), &params).expect("built-in passes"),
            images: SurfaceImages::new(gpu, view.size, &params).expect("images of the picture's size"),
            pages,
            sky,
            camera: CameraUniform::new(&view.camera(), view.size),
            radius_world: space.radius as f32,
            volume_world: (space.spacing as f32).powi(3),
        }
    }

    fn record(&self, recorder: &mut Recorder, gpu: &Gpu) {
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
        let set = SplatSet {
            pages: &pages,
            radius_world: self.radius_world,
            volume_world: self.volume_world,
            radii: Radii::Equal,
            is_uniform_mass: true,
        };
        let camera = recorder.uniform(&self.camera);
        self.stage.record(recorder, gpu, &camera, &[set], &self.sky, &self.images);
    }
}

/// Bytes that the splats cannot do without: every particle is read, every covered pixel written once.
fn bytes(view: &View) -> u64 {
    let pixels = f64::from(view.size[0]) * f64::from(view.size[1]) * f64::from(view.covered_fraction);
    view.particles * size_of::<PackedParticle>() as u64 + 4 * pixels as u64
}

fn splat(criterion: &mut Criterion) {
    let time = GpuTime::open();
    let mut stage = Stage::new(criterion, "ssfr-splat");
    for view in bench_views::views(View::all()) {
        let splats = OnceCell::new();
        for pass in ["ssfr.depth", "ssfr.thickness"] {
            stage.gpu(
                &time,
                ([pass, &view.name], &[pass]),
                view.particles,
                || splats.get_or_init(|| Splats::new(time.gpu(), &view)),
                |_| Some(bytes(&view)),
                |splats, recorder, gpu| splats.record(recorder, gpu),
            );
        }
    }
}

criterion_group!(benches, splat);
criterion_main!(benches);
