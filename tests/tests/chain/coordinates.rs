//! The picture depends on the water, not on the unit or the origin of its coordinates.

use meniscus_cases::{Case, CaseOptions};
use meniscus_core::{Cancel, FrameRequest, FrameSource, SeriesSpace};
use meniscus_gpu::{AdapterChoice, Gpu};
use meniscus_io::writer::{Values, WriteAttribute, WriteParticles, write_vtu_raw};
use meniscus_io::{Series, SeriesOptions};
use meniscus_pipeline::{Registry, Renderer, Settings, World};
use meniscus_scene::automatic_camera;
use meniscus_tests::Pixels;

const SIZE: [u32; 2] = [320, 180];

/// A dam break whose coordinates went through `map`, written, read and drawn with nothing chosen by hand.
fn draw(map: impl Fn([f64; 3]) -> [f64; 3]) -> (Pixels, SeriesSpace) {
    let frame = Case::DamBreak.frame(&CaseOptions { particles: 10_000, frames: 1, seed: 1 }, 0);
    let positions: Vec<[f64; 3]> = frame.positions.iter().map(|p| map(*p)).collect();
    let pressure = WriteAttribute { name: "pressure", components: 1, values: Values::F32(&frame.pressure) };
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("dam.vtu");
    let particles = WriteParticles { positions: &positions, attributes: &[pressure], time: None };
    write_vtu_raw(&file, &particles).expect("a file");

    let series = Series::open(&file, &SeriesOptions::default()).expect("a series");
    let settings = Settings::default();
    let world = World::of_series(&series, *series.space(), &settings).expect("a world");
    let gpu = Gpu::new(&AdapterChoice::default()).expect("an adapter");
    let mut renderer = Renderer::new(gpu, Registry::builtin(), settings).expect("a renderer");
    let frame = series.read(0, &FrameRequest::default(), &Cancel::default()).expect("a frame");
    let frame = renderer.preparer(&world).prepare(frame);
    let camera = automatic_camera(world.outline(), world.space().up, SIZE);
    let picture = renderer.render(&frame, &world, &camera, SIZE).expect("a picture");
    let rgba = picture.pixels.iter().map(|p| p.to_le_bytes()).collect();
    (Pixels { size: SIZE, rgba }, *series.space())
}

/// Where silhouettes and specular highlights fall on a pixel or beside it hangs on the last bits of the coordinates, which
/// differ after a change of origin or unit. That is some pixels in a thousand, each by some tens of steps: a tenth of a
/// step on average. A picture that moved by a pixel, or a floor at another height, differs by more than one.
const TOLERANCE: f64 = 0.15;

#[test]
fn map_coordinates_give_the_same_picture() {
    let (here, _) = draw(|p| p);
    let (there, space) = draw(|[x, y, z]| [x + 500_000.0, y + 3_400_000.0, z]);
    assert!(space.origin.x > 499_999.0 && space.origin.y > 3_399_999.0, "{space:?}");
    let difference = here.mean_difference(&there);
    assert!(difference < TOLERANCE, "{difference}");
}

#[test]
fn millimetres_give_the_same_picture() {
    let (metres, in_m) = draw(|p| p);
    let (millimetres, in_mm) = draw(|p| p.map(|c| c * 1000.0));
    assert!((in_mm.spacing / in_m.spacing / 1000.0 - 1.0).abs() < 1e-3, "{in_m:?} {in_mm:?}");
    let difference = metres.mean_difference(&millimetres);
    assert!(difference < TOLERANCE, "{difference}");
}

#[test]
fn another_picture_is_another_picture() {
    let (still, _) = draw(|p| p);
    let (stretched, _) = draw(|[x, y, z]| [x * 1.05, y, z]);
    assert!(still.mean_difference(&stretched) > 4.0 * TOLERANCE);
}
