//! Water coloured by an attribute, from the file to the surface.

use glam::{DVec3, Vec3};
use meniscus_color::ColorMap;
use meniscus_core::{Camera, Cancel, FrameSource, Projection, UpAxis};
use meniscus_gpu::{AdapterChoice, Gpu};
use meniscus_io::writer::{Values, WriteAttribute, WriteParticles, write_vtu_raw};
use meniscus_io::{Series, SeriesOptions};
use meniscus_pipeline::{Registry, Renderer, Settings, World};

const SPACING: f64 = 0.05;
const SIZE: [u32; 2] = [240, 120];
/// Width of the block of water, file units.
const WIDTH: f64 = 2.0;

/// A block of water whose particles know where they are, in any order, and a broken value here and there.
fn block(file: &std::path::Path) {
    let count = [40, 20, 20];
    let mut positions = Vec::new();
    for n in 0..count.iter().product::<usize>() {
        let i = n * 7919 % (40 * 20 * 20);
        positions.push([i % 40, i / 40 % 20, i / 800].map(|c| (c as f64 + 0.5) * SPACING));
    }
    let place = |(n, [x, y, z]): (usize, &[f64; 3])| {
        if n % 501 == 0 { [f32::NAN; 3] } else { [*x, *y, *z].map(|c| c as f32) }
    };
    let place: Vec<f32> = positions.iter().enumerate().flat_map(place).collect();
    let place = WriteAttribute { name: "place", components: 3, values: Values::F32(&place) };
    write_vtu_raw(file, &WriteParticles { positions: &positions, attributes: &[place], time: None })
        .expect("a file");
}

/// Seen from the front, columns are places along x: every pixel of the water has the colour of where it is.
#[test]
fn every_pixel_has_the_colour_of_its_own_particles() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("block.vtu");
    block(&file);
    let options = SeriesOptions { spacing: Some(SPACING), up: Some(UpAxis::Z), ..Default::default() };
    let series = Series::open(&file, &options).expect("a series");
    for lod in [1.0, 0.5] {
        let mut settings = Settings::default();
        settings.color.by = Some("place:x".into());
        settings.color.map = ColorMap::Grayscale.to_string();
        settings.lod.threshold = lod;
        let world = World::of_series(&series, *series.space(), &settings).expect("a world");
        let scale = world.color().expect("a scale").clone();
        assert!((scale.min - 0.025).abs() < 0.06 && (scale.max - 1.975).abs() < 0.06, "{scale:?}");
        let gpu = Gpu::new(&AdapterChoice::default()).expect("an adapter");
        let mut renderer = Renderer::new(gpu, Registry::builtin(), settings).expect("a renderer");
        let frame = series.read(0, world.request(), &Cancel::default()).expect("a frame");
        let frame = renderer.preparer(&world).prepare(frame);
        let target = (DVec3::new(0.5 * WIDTH, 0.5, 0.5) - world.space().origin).as_vec3();
        let camera = Camera {
            eye: target - 5.0 * Vec3::Y,
            target,
            up: Vec3::Z,
            projection: Projection::Orthographic { height_world: 1.2 },
            near: 1e-3,
        };
        renderer.draw_and_wait(&frame, &world, &camera, SIZE).expect("a picture");
        let colors = renderer.surface_color().expect("colours").read(renderer.gpu()).expect("pixels");
        let mut looked_at = 0;
        for (i, [r, g, b, alpha]) in colors.into_iter().enumerate() {
            if alpha == 0.0 {
                continue;
            }
            looked_at += 1;
            let column = (i as u32 % SIZE[0]) as f64 + 0.5;
            let x = 0.5 * WIDTH + (column - 0.5 * f64::from(SIZE[0])) * 1.2 / f64::from(SIZE[1]);
            let [low, high] =
                [x - SPACING, x + SPACING].map(|x| scale.map.linear(scale.position(x).expect("a number")).x);
            // Within a spacing of where the pixel is; a pixel further where few particles are drawn.
            let slack = if lod < 1.0 { 0.02 } else { 1e-3 };
            assert!(
                (low - slack..=high + slack).contains(&r) && r == g && g == b,
                "column {column}: {r}, not {low} to {high}"
            );
        }
        // A block of 2 x 1 in a picture of 2.4 x 1.2.
        assert!(looked_at > 18_000, "{looked_at} pixels");
    }
}
