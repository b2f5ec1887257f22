//! Sets drawn opaque in the mirror of the water.

use glam::Vec3;
use meniscus_cases::lattice;
use meniscus_core::{Attribute, Camera, Look, ParticleFrame, ParticleSet, Projection, SetFrame};
use meniscus_gpu::{AdapterChoice, Gpu};
use meniscus_pipeline::{Layer, Registry, Renderer, Settings, World};
use meniscus_tests::space;

const SPACING: f32 = 0.05;
const SIZE: [u32; 2] = [160, 120];

/// A pool 2 wide, 2 long and 0.2 deep, and a wall of sand behind it that is 0.8 high and has a value.
fn pool_and_wall() -> SetFrame {
    let set = |name: &str, look, min, cells, values: Option<f32>| {
        let positions = lattice::cuboid(min, cells, SPACING, 0.0, 1).positions;
        let value =
            |value| Attribute { name: "value".into(), components: 1, values: vec![value; positions.len()] };
        let attributes = values.map(value).into_iter().collect();
        ParticleSet {
            name: name.into(),
            look,
            particles: ParticleFrame { positions, attributes, ..Default::default() },
        }
    };
    let pool = set("pool", Look::Water, [-1.0, -1.0, 0.0], [40, 40, 4], None);
    let wall = set("wall", Look::Solid, [-0.5, 1.2, 0.0], [20, 4, 16], Some(0.0));
    SetFrame { sets: vec![pool, wall], ..Default::default() }
}

/// Green light of the water, which only mirrors, with a wall of the colour at `range` of a scale from black to white.
fn water(range: [f64; 2]) -> Vec<f32> {
    let mut settings = Settings::default();
    settings.scene.shadows = false;
    settings.color.by = Some("value".into());
    settings.color.map = "grayscale".into();
    [settings.color.min, settings.color.max] = range.map(Some);
    settings.lighting.parameters.insert("additional_reflection".into(), 1.0.into());
    let frame = pool_and_wall();
    let world = World::of_frame(&frame, space(SPACING, 0.6 * SPACING), &settings).expect("a world");
    let gpu = Gpu::new(&AdapterChoice::default()).expect("an adapter");
    let mut renderer = Renderer::new(gpu, Registry::builtin(), settings).expect("a renderer");
    let prepared = renderer.preparer(&world).prepare(frame);
    let camera = Camera {
        eye: Vec3::new(0.0, -3.0, 1.2),
        target: Vec3::new(0.0, 0.5, 0.2),
        up: Vec3::Z,
        projection: Projection::Perspective { fovy_rad: 0.7 },
        near: 1e-2,
    };
    renderer.draw_and_wait(&prepared, &world, &camera, SIZE).expect("a picture");
    let channels = renderer.layers(&[Layer::Fluid], &prepared, &world, &camera).expect("layers");
    channels.into_iter().find(|channel| channel.name == "fluid.G").expect("green").values
}

#[test]
fn water_mirrors_sets_that_are_drawn_opaque() {
    let [black, white] = [[0.0, 1.0], [-1.0, 0.0]].map(water);
    let columns = |columns: std::ops::Range<usize>| {
        let pixels = (0..black.len()).filter(move |i| columns.contains(&(i % SIZE[0] as usize)));
        let (black, white) = (&black, &white);
        pixels.filter(move |&i| black[i] > 0.0).map(move |i| white[i] - black[i])
    };
    // The wall takes up the middle of the picture; beside it the water mirrors the sky.
    let brighter = columns(70..90).filter(|difference| *difference > 0.05).count();
    let (middle, beside) = (columns(70..90).count(), columns(20..40).collect::<Vec<_>>());
    assert!(brighter * 5 > middle && middle > 400, "{brighter} of {middle}");
    assert!(beside.len() > 200 && beside.iter().all(|difference| *difference == 0.0), "{}", beside.len());
}
