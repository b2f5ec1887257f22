//! Sets drawn opaque and coloured by an attribute, from particles to the lit scene.

use glam::{DVec3, Vec3};
use meniscus_cases::lattice;
use meniscus_core::{
    Attribute, Camera, Look, ParticleFrame, ParticleSet, Projection, RadiusChoice, SeriesSpace, SetFrame,
    SpacingSource, UpAxis,
};
use meniscus_gpu::{AdapterChoice, Gpu};
use meniscus_pipeline::{Layer, Registry, Renderer, Settings, World};
use meniscus_scene::Material;

const SPACING: f32 = 0.05;
const SIZE: [u32; 2] = [240, 120];
/// Height of the picture, world units: five pixels a spacing.
const HEIGHT: f32 = 1.2;

/// Two blocks side by side, x from 0 to 1 and from 1 to 2, that are both drawn as `look`: particles of the left one know their
/// x, those of the right one nothing.
fn blocks(look: Look) -> SetFrame {
    let block = |x: f32| lattice::cuboid([x, 0.0, 0.0], [20, 20, 20], SPACING, 0.0, 1).positions;
    let set = |name: &str, x: f32, attributes: &dyn Fn(&[[f32; 3]]) -> Vec<Attribute>| {
        let positions = block(x);
        let attributes = attributes(&positions);
        let particles = ParticleFrame { positions, attributes, ..Default::default() };
        ParticleSet { name: name.into(), look, particles }
    };
    let place = |positions: &[[f32; 3]]| {
        let values = positions.iter().map(|p| p[0]).collect();
        vec![Attribute { name: "place".into(), components: 1, values }]
    };
    let sets = vec![set("left", 0.0, &place), set("right", 1.0, &|_| Vec::new())];
    SetFrame { sets, ..Default::default() }
}

fn space() -> SeriesSpace {
    SeriesSpace {
        origin: DVec3::ZERO,
        spacing: SPACING.into(),
        spacing_source: SpacingSource::User,
        radius: (0.6 * SPACING).into(),
        radius_choice: RadiusChoice::User,
        up: UpAxis::Z,
        metres_per_unit: 1.0,
    }
}

/// Radiance of the scene seen from the front.
fn scene(frame: &SetFrame, change: impl FnOnce(&mut Settings)) -> (World, [Vec<f32>; 3]) {
    let mut settings = Settings::default();
    settings.scene.shadows = false;
    change(&mut settings);
    let world = World::of_frame(frame, space(), &settings).expect("a world");
    let gpu = Gpu::new(&AdapterChoice::default()).expect("an adapter");
    let mut renderer = Renderer::new(gpu, Registry::builtin(), settings).expect("a renderer");
    let prepared = renderer.preparer(&world).prepare(frame.clone());
    let target = Vec3::new(1.0, 0.5, 0.5);
    let camera = Camera {
        eye: target - 5.0 * Vec3::Y,
        target,
        up: Vec3::Z,
        projection: Projection::Orthographic { height_world: HEIGHT },
        near: 1e-3,
    };
    renderer.draw_and_wait(&prepared, &world, &camera, SIZE).expect("a picture");
    let channels = renderer.layers(&[Layer::Scene], &prepared, &world, &camera).expect("layers");
    (world, channels.into_iter().map(|c| c.values).collect::<Vec<_>>().try_into().expect("three channels"))
}

/// Whether both are the same radiance: to the bit, but a GPU adds up in another order where another pass drew it, which may be the
/// last step of a half float (NVIDIA H100), 0.1 %.
fn is_same(a: [f32; 3], b: [f32; 3], is_software: bool) -> bool {
    let tolerance = if is_software { 0.0 } else { 1e-3 };
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance * a.abs())
}

/// What a surface sends is linear in its albedo, whatever its normal and light: its material and black give the line, on which the
/// albedo of every pixel is then read.
#[test]
fn opaque_sets_have_the_albedo_of_their_values_and_others_their_own() {
    let is_software = Gpu::new(&AdapterChoice::default()).expect("an adapter").summary().is_software();
    // The blocks touch. What has colours is smoothed apart from what has none; of spheres, the seam is a pixel.
    for (look, material, seam) in [(Look::Solid, "soil", 0.25), (Look::Spheres, "plain", 0.011)] {
        let frame = blocks(look);
        let colored = |map: &str, range: [f64; 2]| {
            let (world, radiance) = scene(&frame, |settings| {
                settings.color.by = Some("place".into());
                settings.color.map = map.into();
                [settings.color.min, settings.color.max] = range.map(Some);
            });
            (world.color().expect("a scale").clone(), radiance)
        };
        let (_, plain) = scene(&frame, |_| ());
        let (_, black) = colored("grayscale", [1e6, 2e6]);
        let (scale, drawn) = colored("viridis", [0.0, 1.0]);
        let own = Material::named(material).expect("a material").color;
        let (mut left, mut right) = (0, 0);
        for pixel in 0..plain[0].len() {
            let x = (pixel as u32 % SIZE[0]) as f32 + 0.5 - 0.5 * SIZE[0] as f32;
            let x = f64::from(1.0 + x * HEIGHT / SIZE[1] as f32);
            let values = |of: &[Vec<f32>; 3]| std::array::from_fn::<f32, 3, _>(|c| of[c][pixel]);
            let (plain, black, drawn) = (values(&plain), values(&black), values(&drawn));
            if (x - 1.0).abs() < seam {
                continue;
            }
            if is_same(plain, black, is_software) {
                // Sky and floor, or the set that has no values.
                assert!(is_same(plain, drawn, is_software), "{look:?} at x = {x}: {plain:?} and {drawn:?}");
                right += usize::from(x > 1.0);
                continue;
            }
            let y = pixel as u32 / SIZE[0];
            assert!((-0.01..1.0).contains(&x), "{look:?} at x = {x}, row {y}: {plain:?} {black:?} {drawn:?}");
            left += 1;
            for c in 0..3 {
                let albedo = (drawn[c] - black[c]) / (plain[c] - black[c]) * own[c];
                // A particle's value reaches a spacing.
                let near = [-1.0, 0.0, 1.0].map(|spacings| {
                    let place = scale.position(x + spacings * f64::from(SPACING)).expect("a number");
                    scale.map.linear(place).to_array()[c]
                });
                let [low, high] =
                    [near.iter().copied().fold(1.0, f32::min), near.iter().copied().fold(0.0, f32::max)];
                // Differences of half floats, which round by 0.05 %, are a tenth of the values at worst.
                assert!(
                    (low - 0.01..=high + 0.01).contains(&albedo),
                    "{look:?}, x = {x}: {albedo} not in {near:?}"
                );
            }
        }
        // A hundred pixels square each, of which spheres leave gaps.
        assert!(left > 7000 && right > 7000, "{look:?}: {left} coloured, {right} not");
    }
}

#[test]
fn the_range_is_that_of_all_drawn_sets_and_those_without_values_are_named() {
    let mut frame = blocks(Look::Solid);
    let mut settings = Settings::default();
    settings.color.by = Some("place".into());
    let world = World::of_frame(&frame, space(), &settings).expect("a world");
    let scale = world.color().expect("a scale");
    assert!(scale.min < 0.03 && scale.max > 0.97, "{scale:?}");
    let said = world.choices().into_iter().find(|choice| choice.what == "colours of set right");
    assert!(said.expect("a choice").reason.contains("place"));
    frame.sets[1].look = Look::Hidden;
    let world = World::of_frame(&frame, space(), &settings).expect("a world");
    assert!(world.choices().iter().all(|choice| choice.what != "colours of set right"));
    frame.sets[0].look = Look::Hidden;
    let error = World::of_frame(&frame, space(), &settings).expect_err("nothing is drawn").to_string();
    assert!(error.contains("place"), "{error}");
}
