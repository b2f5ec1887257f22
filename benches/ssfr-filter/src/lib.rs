//! Every surface filter of a registry over the distance image of a view: what a filter costs beyond the splats.
//!
//! A filter of one's own is measured beside the built-in ones by a bench of three lines, as `examples/custom-filter` does:
//!
//! ```text
//! fn main() {
//!     bench_ssfr_filter::main("custom-filter", &registry);
//! }
//! ```
//!
//! | view | why |
//! |---|---|
//! | `dam-break` | the size users have, narrow kernels |
//! | `sphere-entry` | full HD: cost per pixel |
//! | `close-up` | the widest kernels, where taps are capped |

use bench_views::{GpuTime, Stage, View};
use criterion::Criterion;
use meniscus_gpu::role::{EyeDistance, FilterStep, FrontSphere, NO_SURFACE, Scratch};
use meniscus_gpu::{Buffer, CameraUniform, Covered, Gpu, Recorder, Texture};
use meniscus_ssfr::filter::scratch_len;
use meniscus_ssfr::{FilterChoice, FilterImages, FilterRegistry, SurfaceFilter};

/// Bytes per covered pixel that no filter can do without: its index, distance and radius are read, its distance written.
const BYTES_PER_COVERED_PIXEL: u64 = 4 * 4;

/// The `main` of a bench: measures every filter of `registry` and reports as `stage`.
pub fn main(stage: &'static str, registry: &FilterRegistry) {
    let mut criterion = Criterion::default().configure_from_args();
    let time = GpuTime::open();
    let mut stage = Stage::new(&mut criterion, stage);
    for view in bench_views::views([View::dam_break(), View::sphere_entry(), View::close_up()]) {
        let pixels = u64::from(view.size[0]) * u64::from(view.size[1]);
        let surface = std::cell::OnceCell::new();
        for entry in registry.entries() {
            let choice = FilterChoice { name: entry.name().into(), ..Default::default() };
            let filter = registry.create(time.gpu(), &choice).expect("a filter with its defaults");
            stage.gpu(
                &time,
                ([entry.name(), &view.name], &[]),
                pixels,
                || surface.get_or_init(|| Surface::new(time.gpu(), &view)),
                |surface| Some(surface.covered_pixels() * BYTES_PER_COVERED_PIXEL),
                |surface, recorder, gpu| surface.record(&*filter, recorder, gpu),
            );
        }
    }
    drop(stage);
    criterion.final_summary();
}

/// Images of a view as the splats leave them.
struct Surface {
    camera: CameraUniform,
    front: Texture<FrontSphere>,
    target: Texture<EyeDistance>,
    covered: Covered,
    covered_pixels: u64,
    steps: [Texture<FilterStep>; 2],
    scratch: [Buffer<Scratch>; 2],
    spacing_per_radius: f32,
    most_radius_px: f32,
}

impl Surface {
    fn new(gpu: &Gpu, view: &View) -> Self {
        let (size, space) = (view.size, view.space());
        let distance = view.splat();
        let is_fluid = |i: usize| distance[i] < NO_SURFACE;
        let sphere = |d: &f32| [*d, if *d < NO_SURFACE { space.radius as f32 } else { 0.0 }];
        let front: Vec<_> = distance.iter().map(sphere).collect();
        let camera = CameraUniform::new(&view.camera(), size);
        let nearest = distance.iter().copied().fold(NO_SURFACE, f32::min);
        let per_world = camera.px_per_world_at_one / if camera.orthographic == 0 { nearest } else { 1.0 };
        let step = || Texture::new(gpu, size).expect("a texture of the picture's size");
        let scratch = || Buffer::new(gpu, scratch_len(size)).expect("a buffer of the picture's size");
        Self {
            camera,
            front: Texture::from_texels(gpu, size, &front).expect("the nearest spheres"),
            target: Texture::from_texels(gpu, size, &vec![NO_SURFACE; distance.len()]).expect("the result"),
            covered: Covered::of(gpu, size, is_fluid).expect("the list of covered pixels"),
            covered_pixels: (0..distance.len()).filter(|&i| is_fluid(i)).count() as u64,
            steps: [step(), step()],
            scratch: [scratch(), scratch()],
            spacing_per_radius: (space.spacing / space.radius) as f32,
            most_radius_px: space.radius as f32 * per_world,
        }
    }

    /// The list starts with its length.
    fn covered_pixels(&self) -> u64 {
        self.covered_pixels
    }

    fn record(&self, filter: &dyn SurfaceFilter, recorder: &mut Recorder, gpu: &Gpu) {
        let camera = recorder.uniform(&self.camera);
        let images = FilterImages {
            front: &self.front,
            target: &self.target,
            covered: &self.covered,
            steps: [&self.steps[0], &self.steps[1]],
            scratch: [&self.scratch[0], &self.scratch[1]],
            spacing_per_radius: self.spacing_per_radius,
            most_radius_px: self.most_radius_px,
            // All are about as far away.
            typical_radius_px: self.most_radius_px,
        };
        filter.record(recorder, gpu, &camera, &images);
    }
}
