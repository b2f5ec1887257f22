//! Foam from the file to the picture.

use glam::{DVec3, Vec3};
use meniscus_core::{Camera, Cancel, FrameSource, Projection, UpAxis};
use meniscus_gpu::{AdapterChoice, Gpu, Timing};
use meniscus_io::writer::{Values, WriteAttribute, WriteParticles, write_vtu_raw};
use meniscus_io::{Series, SeriesOptions};
use meniscus_pipeline::{Registry, Renderer, Settings, World};

const SPACING: f64 = 0.05;
const SIZE: [u32; 2] = [240, 180];
/// Where the jet hits the water, file units.
const HIT: [f64; 3] = [1.0, 0.5, 0.5];
/// Where a drop flies.
const DROP: [f64; 3] = [0.3, 0.5, 1.1];

/// A pool of 2 x 1 x 0.5, a jet that falls into its middle, and a drop.
fn jet(file: &std::path::Path) {
    let mut positions = Vec::new();
    let mut velocities = Vec::new();
    let mut block = |low: [f64; 3], count: [usize; 3], speed: f32| {
        for n in 0..count.iter().product::<usize>() {
            let at = [n % count[0], n / count[0] % count[1], n / count[0] / count[1]];
            positions.push([0, 1, 2].map(|axis| low[axis] + (at[axis] as f64 + 0.5) * SPACING));
            velocities.extend([0.0, 0.0, -speed]);
        }
    };
    block([0.0; 3], [40, 20, 10], 0.0);
    block([0.85, 0.35, 0.5], [6, 6, 12], 4.0);
    block(DROP, [1, 1, 1], 0.0);
    let velocity = WriteAttribute { name: "velocity", components: 3, values: Values::F32(&velocities) };
    write_vtu_raw(file, &WriteParticles { positions: &positions, attributes: &[velocity], time: None })
        .expect("a file");
}

/// The picture, row by row from the top left, and the names of the passes that drew it.
fn draw(series: &Series, settings: Settings) -> (Vec<u32>, Vec<String>) {
    let world = World::of_series(series, *series.space(), &settings).expect("a world");
    assert_eq!(
        world.request().attributes.is_empty(),
        settings.foam.velocity.is_none() || settings.foam.amount == 0.0
    );
    let gpu = Gpu::new(&AdapterChoice::default()).expect("an adapter");
    let mut renderer = Renderer::new(gpu, Registry::builtin(), settings).expect("a renderer");
    renderer.set_timing(Timing::Isolated);
    let frame = series.read(0, world.request(), &Cancel::default()).expect("a frame");
    let frame = renderer.preparer(&world).prepare(frame);
    let target = (DVec3::from(HIT) - world.space().origin).as_vec3();
    let camera = Camera {
        eye: target - 5.0 * Vec3::Y + 2.0 * Vec3::Z,
        target,
        up: Vec3::Z,
        projection: Projection::Orthographic { height_world: 1.8 },
        near: 1e-3,
    };
    let picture = renderer.render(&frame, &world, &camera, SIZE).expect("a picture");
    (picture.pixels, picture.report.stages.into_iter().map(|cost| cost.name).collect())
}

/// How many pixels around a point of the picture, given from its middle in world units, differ, and by how much their green is
/// brighter.
fn change(before: &[u32], after: &[u32], middle: [f64; 2]) -> (usize, f32) {
    let px_per_world = f64::from(SIZE[1]) / 1.8;
    let center = [
        0.5 * f64::from(SIZE[0]) + middle[0] * px_per_world,
        0.5 * f64::from(SIZE[1]) - middle[1] * px_per_world,
    ];
    let mut changed = 0;
    let mut brighter = 0.0;
    for (i, (before, after)) in before.iter().zip(after).enumerate() {
        let at = [i as u32 % SIZE[0], i as u32 / SIZE[0]].map(|c| f64::from(c) + 0.5);
        // 0.25 world units.
        if (at[0] - center[0]).hypot(at[1] - center[1]) < 0.25 * px_per_world && before != after {
            changed += 1;
            brighter += (after >> 8 & 0xff) as f32 - (before >> 8 & 0xff) as f32;
        }
    }
    (changed, brighter)
}

#[test]
fn water_foams_where_a_jet_hits_it_and_a_drop_is_spray() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("jet.vtu");
    jet(&file);
    let options = SeriesOptions { spacing: Some(SPACING), up: Some(UpAxis::Z), ..Default::default() };
    let series = Series::open(&file, &options).expect("a series");
    let with = |amount: f32, velocity: Option<&str>| {
        let mut settings = Settings::default();
        // A drop that is drawn as foam throws no shadow any more.
        settings.scene.shadows = false;
        settings.foam.amount = amount;
        settings.foam.velocity = velocity.map(str::to_owned);
        draw(&series, settings)
    };
    let (off, passes) = with(0.0, Some("velocity"));
    assert!(!passes.is_empty() && passes.iter().all(|pass| !pass.contains("foam")), "{passes:?}");
    let (on, passes) = with(1.0, Some("velocity"));
    for pass in ["ssfr.foam", "shading.foam"] {
        assert!(passes.iter().any(|name| name == pass), "{pass} in {passes:?}");
    }
    let hit = change(&off, &on, [0.0, 0.0]);
    assert!(hit.0 > 300 && hit.1 > 0.0, "{hit:?}");
    // Calm water at either side of it.
    for x in [-0.7, 0.7] {
        assert_eq!(change(&off, &on, [x, -0.1]).0, 0, "at {x}");
    }
    // The eye looks down by a slope of 2 in 5: heights are shortened by 5 / sqrt(29).
    let drop = [DROP[0] - HIT[0], (DROP[2] - HIT[2]) * 5.0 / 29.0_f64.sqrt()];
    assert!(change(&off, &on, drop).0 > 30, "a cloud in place of a sphere");
    // Without velocities it is the drop alone.
    let (spray, _) = with(1.0, None);
    assert_eq!(change(&off, &spray, [0.0, 0.0]).0, 0);
    assert_eq!(change(&on, &spray, drop).0, 0);
    // Less detail, as much foam: about the same light.
    let mut settings = Settings::default();
    settings.scene.shadows = false;
    settings.foam.amount = 1.0;
    settings.foam.velocity = Some("velocity".into());
    settings.foam.curvature = 0.0;
    settings.lod.threshold = 0.5;
    let (coarse, _) = draw(&series, settings.clone());
    settings.foam.amount = 0.0;
    let (coarse_off, _) = draw(&series, settings);
    let ratio = change(&coarse_off, &coarse, [0.0, 0.0]).1 / hit.1;
    // Clouds of half as many drops overlap otherwise, and the surface under them is another.
    assert!((0.75..1.25).contains(&ratio), "{ratio}");
}
