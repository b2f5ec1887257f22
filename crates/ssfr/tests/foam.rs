//! Layers of foam against closed forms and the CPU twin.

mod common;

use std::f64::consts::PI;

use common::{Scene, gpu, is_fluid, parallel, params, perspective};
use meniscus_cases::lattice;
use meniscus_gpu::role::{FoamDrop, FoamDrops, FoamLayers, NO_SURFACE, SceneDistance};
use meniscus_gpu::{Buffer, Gpu, Image, Page, Recorder, Texture, Timing};
use meniscus_ssfr::{
    FilterRegistry, FoamSplats, FoamUniform, SplatInput, SplatSet, Ssfr, SurfaceImages, twin,
};

/// Smoothed distances of the surface, and optical depths of the layers.
fn draw(gpu: &Gpu, scene: &Scene, drops: &[FoamDrop], widening: f32) -> (Vec<f32>, Vec<[f64; 4]>) {
    let params = params("none", 1, 0.0);
    let stage = Ssfr::new(gpu, &FilterRegistry::builtin(), &params).unwrap();
    let images = SurfaceImages::new(gpu, scene.size, &params).unwrap();
    let particles = Page::from_slice(gpu, &scene.particles).unwrap();
    let front = meniscus_gpu::RangeList::from_slice(gpu, &scene.ranges).unwrap();
    let pages = [SplatInput {
        particles: &particles,
        shapes: None,
        front: &front,
        tested: None,
        mass: &front,
        stand_ins: None,
    }];
    let set = SplatSet {
        pages: &pages,
        radius_world: scene.radius,
        volume_world: scene.spacing.powi(3),
        radii: scene.radii,
        is_uniform_mass: true,
        is_in_front: false,
        most_half_px: f32::INFINITY,
        most_radius_px: f32::INFINITY,
        front_half_px: 0.0,
        most_thickness: f64::INFINITY,
    };
    let scene_distance = Texture::<SceneDistance>::new(gpu, scene.size).unwrap();
    scene_distance.write(gpu, &scene.scene_distance);
    let layers = Image::<FoamLayers>::new(gpu, scene.size).unwrap();
    // In two pages.
    let buffers = drops.split_at(drops.len() / 3);
    let buffers = [buffers.0, buffers.1].map(|page| Buffer::<FoamDrops>::from_slice(gpu, page).unwrap());
    let pages = [0, 1].map(|page| (&buffers[page], uniform(scene, buffers[page].len(), widening)));
    let splats = FoamSplats::new(gpu);
    let mut recorder = Recorder::new(gpu, Timing::Stamps);
    let camera = recorder.uniform(&scene.uniform());
    stage.record(&mut recorder, gpu, &camera, &[set], &scene_distance, &images);
    // The second time over what the first has left.
    for _ in 0..2 {
        splats.record(&mut recorder, gpu, &camera, &pages, &images, &scene_distance, &layers);
    }
    let _ = recorder.submit(gpu).unwrap();
    let depth = |steps: [u32; 4]| steps.map(|steps| f64::from(steps) / f64::from(FoamDrop::STEPS));
    (images.distance.read(gpu).unwrap(), layers.read(gpu).unwrap().into_iter().map(depth).collect())
}

fn uniform(scene: &Scene, count: usize, widening: f32) -> FoamUniform {
    FoamUniform { spacing_world: scene.spacing, widening, amount: 0.5, count: count as u32 }
}

/// A cloud of drops in and around a block of water.
fn cloud() -> Vec<FoamDrop> {
    let drop = |i: usize| {
        let roll = |k: usize| ((i * 2 + 1) * [40_503, 30_011, 51_229, 7_919][k] % 65_536) as f32 / 65_536.0;
        let center = [2.0 * roll(0) - 1.0, 1.6 * roll(1) - 0.8, -5.5 + 2.5 * roll(2)];
        FoamDrop::new(center, 0.05 + 0.6 * roll(3), 0.2 + roll(1))
    };
    (0..600).map(drop).collect()
}

#[test]
fn layers_agree_with_their_twin() {
    let gpu = gpu();
    let body = lattice::cuboid([-0.7, -0.5, -4.5], [10, 7, 5], 0.15, 0.3, 1).positions;
    for (camera, widening) in [(perspective(0.0, 0.9), 1.0), (parallel(0.0, 2.5), 1.5)] {
        let mut scene = Scene::new(camera, [160, 120], &body, 0.1, 0.15);
        // An opaque object covers a quarter of the picture.
        for (i, distance) in scene.scene_distance.iter_mut().enumerate() {
            *distance = if i % 160 < 80 && i / 160 < 60 { 4.6 } else { NO_SURFACE };
        }
        let drops = cloud();
        let (distance, found) = draw(&gpu, &scene, &drops, widening);
        let all = uniform(&scene, drops.len(), widening);
        let expected = twin::foam(&scene.view(), &all, &drops, &distance, &scene.scene_distance);
        let mut sums = [0.0; 4];
        for (pixel, (found, expected)) in found.iter().zip(&expected).enumerate() {
            for layer in 0..4 {
                // Each of the some ten drops of a pixel is rounded to 1/4096, depths count up to some ten spacings; coordinates are
                // of single precision, which moves a drop's rim, where it is thin.
                let tolerance = 0.01 + 2e-3 * expected[layer];
                assert!(
                    (found[layer] - expected[layer]).abs() < tolerance,
                    "layer {layer} of pixel {pixel}: {found:?}, the twin has {expected:?}"
                );
                sums[layer] += expected[layer];
            }
        }
        assert!(sums.iter().all(|sum| *sum > 40.0), "{sums:?}");
        assert!(distance.iter().filter(|d| is_fluid(**d)).count() > 1000);
    }
}

/// One drop before, in and behind a sheet of water whose spheres begin at distance 3.95.
#[test]
fn a_drop_is_in_front_of_the_surface_in_it_or_behind() {
    let gpu = gpu();
    let sheet = lattice::cuboid([-1.0, -0.75, -4.1], [21, 16, 1], 0.1, 0.0, 1).positions;
    let scene = Scene::new(parallel(0.0, 1.0), [60, 60], &sheet, 0.1, 0.1);
    let layers_at = |distance: f32| {
        let drop = FoamDrop::new([0.0, 0.0, -distance], 2.0, 1.0);
        // The sum over the picture; a second drop far outside of it takes no part.
        let far = FoamDrop::new([50.0, 0.0, -4.0], 2.0, 1.0);
        let (_, layers) = draw(&gpu, &scene, &[drop, far], 1.0);
        (0..4).map(|layer| layers.iter().map(|l| l[layer]).sum::<f64>()).collect::<Vec<_>>()
    };
    // The integral of the profile (1 - q)^2 is a third of the disc: 24 pixels are a spacing.
    let whole = 0.5 * PI * (2.0 * 6.0_f64).powi(2) / 3.0;
    for (distance, layer) in [(3.7, 0), (3.96, 1), (4.5, 2)] {
        let found = layers_at(distance);
        let others: f64 = (0..3).filter(|other| *other != layer).map(|other| found[other]).sum();
        // The sum over pixels for the integral.
        assert!((found[layer] / whole - 1.0).abs() < 0.02 && others == 0.0, "{distance}: {found:?}, {whole}");
    }
    // In spacings, up to one of which the surface lies behind the spheres' front.
    let behind = layers_at(4.5);
    assert!((4.5..5.5).contains(&(behind[3] / behind[2])), "{behind:?}");
}

#[test]
fn opaque_objects_hide_foam_and_drops_at_the_eye_are_left_out() {
    let gpu = gpu();
    let mut scene = Scene::new(perspective(0.0, 0.9), [60, 60], &[], 0.1, 0.1);
    let drops = [FoamDrop::new([0.0, 0.0, -4.0], 5.0, 1.0), FoamDrop::new([0.0, 0.0, -0.02], 5.0, 1.0)];
    let total = |layers: &[[f64; 4]]| layers.iter().flatten().sum::<f64>();
    let seen = total(&draw(&gpu, &scene, &drops, 1.0).1);
    scene.scene_distance.fill(3.9);
    assert_eq!(total(&draw(&gpu, &scene, &drops, 1.0).1), 0.0);
    scene.scene_distance.fill(4.1);
    assert_eq!(total(&draw(&gpu, &scene, &drops, 1.0).1), seen);
    assert_eq!(total(&draw(&gpu, &scene, &drops[..1], 1.0).1), seen);
    assert!(seen > 10.0);
}

/// What drops take of light does not depend on how far away they are, but for the area that they cover.
#[test]
fn far_drops_take_as_much_light_as_their_area() {
    let gpu = gpu();
    let taken = |height: f32, x: f32| {
        let scene = Scene::new(parallel(0.0, height), [60, 60], &[], 0.1, 0.1);
        let (_, layers) = draw(&gpu, &scene, &[FoamDrop::new([x, 0.0, -4.0], 3.0, 1.4); 3], 1.0);
        let pixel = f64::from(height) / 60.0;
        layers.iter().flatten().sum::<f64>() * pixel * pixel
    };
    let near = taken(1.0, 0.0);
    // Down to a fiftieth of a pixel, wherever it lies in it; there all are a few dozen steps of 1/4096.
    for (height, x) in [(5.0, 0.0), (20.0, 0.1), (60.0, 0.3), (200.0, 1.1)] {
        let ratio = taken(height, x) / near;
        assert!((ratio - 1.0).abs() < 0.1, "{height}: {ratio}");
    }
}
