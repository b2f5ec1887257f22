//! Two resolutions in one file, from the file to the thickness, without a flag.

use glam::{DVec3, Vec3};
use meniscus_core::{Camera, Cancel, FrameSource, Projection};
use meniscus_gpu::{AdapterChoice, Gpu};
use meniscus_io::writer::{Values, WriteAttribute, WriteParticles, write_vtu_raw};
use meniscus_io::{Series, SeriesOptions};
use meniscus_pipeline::{Registry, Renderer, Settings, World};

const SPACING: f64 = 0.05;
const SIZE: [u32; 2] = [480, 240];
/// Of the picture, file units.
const HEIGHT: f64 = 1.6;

/// Cubes of edge 1 beside each other, the second of particles of twice the spacing, in any order.
fn blocks(file: &std::path::Path) {
    let block = |n: usize, x: f64| {
        let place = move |i: usize| {
            let at = [i % n, i / n % n, i / n / n].map(|c| (c as f64 + 0.5) / n as f64);
            ([at[0] + x, at[1], at[2]], (0.5 / n as f64) as f32)
        };
        (0..n.pow(3)).map(place)
    };
    let mut particles: Vec<([f64; 3], f32)> = block(20, 0.0).chain(block(10, 1.0)).collect();
    particles.sort_by_key(|(p, _)| (p[1] * 1e6) as u64);
    let (positions, radii): (Vec<_>, Vec<_>) = particles.into_iter().unzip();
    let radius = WriteAttribute { name: "radius", components: 1, values: Values::F32(&radii) };
    write_vtu_raw(file, &WriteParticles { positions: &positions, attributes: &[radius], time: None })
        .expect("a file");
}

#[test]
fn both_resolutions_are_as_thick_as_they_are_deep() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("blocks.vtu");
    blocks(&file);
    let series = Series::open(&file, &SeriesOptions::default()).expect("a series");
    assert_eq!(series.radius_by(), Some("radius"));
    let spacing = series.space().spacing;
    for lod in [1.0, 0.3] {
        let mut settings = Settings::default();
        settings.lod.threshold = lod;
        settings.scene.floor = Some(false);
        settings.surface.thickness.smoothing = 0.0;
        settings.surface.thickness.scale = 1;
        let world = World::of_series(&series, *series.space(), &settings).expect("a world");
        let gpu = Gpu::new(&AdapterChoice::default()).expect("an adapter");
        let mut renderer = Renderer::new(gpu, Registry::builtin(), settings).expect("a renderer");
        let frame = series.read(0, world.request(), &Cancel::default()).expect("a frame");
        let frame = renderer.preparer(&world).prepare(frame);
        let target = (DVec3::new(1.0, 0.5, 0.5) - world.space().origin).as_vec3();
        let camera = Camera {
            eye: target - 5.0 * Vec3::Y,
            target,
            up: Vec3::Z,
            projection: Projection::Orthographic { height_world: HEIGHT as f32 },
            near: 1e-3,
        };
        renderer.draw_and_wait(&frame, &world, &camera, SIZE).expect("a picture");
        let thickness = renderer.surface_images().thickness.read(renderer.gpu()).expect("read");
        let front = renderer.surface_images().front.read(renderer.gpu()).expect("read");
        let pixel = HEIGHT / f64::from(SIZE[1]);
        // Means over whole cells of either block's lattice, 0.2 inside of its outline.
        for (block, middle, size) in [("fine", -0.5, 1.0), ("coarse", 0.5, 2.0)] {
            let is_inside = |i: &usize| {
                let across = ((i % SIZE[0] as usize) as f64 + 0.5 - f64::from(SIZE[0]) / 2.0) * pixel;
                let down = ((i / SIZE[0] as usize) as f64 + 0.5 - f64::from(SIZE[1]) / 2.0) * pixel;
                (across - middle).abs() < 0.3 && down.abs() < 0.3
            };
            let inside: Vec<usize> = (0..thickness.len()).filter(is_inside).collect();
            // The volume is that of the spacing found, which is off by up to 5 %.
            let sum: f64 = inside.iter().map(|&i| f64::from(thickness[i])).sum();
            let mean = sum / inside.len() as f64 * (SPACING / spacing).powi(3);
            // One percent where all are drawn; stand-ins err by up to two in the mean over so few cells.
            let tolerance = if lod == 1.0 { 0.01 } else { 0.03 };
            assert!((mean - 1.0).abs() < tolerance, "{block} at {lod}: {mean}");
            // What the surface is smoothed by is the radius of the particles that show; 2 % are gaps between rows of spheres of
            // 0.625 spacings, seen along them.
            let is_own =
                |&&i: &&usize| (f64::from(front[i][1]) / world.space().radius / size - 1.0).abs() < 1e-3;
            let own = inside.iter().filter(is_own).count();
            assert!(lod < 1.0 || own * 100 > inside.len() * 95, "{block}: {own} of {}", inside.len());
        }
    }
}
