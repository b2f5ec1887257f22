//! Tone mapping and anti-aliasing of an analytic pool with highlights: its rim and its glints give the edges that
//! anti-aliasing works on.

use std::time::Duration;

use bench_views::{GpuTime, Pool};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use meniscus_compositor::{Compositor, CompositorParameters};
use meniscus_gpu::role::{DisplayImage, Radiance};
use meniscus_gpu::{Gpu, Image};

/// Dark water that brightens with its tilt, ten times over white in the glints, on a grey floor.
fn radiance(gpu: &Gpu, size: [u32; 2]) -> Image<Radiance> {
    let pool = Pool::new(size);
    let water = |i: usize| pool.distance[i] < f32::MAX;
    let pixel = |i: usize| {
        let tilt = f32::from(pool.normal[i] as u16 as i16) / f32::from(i16::MAX);
        let glint = if tilt > 0.3 { 10.0 } else { 0.0 };
        if water(i) {
            [0.02 + glint, 0.1 + tilt.abs() + glint, 0.2 + glint, 1.0]
        } else {
            [0.4, 0.4, 0.4, 1.0]
        }
    };
    let pixels: Vec<[f32; 4]> = (0..pool.distance.len()).map(pixel).collect();
    Image::from_pixels(gpu, size, &pixels).expect("an image of the picture's size")
}

fn compositor(criterion: &mut Criterion) {
    let mut time = GpuTime::open();
    let size = if bench_views::is_measured() { [1280, 720] } else { [160, 90] };
    let radiance = radiance(time.gpu(), size);
    let display = Image::<DisplayImage>::new(time.gpu(), size).expect("an image of the picture's size");
    let mut compositor = Compositor::new(time.gpu()).expect("the passes");
    compositor.resize(time.gpu(), size).expect("room for the picture");
    let parameters = CompositorParameters::default();
    let mut group = criterion.benchmark_group("compositor");
    group.sample_size(10).warm_up_time(Duration::from_secs(1)).measurement_time(Duration::from_secs(3));
    group.throughput(Throughput::Elements(u64::from(size[0]) * u64::from(size[1])));
    for pass in ["compositor.tone_map", "compositor.fxaa"] {
        group.bench_function(pass, |b| {
            b.iter_custom(|times| {
                time.measure(times, &[pass], |recorder, gpu| {
                    compositor.record(gpu, recorder, &parameters, &radiance, &display);
                })
            });
        });
    }
    group.finish();
}

criterion_group!(benches, compositor);
criterion_main!(benches);
