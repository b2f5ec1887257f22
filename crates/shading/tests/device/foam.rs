//! Foam over a lit picture, against its twin and against light that foam cannot make.

use glam::Vec3;
use meniscus_core::{Aabb, Camera};
use meniscus_gpu::role::{FoamDrop, FoamLayers, Radiance};
use meniscus_gpu::{CameraUniform, Gpu, Image, Recorder, Texture};
use meniscus_scene::Scene;
use meniscus_shading::conformance::{Frame, cast};
use meniscus_shading::twin::foam;
use meniscus_shading::{FoamLook, FoamPass, LightingInputs};

use crate::support::{gpu, tiled_scene};

const SIZE: [u32; 2] = [96, 64];
const PIXELS: usize = 96 * 64;
const BOUNDS: Aabb = Aabb { min: Vec3::ZERO, max: Vec3::new(2.0, 0.5, 1.0) };
const EXTINCTION: [f32; 3] = [3.0, 0.7, 0.4];

/// A pool with waves.
fn pool(scene: &Scene) -> Frame {
    let camera = Camera::fit(&BOUNDS.corners(), Vec3::new(-0.4, -0.6, -0.8), Vec3::Y, 0.8, SIZE, 0.9);
    let water = cast(&CameraUniform::new(&camera, SIZE), BOUNDS, 0.01, |p: Vec3| {
        let height = 0.3 + 0.05 * (7.0 * p.x + 3.0 * p.z).sin();
        0.7 * ((p - BOUNDS.center().with_y(0.0)).abs() - Vec3::new(1.0, height, 0.5)).max_element()
    });
    Frame::plain(&camera, SIZE, scene, water, [0.3, 0.4, 0.5, 1.0], 30.0)
}

/// What foam makes of a picture that is `radiance` everywhere.
fn draw(gpu: &Gpu, frame: &Frame, layers: &[[u32; 4]], look: &FoamLook, radiance: [f32; 4]) -> Vec<[f32; 4]> {
    let layers = Image::<FoamLayers>::from_pixels(gpu, SIZE, layers).unwrap();
    let pass = FoamPass::new(gpu).unwrap();
    let bare = Texture::from_floats(gpu, SIZE, &[radiance; PIXELS]).unwrap();
    let record = |recorder: &mut Recorder, inputs: &LightingInputs<'_>, output: &Texture<Radiance>| {
        pass.record(gpu, recorder, inputs, &layers, look, &bare, output);
    };
    frame.draw_with(gpu, record).unwrap()
}

fn of_twin(frame: &Frame, layers: &[[u32; 4]], look: &FoamLook, radiance: [f32; 4]) -> Vec<[f32; 4]> {
    frame.on_host(|input, pixel| {
        foam(look, input, layers[(pixel[1] * SIZE[0] + pixel[0]) as usize], radiance, pixel)
    })
}

/// Layers of some optical depth, different in every pixel, none in a few.
fn some_layers() -> Vec<[u32; 4]> {
    let roll = |i: usize, k: usize| (i * [7919, 104_729, 1_299_709][k] % 3 * (i * 31 % 4096)) as u32;
    let of = |i| [roll(i, 0), roll(i, 1), roll(i, 2), roll(i, 2) * (i as u32 % 20)];
    (0..PIXELS).map(of).collect()
}

fn look(frame: &Frame, curvature: f32) -> FoamLook {
    FoamLook::new(EXTINCTION, frame.scale, curvature, 0.05)
}

#[test]
fn foam_agrees_with_its_twin() {
    let gpu = gpu();
    let mut frame = pool(&tiled_scene());
    // In some of the pixels objects keep the sun away.
    frame.dapple();
    let radiance = [0.1, 0.2, 0.3, 0.75];
    for curvature in [0.0, 2.0] {
        let look = look(&frame, curvature);
        let found = draw(&gpu, &frame, &some_layers(), &look, radiance);
        let expected = of_twin(&frame, &some_layers(), &look, radiance);
        for (pixel, (found, expected)) in found.iter().zip(&expected).enumerate() {
            let off = std::iter::zip(found, expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            // Exponentials and square roots in single precision; what is under the foam is rounded, and what comes out. Nothing is
            // brighter than 1 by much.
            assert!(
                off < 1e-4 + 2.0 * Radiance::ROUNDING,
                "{}: {found:?}, the twin has {expected:?}",
                frame.place(pixel)
            );
        }
        let is_foam =
            |p: &[f32; 4]| std::iter::zip(p, radiance).any(|(a, b)| (a - b).abs() > Radiance::ROUNDING);
        assert!(found.iter().filter(|p| is_foam(p)).count() > PIXELS / 2);
    }
}

/// A white plate that scatters all light, turned to where most comes from, in the light of the frame.
fn plate(frame: &Frame) -> Vec3 {
    let sky = &frame.surroundings.sky;
    let ambient = Vec3::from(sky.irradiance_up).max(sky.irradiance_down.into());
    (ambient + Vec3::from(sky.sun_irradiance)) / std::f32::consts::PI
}

#[test]
fn foam_is_never_brighter_than_a_white_plate_in_the_same_light() {
    let gpu = gpu();
    let frame = pool(&tiled_scene());
    let plate = plate(&frame);
    let look = look(&frame, 10.0);
    for layer in 0..4 {
        let mut layers = [0; 4];
        layers[layer % 4] = 1000 * FoamDrop::STEPS;
        let mut brightest = Vec3::ZERO;
        for pixel in draw(&gpu, &frame, &[layers; PIXELS], &look, [0.0, 0.0, 0.0, 1.0]) {
            let color = Vec3::from_slice(&pixel[..3]);
            assert!(
                color.is_finite() && color.cmple(plate).all() && color.cmpge(Vec3::ZERO).all(),
                "{color}"
            );
            brightest = brightest.max(color);
        }
        // It is white all the same, where there is foam and not only its depth.
        assert!(layer == 3 || brightest.min_element() > 0.1 * plate.min_element(), "{brightest} of {plate}");
    }
    // What is brighter than foam is dimmed by it, not added to.
    let bright = (10.0 * plate.max_element()).ceil();
    for pixel in draw(&gpu, &frame, &some_layers(), &look, [bright, bright, bright, 1.0]) {
        assert!(pixel[..3].iter().all(|c| *c <= bright));
    }
}

#[test]
fn bubbles_are_dimmed_by_the_water_above_them_and_spray_is_not() {
    let gpu = gpu();
    let frame = pool(&tiled_scene());
    let look = look(&frame, 0.0);
    let steps = FoamDrop::STEPS;
    let is_water: Vec<bool> = frame.water.thickness.iter().map(|t| *t > 0.3).collect();
    let mean = |layers: [u32; 4]| {
        let picture = draw(&gpu, &frame, &[layers; PIXELS], &look, [0.0, 0.0, 0.0, 1.0]);
        let shown = picture.iter().zip(&is_water).filter(|(_, is_water)| **is_water);
        let sum: Vec3 = shown.map(|(pixel, _)| Vec3::from_slice(&pixel[..3])).sum();
        sum / is_water.iter().filter(|w| **w).count() as f32
    };
    // At the surface, and two spacings of 0.05 along the view axis deeper: exp(-sigma 0.1 / c), c the cosine to the axis.
    let (top, deep) = (mean([0, 0, steps, 0]), mean([0, 0, steps, 2 * steps]));
    let expected = (-0.1 * Vec3::from(EXTINCTION)).exp();
    // Near the middle of the view; at its border the path is some percent longer.
    assert!((deep / top - expected).abs().max_element() < 0.02, "{} {expected}", deep / top);
    // A surface reflects a few percent at least, so that less comes from bubbles than from foam on it.
    let on = mean([0, steps, 0, 0]);
    assert!(
        (top / on).cmplt(Vec3::splat(0.98)).all() && (top / on).cmpgt(Vec3::splat(0.5)).all(),
        "{}",
        top / on
    );
    // Spray hides what is behind it by its optical depth: of a layer of 1, a share of exp(-1) is left.
    let under = draw(&gpu, &frame, &[[0, 100 * steps, 0, 0]; PIXELS], &look, [0.0; 4]);
    let black = draw(&gpu, &frame, &[[steps, 0, 0, 0]; PIXELS], &look, [0.0; 4]);
    let both = draw(&gpu, &frame, &[[steps, 100 * steps, 0, 0]; PIXELS], &look, [0.0; 4]);
    for ((under, black), both) in under.iter().zip(&black).zip(&both) {
        for c in 0..4 {
            let off = (both[c] - black[c] - (-1.0f32).exp() * under[c]).abs();
            // All three are rounded.
            assert!(off < 1e-5 + 3.0 * Radiance::ROUNDING * both[c], "{off}");
        }
    }
}

#[test]
fn crests_foam_by_their_curvature_and_flat_water_does_not() {
    let gpu = gpu();
    let scene = tiled_scene();
    let mut frame = pool(&scene);
    let black = [0.0, 0.0, 0.0, 1.0];
    let none = [[0; 4]; PIXELS];
    let lit = |frame: &Frame, curvature: f32| {
        let picture = draw(&gpu, frame, &none, &look(frame, curvature), black);
        picture.iter().filter(|pixel| **pixel != black).count()
    };
    assert!(lit(&frame, 2.0) > 50);
    assert_eq!(lit(&frame, 0.0), 0);
    let normal = frame.water.normal[PIXELS / 2 + 48];
    frame.water.normal.fill(normal);
    assert_eq!(lit(&frame, 2.0), 0);
}
