//! Tone mapping and anti-aliasing of an analytic pool with highlights: its rim and its glints give the edges that
//! anti-aliasing works on.

use bench_views::{GpuTime, Pool, Stage};
use criterion::{Criterion, criterion_group, criterion_main};
use meniscus_compositor::{Compositor, CompositorParameters, Display};
use meniscus_gpu::role::Radiance;
use meniscus_gpu::{Gpu, Texture};

/// The default of `render`, and what films are made in.
const SIZES: [(&str, [u32; 2]); 2] = [("pool-720p", [1280, 720]), ("pool-1080p", [1920, 1080])];

/// Dark water that brightens with its tilt, ten times over white in the glints, on a grey floor.
fn radiance(gpu: &Gpu, size: [u32; 2]) -> Texture<Radiance> {
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
    Texture::from_floats(gpu, size, &pixels).expect("a texture of the picture's size")
}

/// Passes, and the bytes per four pixels that they cannot do without: radiance is read as four halves a pixel, the display image is
/// written as a word, twice where edges are smoothed, and brightness as a byte. What is done per edge depends on the picture.
const PASSES: [(&str, u64); 3] =
    [("compositor.tone_map", 4 * (8 + 4 + 4) + 4), ("compositor.fxaa_edges", 4), ("compositor.fxaa", 0)];

fn compositor(criterion: &mut Criterion) {
    let time = GpuTime::open();
    let mut stage = Stage::new(criterion, "compositor");
    let parameters = CompositorParameters::default();
    for (name, size) in SIZES {
        let size = if bench_views::is_measured() { size } else { [160, 90] };
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        for (pass, bytes) in PASSES {
            stage.gpu(
                &time,
                ([pass, name], &[pass]),
                pixels,
                || {
                    let display = Display::new(time.gpu(), size).expect("an image of that size");
                    let mut compositor = Compositor::new(time.gpu(), &parameters).expect("the passes");
                    compositor.resize(time.gpu(), size).expect("room for the picture");
                    (compositor, radiance(time.gpu(), size), display)
                },
                |_| (bytes > 0).then_some(pixels * bytes / 4),
                |(compositor, radiance, display), recorder, gpu| {
                    compositor.record(gpu, recorder, radiance, display);
                },
            );
        }
    }
}

criterion_group!(benches, compositor);
criterion_main!(benches);
