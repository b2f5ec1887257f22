//! Colour by attribute against closed forms and the CPU twin.

mod common;

use common::{Scene, gpu, is_fluid, parallel, params, perspective, ranges_of};
use meniscus_cases::lattice;
use meniscus_gpu::role::{AttributeValues, KeptRange, Particles, SceneDistance, SurfaceColor};
use meniscus_gpu::{Buffer, Gpu, Page, RangeList, Recorder, Texture, Timing};
use meniscus_ssfr::{
    ColoredSet, Coloring, FilterRegistry, NO_VALUE, Radii, ScaleUniform, SplatInput, SplatSet, Ssfr,
    SurfaceImages, twin,
};

/// Red rises from 0 to 1 along the scale.
const TABLE: [[f32; 4]; 2] = [[0.0, 0.0, 0.5, 1.0], [1.0, 0.0, 0.5, 1.0]];

/// Distances of the surface before smoothing, and its colours.
fn color(gpu: &Gpu, scene: &Scene, values: &[f32], scale: ScaleUniform) -> (Vec<f32>, Vec<[f32; 4]>) {
    let params = params("none", 1, 0.0);
    let stage = Ssfr::new(gpu, &FilterRegistry::builtin(), &params).unwrap();
    let images = SurfaceImages::new(gpu, scene.size, &params).unwrap();
    let particles = Page::<Particles>::from_slice(gpu, &scene.particles).unwrap();
    let front = RangeList::from_slice(gpu, &scene.ranges).unwrap();
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
    let values = [Buffer::<AttributeValues>::from_slice(gpu, values).unwrap()];
    let coloring = Coloring::new(gpu, scene.size, &TABLE).unwrap();
    let colors = Texture::<SurfaceColor>::new(gpu, scene.size).unwrap();
    let scene_distance = Texture::<SceneDistance>::new(gpu, scene.size).unwrap();
    scene_distance.write(gpu, &scene.scene_distance);
    let mut recorder = Recorder::new(gpu, Timing::Stamps);
    let camera = recorder.uniform(&scene.uniform());
    stage.record(&mut recorder, gpu, &camera, &[set], &scene_distance, &images);
    let colored = [ColoredSet { set, values: &values }];
    coloring.record(&mut recorder, gpu, &camera, &colored, &scale, &images, &colors);
    let _ = recorder.submit(gpu).unwrap();
    (images.front.read(gpu).unwrap().iter().map(|sphere| sphere[0]).collect(), colors.read(gpu).unwrap())
}

const LINEAR: ScaleUniform = ScaleUniform { offset: 0.0, factor: 1.0, is_log: 0 };

#[test]
fn every_pixel_of_the_surface_has_the_value_of_its_particles_and_no_other_has_one() {
    let gpu = gpu();
    let body = lattice::cuboid([-1.0, -0.7, -4.0], [14, 10, 16], 0.15, 0.3, 1).positions;
    for camera in [perspective(0.0, 0.9), parallel(0.0, 2.5)] {
        let scene = Scene::new(camera, [160, 120], &body, 0.1, 0.15);
        let (distance, colors) = color(&gpu, &scene, &vec![0.25; body.len()], LINEAR);
        for (distance, color) in distance.iter().zip(&colors) {
            let expected = if is_fluid(*distance) { [0.25, 0.0, 0.5, 1.0] } else { [0.0; 4] };
            // Sums are rounded down to 1/65535 per particle, of weights from 0.3 on.
            let off = std::iter::zip(color, expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(off < 1e-3, "{color:?} instead of {expected:?}");
        }
        assert!(distance.iter().filter(|d| is_fluid(**d)).count() > 2000);
    }
}

#[test]
fn a_sphere_that_fills_the_picture_is_coloured_all_over() {
    let gpu = gpu();
    let scene = Scene::new(parallel(0.0, 2.0), [640, 480], &[[0.0, 0.0, -3.0]], 0.9, 1.0);
    let (distance, colors) = color(&gpu, &scene, &[0.25], LINEAR);
    assert!(distance.iter().filter(|d| is_fluid(**d)).count() > 140_000);
    for (distance, color) in distance.iter().zip(&colors) {
        assert_eq!(is_fluid(*distance), color[3] > 0.0);
    }
}

#[test]
fn colours_agree_with_their_twin() {
    let gpu = gpu();
    let body = lattice::cuboid([-1.0, -0.7, -4.0], [14, 10, 16], 0.15, 0.3, 1).positions;
    // Some have no value; the scale is logarithmic and cuts both ends.
    let value = |(i, p): (usize, &[f32; 3])| {
        if i % 7 == 0 { NO_VALUE } else { (3.0 * p[0] + 0.5 * p[1]).exp() }
    };
    let values: Vec<f32> = body.iter().enumerate().map(value).collect();
    let scale = ScaleUniform { offset: -2.0, factor: 0.25, is_log: 1 };
    for (camera, keep) in [(perspective(0.0, 0.9), KeptRange::KEEP_ALL), (parallel(0.0, 2.5), 30_000)] {
        let mut scene = Scene::new(camera, [160, 120], &body, 0.1, 0.15);
        scene.ranges = ranges_of(body.len(), keep);
        scene.radii = Radii::Different;
        let (distance, colors) = color(&gpu, &scene, &values, scale);
        let places = twin::coloring(&scene.view(), &scene.host_set(), &values, &scale, &distance);
        let mut compared = 0;
        for (place, color) in places.iter().zip(&colors) {
            match place {
                Some(place) if color[3] > 0.0 => {
                    // Rounding down of sums, which matters where all weights are small.
                    assert!((place - f64::from(color[0])).abs() < 0.02, "{color:?}, the twin has {place}");
                    compared += 1;
                }
                // Weights below a step are nothing in fixed point.
                Some(_) | None => assert_eq!(color[3], 0.0),
            }
        }
        assert!(compared > 2000, "{compared}");
    }
}

#[test]
fn what_is_far_behind_the_surface_does_not_colour_it() {
    let gpu = gpu();
    let sheet = |z: f32| lattice::cuboid([-1.0, -0.7, z], [14, 10, 1], 0.15, 0.0, 1).positions;
    let (front, back) = (sheet(-4.0), sheet(-4.6));
    let values: Vec<f32> = front.iter().map(|_| 0.0).chain(back.iter().map(|_| 1.0)).collect();
    let both = [front, back].concat();
    let scene = Scene::new(parallel(0.0, 2.5), [160, 120], &both, 0.1, 0.15);
    let (distance, colors) = color(&gpu, &scene, &values, LINEAR);
    // The sheet in front leaves no holes.
    let front = distance.iter().zip(&colors).filter(|(d, _)| **d < 4.2);
    assert!(front.clone().all(|(_, color)| color[0] == 0.0) && front.count() > 2000);
}

#[test]
fn particles_smaller_than_a_pixel_keep_their_colour() {
    let gpu = gpu();
    let scene =
        Scene::new(parallel(0.0, 100.0), [40, 30], &[[1.0, 2.0, -5.0], [30.0, 2.0, -5.0]], 0.01, 0.02);
    let (distance, colors) = color(&gpu, &scene, &[0.75, NO_VALUE], LINEAR);
    let shown: Vec<[f32; 4]> =
        distance.iter().zip(&colors).filter(|(d, _)| is_fluid(**d)).map(|(_, color)| *color).collect();
    assert_eq!(shown.len(), 2);
    assert!((shown[0][0] - 0.75).abs() < 1e-3 && shown[0][3] == 1.0 && shown[1][3] == 0.0, "{shown:?}");
}
