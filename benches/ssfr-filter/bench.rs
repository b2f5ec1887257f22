//! Every surface filter over the distance image of a view: what a filter costs beyond the splats.

use std::time::Duration;

use bench_views::{GpuTime, View};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use meniscus_gpu::role::{EffectiveRadius, EyeDistance, NO_SURFACE, Scratch};
use meniscus_gpu::{Buffer, CameraUniform, Gpu, Image, Recorder};
use meniscus_ssfr::{FilterChoice, FilterImages, FilterRegistry, SurfaceFilter};

/// Images of a view as the splats leave them.
struct Surface {
    camera: CameraUniform,
    source: Image<EyeDistance>,
    radius: Image<EffectiveRadius>,
    target: Image<EyeDistance>,
    covered: Buffer<Scratch>,
    scratch: [Image<Scratch>; 2],
    spacing_per_radius: f32,
}

impl Surface {
    fn new(gpu: &Gpu, view: &View) -> Self {
        let (size, space) = (view.size, view.space());
        let distance = view.splat();
        let is_fluid = |i: &u32| distance[*i as usize] < NO_SURFACE;
        let covered: Vec<u32> =
            (0..size[0] * size[1]).filter(is_fluid).map(|i| (i % size[0]) | ((i / size[0]) << 16)).collect();
        let covered = [&[covered.len() as u32][..], &covered].concat();
        let radius: Vec<f32> =
            distance.iter().map(|&d| if d < NO_SURFACE { space.radius as f32 } else { 0.0 }).collect();
        let scratch = || Image::new(gpu, size).expect("an image of the picture's size");
        Self {
            camera: CameraUniform::new(&view.camera(), size),
            source: Image::from_pixels(gpu, size, &distance).expect("the distance image"),
            radius: Image::from_pixels(gpu, size, &radius).expect("the radius image"),
            target: Image::from_pixels(gpu, size, &vec![NO_SURFACE; distance.len()]).expect("the result"),
            covered: Buffer::from_slice(gpu, &covered).expect("the list of covered pixels"),
            scratch: [scratch(), scratch()],
            spacing_per_radius: (space.spacing / space.radius) as f32,
        }
    }

    fn record(&self, filter: &dyn SurfaceFilter, recorder: &mut Recorder, gpu: &Gpu) {
        let camera = recorder.uniform(&self.camera);
        let images = FilterImages {
            source: &self.source,
            radius: &self.radius,
            target: &self.target,
            covered: &self.covered,
            scratch: [&self.scratch[0], &self.scratch[1]],
            spacing_per_radius: self.spacing_per_radius,
        };
        filter.record(recorder, gpu, &camera, &images);
    }
}

fn filter(criterion: &mut Criterion) {
    let mut time = GpuTime::open();
    let registry = FilterRegistry::builtin();
    let mut group = criterion.benchmark_group("ssfr-filter");
    group.sample_size(10).warm_up_time(Duration::from_secs(1)).measurement_time(Duration::from_secs(3));
    for view in bench_views::views([View::dam_break(), View::sphere_entry()]) {
        let mut surface = None;
        group.throughput(Throughput::Elements(u64::from(view.size[0]) * u64::from(view.size[1])));
        for entry in registry.entries() {
            let choice = FilterChoice { name: entry.name().into(), ..Default::default() };
            let filter = registry.create(time.gpu(), &choice).expect("a filter with its defaults");
            group.bench_function(BenchmarkId::new(entry.name(), &view.name), |b| {
                let surface = surface.get_or_insert_with(|| Surface::new(time.gpu(), &view));
                b.iter_custom(|times| {
                    time.measure(times, &[], |recorder, gpu| surface.record(&*filter, recorder, gpu))
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, filter);
criterion_main!(benches);
