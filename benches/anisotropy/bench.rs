//! Shapes of particles: the grid that neighbours are found in, and the ellipsoids made of them, each pass run on its own. In the product
//! only shells get shapes, here all particles do, so that figures divide by a number that no other stage decides. One view per number
//! of particles: shapes do not depend on the camera.

use std::cell::{OnceCell, RefCell};

use bench_views::{GpuTime, Stage, View};
use criterion::{Criterion, criterion_group, criterion_main};
use meniscus_core::Aabb;
use meniscus_gpu::role::{KeptRange, PackedParticle, Particles, Shapes};
use meniscus_gpu::{Buffer, Gpu, Page, RangeList, Recorder};
use meniscus_ssfr::{Anisotropy, AnisotropyParams, ShapePage, ShapePasses, ShapeWork};

/// A view's particles on the GPU, in one page.
struct Water {
    passes: ShapePasses,
    particles: Page<Particles>,
    shapes: Buffer<Shapes>,
    all: [RangeList; 1],
    bounds: Aabb,
    lengths: (f32, f32),
}

impl Water {
    fn new(gpu: &Gpu, view: &View) -> Self {
        let positions = view.ordered_positions();
        let particles: Vec<PackedParticle> =
            positions.iter().enumerate().map(|(i, &p)| PackedParticle::new(p, i as u16)).collect();
        let count = particles.len() as u32;
        let ranges: Vec<KeptRange> = (0..count)
            .step_by(512)
            .map(|first| KeptRange {
                first,
                count: (count - first).min(512),
                keep: KeptRange::KEEP_ALL,
                shape: 1 + first,
            })
            .collect();
        let space = view.space();
        Self {
            passes: ShapePasses::new(gpu).expect("built-in passes"),
            shapes: Buffer::new(gpu, particles.len()).expect("a page of shapes"),
            particles: Page::from_slice(gpu, &particles).expect("a page"),
            all: [RangeList::from_slice(gpu, &ranges).expect("its ranges")],
            bounds: Aabb::of_points(&positions),
            lengths: (space.radius as f32, space.spacing as f32),
        }
    }

    fn record(&mut self, recorder: &mut Recorder, gpu: &Gpu) {
        let params = AnisotropyParams { form: Some(Anisotropy::YuTurk), ..Default::default() };
        let pages = [ShapePage { particles: &self.particles, shapes: &self.shapes }];
        let work = ShapeWork {
            bounds: self.bounds,
            targets: &self.all,
            sources: &self.all,
            source_particles: self.particles.len(),
        };
        self.passes.record(recorder, gpu, &pages, &work, &params, self.lengths).expect("room for the grid");
    }
}

/// Bytes that the passes cannot do without: every particle is read, and a shape written for each.
fn bytes(view: &View) -> u64 {
    view.particles * (size_of::<PackedParticle>() + size_of::<[u32; 4]>()) as u64
}

fn shapes(criterion: &mut Criterion) {
    let time = GpuTime::open();
    let mut stage = Stage::new(criterion, "anisotropy");
    for view in bench_views::views([View::sphere_entry(), View::dam_break()]) {
        let page = OnceCell::new();
        for pass in ["ssfr.shape_grid", "ssfr.shape"] {
            stage.gpu(
                &time,
                ([pass, &view.name], &[pass]),
                view.particles,
                || page.get_or_init(|| RefCell::new(Water::new(time.gpu(), &view))),
                |_| Some(bytes(&view)),
                |page, recorder, gpu| page.borrow_mut().record(recorder, gpu),
            );
        }
    }
}

criterion_group!(benches, shapes);
criterion_main!(benches);
