//! Work counters of frames drawn one after the other: exact numbers, so nothing here depends on time.

use glam::{DVec3, Vec3};
use meniscus_core::{
    Camera, Look, ParticleFrame, ParticleSet, Projection, RadiusChoice, SeriesSpace, SetFrame, SpacingSource,
    UpAxis, WorkCounters,
};
use meniscus_gpu::{AdapterChoice, Gpu};
use meniscus_lod::LodParams;
use meniscus_pipeline::{PreparedFrame, Registry, Renderer, Settings, World};

const SPACING: f32 = 0.05;
const RADIUS: f32 = 0.04;
const SIZE: [u32; 2] = [160, 120];
/// Particles along the edges of the block, which spans from the origin to these times the spacing.
const COUNT: [usize; 3] = [40, 20, 20];

struct Set {
    renderer: Renderer,
    world: World,
    frame: PreparedFrame,
}

impl Set {
    fn new() -> Self {
        Self::with(Settings::default())
    }

    fn with(settings: Settings) -> Self {
        let mut positions = Vec::new();
        for x in 0..COUNT[0] {
            for y in 0..COUNT[1] {
                positions.extend((0..COUNT[2]).map(|z| [x, y, z].map(|i| (i as f32 + 0.5) * SPACING)));
            }
        }
        let particles = ParticleFrame { positions, ..Default::default() };
        let water = ParticleSet { name: "water".into(), look: Look::Water, particles };
        let frame = SetFrame { sets: vec![water], ..Default::default() };
        let space = SeriesSpace {
            origin: DVec3::ZERO,
            spacing: SPACING.into(),
            spacing_source: SpacingSource::User,
            radius: RADIUS.into(),
            radius_choice: RadiusChoice::User,
            up: UpAxis::Z,
            metres_per_unit: 1.0,
        };
        let world = World::of_frame(&frame, space, &settings).unwrap();
        let gpu = Gpu::new(&AdapterChoice::default()).expect("an adapter, at least mesa-vulkan-drivers");
        let mut renderer = Renderer::new(gpu, Registry::builtin(), settings).unwrap();
        renderer.set_counting(true);
        let frame = renderer.preparer(&world).prepare(frame);
        Self { renderer, world, frame }
    }

    /// Draws with a [`camera`].
    fn draw(&mut self, target: Vec3, height_world: f32) -> WorkCounters {
        let camera = camera(target, height_world);
        self.renderer.draw_and_wait(&self.frame, &self.world, &camera, SIZE).unwrap();
        self.renderer.counters(&self.frame).unwrap()
    }
}

/// Looks along y at `target`, in parallel projection.
fn camera(target: Vec3, height_world: f32) -> Camera {
    Camera {
        eye: target - Vec3::Y * 5.0,
        target,
        up: Vec3::Z,
        projection: Projection::Orthographic { height_world },
        near: 1e-3,
    }
}

/// The middle of the block; a picture 1.5 high has all of it, with a rim.
const MIDDLE: Vec3 = Vec3::new(1.0, 0.5, 0.5);
const ALL: f32 = 1.8;

fn of(counter: Option<u64>) -> u64 {
    counter.expect("a counter that was measured")
}

#[test]
fn a_picture_drawn_again_moves_and_makes_nothing() {
    let mut set = Set::new();
    let first = set.draw(MIDDLE, ALL);
    let particles = COUNT.iter().product::<usize>() as u64;
    assert_eq!(first.particles_kept, Some(particles));
    assert_eq!(first.particle_bytes_uploaded, Some(16 * particles), "position, hash and radius");
    assert!(of(first.range_bytes_uploaded) > 0 && of(first.gpu_allocations) > 0);

    // Reading the counters back makes a buffer, once.
    set.draw(MIDDLE, ALL);
    let again = set.draw(MIDDLE, ALL);
    assert_eq!(again.particle_bytes_uploaded, Some(0));
    assert_eq!(again.range_bytes_uploaded, Some(0));
    assert_eq!(again.other_bytes_uploaded, Some(0));
    assert_eq!(again.gpu_allocations, Some(0));
    let work =
        |c: &WorkCounters| (c.splat_pixels_depth, c.splat_pixels_thickness, c.filter_taps, c.covered_pixels);
    assert_eq!(work(&again), work(&first));

    let panned = set.draw(MIDDLE + Vec3::X * 0.01, ALL);
    assert_eq!(panned.particle_bytes_uploaded, Some(0));
    assert_eq!(panned.gpu_allocations, Some(0));
    assert!(of(panned.range_bytes_uploaded) > 0, "a new camera, a new selection");
}

/// In a parallel view a splat is a disc of the same size everywhere: its rectangle has as many pixel centres as its area, on
/// average over the lattice. What is visited is at least the disc, at most the square with a pixel added on every side.
#[test]
fn splats_visit_their_squares_and_no_more() {
    let mut set = Set::new();
    let frame = set.draw(MIDDLE, ALL);
    let kept = of(frame.particles_kept) as f64;
    let px_per_world = f64::from(SIZE[1]) / f64::from(ALL);
    let diameter_px = 2.0 * f64::from(RADIUS) * px_per_world;
    let visited = of(frame.splat_pixels_depth) as f64;
    let disc = std::f64::consts::FRAC_PI_4 * diameter_px * diameter_px;
    // All of what is drawn first is visited; of what is tested, no more than what was not hidden.
    let (tested, hidden) = (of(frame.particles_tested) as f64, of(frame.particles_hidden) as f64);
    // One side of six faces the eye, and all but the middle tenth of this block is shell.
    assert!(tested > 0.5 * kept && hidden > 0.3 * tested, "{frame:?}");
    let most = (kept - hidden) * (diameter_px + 2.0).powi(2);
    assert!(((kept - tested) * disc..most).contains(&visited), "{visited} pixels, {diameter_px} wide");
    // Thickness is drawn wider (its own kernel) on a picture of half the size or less: never more than that of the depth
    // pass with a kernel of twice the radius.
    let per_splat = of(frame.splat_pixels_thickness) as f64 / kept;
    assert!((1.0..(2.0 * diameter_px + 2.0).powi(2)).contains(&per_splat), "{per_splat} pixels of thickness");
}

#[test]
fn half_the_view_costs_half_the_splats() {
    let mut set = Set::new();
    let all = set.draw(MIDDLE, ALL);
    // Moved aside until the middle of the block is at the picture's border.
    let width_world = ALL * SIZE[0] as f32 / SIZE[1] as f32;
    let part = set.draw(MIDDLE + Vec3::X * 0.5 * width_world, ALL);
    assert!(of(part.chunks_culled) > 0);
    let share =
        |counter: fn(&WorkCounters) -> Option<u64>| of(counter(&part)) as f64 / of(counter(&all)) as f64;
    // Chunks at the border stay whole, and there are ten; their splats outside the picture visit no pixel.
    assert!(share(|c| c.particles_kept) < 0.9, "{part:?}");
    assert!((0.4..0.6).contains(&share(|c| c.splat_pixels_depth)), "{part:?}");
    assert!((0.4..0.6).contains(&share(|c| c.covered_pixels)), "{part:?}");
    assert!((0.4..0.6).contains(&share(|c| c.filter_taps)), "the filter works on water only: {part:?}");
}

/// A picture four times as large in which the same water has the same pixels: only sky is added, which no filter may touch.
#[test]
fn empty_pixels_are_not_filtered() {
    let mut set = Set::new();
    let small = set.draw(MIDDLE, ALL);
    let large = SIZE.map(|side| 2 * side);
    set.renderer.draw_and_wait(&set.frame, &set.world, &camera(MIDDLE, 2.0 * ALL), large).unwrap();
    let large = set.renderer.counters(&set.frame).unwrap();
    assert_eq!(large.covered_pixels, small.covered_pixels);
    // Taps are cut at the picture's border, which the small one may have nearer: never fewer in the large one.
    let (large, small) = (of(large.filter_taps) as f64, of(small.filter_taps) as f64);
    assert!((1.0..1.02).contains(&(large / small)), "{large} taps against {small}");
}

/// Few particles are drawn as ellipsoids, whose shapes are found once for a frame of particles, whatever the camera; what is drawn
/// with them shows.
#[test]
fn shapes_are_found_once() {
    let mut ellipsoids = Set::new();
    let first = ellipsoids.draw(MIDDLE, ALL);
    let again = ellipsoids.draw(MIDDLE + Vec3::Z * 0.1, ALL);
    // Smoothed as little as ellipsoids are.
    let mut settings = Settings::default();
    settings.set("anisotropy.form", "none").unwrap();
    settings.set("filter.sigma", "0.8").unwrap();
    settings.set("filter.iterations", "1").unwrap();
    let mut spheres = Set::with(settings);
    spheres.draw(MIDDLE, ALL);
    let passes = of(spheres.draw(MIDDLE + Vec3::Z * 0.1, ALL).compute_passes);
    // What might be large is drawn in strips too: a list of them to be emptied and one to be drawn, for both lists of splats. Of
    // spheres that are known to be small there are none.
    let of_strips = 4;
    let again_passes = of(again.compute_passes);
    assert!((passes..=passes + of_strips).contains(&again_passes), "{again_passes}: spheres take {passes}");
    assert!(of(first.compute_passes) > again_passes + 4);
    assert_eq!(of(again.gpu_allocations), 0);
    let distance = |set: &Set| set.renderer.surface_images().distance.read(set.renderer.gpu()).unwrap();
    let (of_ellipsoids, of_spheres) = (distance(&ellipsoids), distance(&spheres));
    let differing = std::iter::zip(&of_ellipsoids, &of_spheres).filter(|(a, b)| a != b).count();
    assert!(differing > of_spheres.len() / 10, "{differing}");
}

/// Sky and floor are not cast again while the camera stands, as in most films; what is drawn over them does not stay in them.
#[test]
fn a_still_scene_is_drawn_once() {
    let mut set = Set::new();
    set.draw(MIDDLE, ALL);
    // A software driver draws them, a GPU computes them.
    let passes = |counters: WorkCounters| of(counters.compute_passes) + of(counters.raster_passes);
    let still = passes(set.draw(MIDDLE, ALL));
    let moved = passes(set.draw(MIDDLE + Vec3::Z * 0.1, ALL));
    assert_eq!(still + 1, moved);
    let mut picture =
        || set.renderer.render(&set.frame, &set.world, &camera(MIDDLE, ALL), SIZE).unwrap().pixels;
    let (first, again) = (picture(), picture());
    assert!(first == again, "the second picture differs");
}

/// Below full detail the thickness has coarser samples where particles are far enough apart, which takes other images; nothing is
/// made anew while that stays so.
#[test]
fn samples_are_coarser_below_full_detail_where_particles_are_apart() {
    let mut set = Set::new();
    // 1.5 and 3.3 pixels between particles.
    let heights = [4.0, ALL, ALL, 4.0];
    let mut made = |threshold| {
        set.renderer.set_lod(LodParams { threshold, ..Default::default() }).unwrap();
        set.draw(MIDDLE, 4.0);
        heights.map(|height| of(set.draw(MIDDLE, height).gpu_allocations) > 0)
    };
    assert_eq!(made(1.0), [false; 4]);
    assert_eq!(made(0.3), [false, true, false, true]);
}
