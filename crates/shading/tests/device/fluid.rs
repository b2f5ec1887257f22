//! The `fluid` model against paper answers, on a real device; what every model keeps to is in `conformance.rs`.

use crate::support::{gpu, render, tiled_scene};
use glam::Vec3;
use meniscus_core::{Aabb, Camera, Projection, UpAxis};
use meniscus_gpu::CameraUniform;
use meniscus_gpu::role::{NO_SURFACE, Radiance, Sunlight};
use meniscus_scene::{Scene, Sky};
use meniscus_shading::conformance::{Frame, Water, cast, pack_normal};
use meniscus_shading::{Fluid, FluidParameters, LightingModel, MediumParameters, Surroundings};

const SIZE: [u32; 2] = [96, 64];
const BOUNDS: Aabb = Aabb { min: Vec3::ZERO, max: Vec3::new(2.0, 0.5, 1.0) };

fn cameras() -> [Camera; 2] {
    let perspective = Camera::fit(&BOUNDS.corners(), Vec3::new(-0.4, -0.6, -0.8), Vec3::Y, 0.8, SIZE, 0.9);
    // Far enough for no ray to start below the floor.
    let parallel = Camera {
        eye: perspective.target + (perspective.eye - perspective.target) * 2.0,
        projection: Projection::Orthographic { height_world: 1.4 },
        ..perspective
    };
    [perspective, parallel]
}

fn white_scene() -> Scene {
    let mut scene = tiled_scene();
    scene.floor = None;
    scene.sky = Sky { zenith: [1.0; 3], horizon: [1.0; 3], ground: [1.0; 3], glow: 0.0 };
    scene.sun.irradiance = [0.0; 3];
    scene
}

fn waves(p: Vec3) -> f32 {
    let height = 0.3 + 0.05 * (7.0 * p.x + 3.0 * p.z).sin() + 0.02 * (19.0 * p.z - 6.0 * p.x).sin();
    let q = (p - BOUNDS.center().with_y(0.0)).abs() - Vec3::new(1.0, height, 0.5);
    let drop = p.distance(Vec3::new(1.6, 0.47, 0.3)) - 0.05;
    (0.7 * q.max_element()).min(drop)
}

fn wavy_pool(camera: &Camera) -> Water {
    cast(&CameraUniform::new(camera, SIZE), BOUNDS, 0.01, waves)
}

/// No sky: no reflection on top of the transmitted light.
fn black(scene: Scene) -> Scene {
    Scene { sky: Sky { zenith: [0.0; 3], horizon: [0.0; 3], ground: [0.0; 3], glow: 0.0 }, ..scene }
}

/// Flat water over a white floor, seen straight down, whose thickness grows from left to right; and the thickness per pixel.
fn wedge(scene: &Scene) -> (Frame, Vec<f32>) {
    let camera = Camera {
        eye: Vec3::new(0.0, 10.0, 0.0),
        target: Vec3::ZERO,
        up: Vec3::NEG_Z,
        projection: Projection::Orthographic { height_world: 1.0 },
        near: 0.1,
    };
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    let thickness: Vec<f32> = (0..pixels).map(|i| 0.05 + 0.02 * (i % SIZE[0] as usize) as f32).collect();
    let water = Water {
        distance: vec![8.0; pixels],
        thickness: thickness.clone(),
        normal: vec![pack_normal(Vec3::Z); pixels],
    };
    (Frame::plain(&camera, SIZE, scene, water, [1.0; 4], 1e3), thickness)
}

/// Beer-Lambert wedge (`algorithms.md` 14.8): thickness grows from left to right over a white floor, seen straight down, so
/// the logarithm of the colour falls linearly with slope -sigma.
#[test]
fn a_wedge_darkens_exponentially_with_the_given_slope() {
    let gpu = gpu();
    let (mut frame, thickness) = wedge(&black(white_scene()));
    let given = MediumParameters {
        attenuation_color: [1.5, 0.5, 0.1],
        attenuation_depth: Some(1.0),
        turbidity: 0.0,
        ..Default::default()
    };
    let pure = MediumParameters { pure_water: true, ..given.clone() };
    let millimetres = MediumParameters { attenuation_scale: 1e3, ..pure.clone() };
    // Pope & Fry 1997, as stated in `algorithms.md` 10; in millimetres a thousand times as much stands for the same.
    let published = [0.45, 0.07, 0.02];
    let transmitted = 1.0 - ((1.333f32 - 1.0) / (1.333 + 1.0)).powi(2);
    for (medium, metres_per_world, sigma) in [
        (given, 1.0, [1.5, 0.5, 0.1]),
        (pure.clone(), 1.0, published),
        (pure, 1e-3, published.map(|k| k * 1e-3)),
        (millimetres, 1e-3, published),
    ] {
        frame.scale.metres_per_world = metres_per_world;
        let model = Fluid::new(FluidParameters { medium, ..Default::default() }).unwrap();
        let twin = frame.twin(&model);
        for ((pixel, twin), t) in render(&frame, &gpu, &model).iter().zip(&twin).zip(&thickness) {
            for c in 0..3 {
                for (value, rounding) in [(pixel[c], Radiance::ROUNDING), (twin[c], 0.0)] {
                    let slope = (value / transmitted).ln() / -t;
                    // 1e-4: the logarithm of numbers near 1 in f32.
                    let tolerance = 1e-4 + (1e-4 + rounding) / t;
                    assert!((slope - sigma[c]).abs() < tolerance, "{slope} at thickness {t}");
                }
            }
        }
    }
}

/// What waves gather on the floor is seen sharply through little water and not at all through much: against a floor that is lit
/// evenly, it falls with 1.5 times the mean extinction on top of what the water absorbs.
#[test]
fn caustics_blur_with_the_water_that_they_are_seen_through() {
    let gpu = gpu();
    let mut scene = black(white_scene());
    scene.sun.irradiance = [1.0; 3];
    let (mut frame, thickness) = wedge(&scene);
    let attenuation_color = [1.5f32, 0.5, 0.1];
    let medium = MediumParameters {
        attenuation_color,
        attenuation_depth: Some(1.0),
        turbidity: 0.0,
        ..Default::default()
    };
    let model = Fluid::new(FluidParameters { medium, ..Default::default() }).unwrap();
    let mut lit = |focus: f32| {
        frame.sunlight = vec![Sunlight::pack(0.0, focus, 1.0)];
        render(&frame, &gpu, &model)
    };
    let (evenly, gathered) = (lit(1.0), lit(2.0));
    let blurring = 1.5 * attenuation_color.iter().sum::<f32>() / 3.0;
    let transmitted = 1.0 - ((1.333f32 - 1.0) / (1.333 + 1.0)).powi(2);
    for ((even, gathered), t) in evenly.iter().zip(&gathered).zip(&thickness) {
        for c in 0..3 {
            let difference = gathered[c] - even[c];
            let slope = (difference / transmitted).ln() / -t;
            let expected = attenuation_color[c] + blurring;
            // 5e-4: the logarithm of a difference of numbers near 1 in f32, which down to exp(-4) are left. Both are rounded.
            let rounding = Radiance::ROUNDING * (gathered[c] + even[c]) / difference;
            let tolerance = 5e-4 + (5e-4 + rounding) / t;
            assert!((slope - expected).abs() < tolerance, "{slope}, not {expected}, at {t}");
        }
    }
}

/// A ball in a slab with a flat surface, seen obliquely in parallel projection: a pixel shows the ball where its refracted
/// ray meets the ball by Snell's law, once, without rings of it where the ray passes behind the ball's silhouette.
#[test]
fn a_ball_under_water_is_seen_once_and_where_snell_says() {
    const SIZE: [u32; 2] = [160, 120];
    const DEPTH: f32 = 1.0;
    let center = Vec3::new(0.0, 0.55, 0.0);
    let radius = 0.2;
    let towards_eye = Vec3::new(0.0, 0.6, 0.8);
    let camera = Camera {
        eye: center + 10.0 * towards_eye,
        target: center,
        up: Vec3::Y,
        projection: Projection::Orthographic { height_world: 1.5 },
        near: 0.1,
    };
    let uniform = CameraUniform::new(&camera, SIZE);
    let slab = Aabb { min: Vec3::new(-4.0, 0.0, -4.0), max: Vec3::new(4.0, DEPTH, 4.0) };
    let mut water = cast(&uniform, slab, 0.02, |p| p.y - DEPTH);
    let solid = cast(&uniform, slab, 0.002, |p| (p.distance(center) - radius).min(p.y - 0.01));
    let is_ball = |i: usize| {
        let [x, y] = position_px(&uniform, i);
        (x * x + y * y).sqrt() < radius
    };
    let scene = white_scene();
    for (i, thickness) in water.thickness.iter_mut().enumerate() {
        *thickness = solid.distance[i] - water.distance[i];
    }
    let mut frame = Frame::plain(&camera, SIZE, &scene, water, [1.0; 4], NO_SURFACE);
    frame.scene_distance = solid.distance;
    frame.objects = Some(Aabb { min: center - radius, max: center + radius });
    for i in 0..frame.scene_color.len() {
        if is_ball(i) {
            frame.scene_color[i] = [0.0, 0.0, 0.0, 1.0];
        }
    }
    let medium = MediumParameters { attenuation_color: [0.0; 3], turbidity: 0.0, ..Default::default() };
    let clear = FluidParameters { medium, ..Default::default() };
    let image = render(&frame, &gpu(), &Fluid::new(clear).unwrap());
    let bent = {
        let eta = 1.0 / 1.333f32;
        let sine = eta * towards_eye.z;
        Vec3::new(0.0, -(1.0 - sine * sine).sqrt(), -sine)
    };
    let world_from_view = glam::Mat4::from_cols_array_2d(&uniform.world_from_view);
    let (mut wrong, mut seen, mut broken_rows) = (0, 0, 0);
    for row in 0..SIZE[1] as usize {
        let dark = |i: usize| image[i][0] < 0.5;
        let pixels = row * SIZE[0] as usize..(row + 1) * SIZE[0] as usize;
        let changes = pixels.clone().skip(1).filter(|&i| dark(i) != dark(i - 1)).count();
        broken_rows += usize::from(changes > 2);
        for i in pixels {
            let [x, y] = position_px(&uniform, i);
            let enters = world_from_view.transform_point3(Vec3::new(x, y, -frame.water.distance[i]));
            let along = (center - enters).dot(bent);
            let meets = (enters + along * bent).distance(center) < radius;
            seen += usize::from(meets);
            wrong += usize::from(meets != dark(i));
        }
    }
    assert!(seen > 500, "{seen}");
    // One row: at the upper limb, steep for the camera, surface and silhouette are alike.
    assert!(broken_rows <= 1, "{broken_rows} rows change more than twice");
    // 25 %: a ray that meets the side turned away from the camera, or that would go on past the ball from where the straight
    // view ray ends, cannot be told from one view.
    assert!(wrong * 100 <= seen * 25, "{wrong} of {seen}");
}

/// View-space x and y of the middle of a pixel, parallel projection.
fn position_px(camera: &CameraUniform, pixel: usize) -> [f32; 2] {
    let [width, height] = camera.size_px.map(|n| n as usize);
    let [half_width, half_height] = camera.half_extent;
    let middle = |at: usize, of: usize| 2.0 * (at as f32 + 0.5) / of as f32 - 1.0;
    [half_width * middle(pixel % width, width), -half_height * middle(pixel / width, height)]
}

#[test]
fn parameters_change_the_picture_and_bad_ones_do_not() {
    let gpu = gpu();
    let model = Fluid::default();
    let mut pass = model.compile(&gpu).unwrap();
    let bad = serde_json::json!({"refractive_index": 0.5});
    assert!(pass.set_parameters(bad.as_object().unwrap()).is_err());
    let mut parameters = model.parameters();
    parameters["turbidity"] = 3.0.into();
    pass.set_parameters(&parameters).unwrap();

    let scene = Scene::around(BOUNDS, UpAxis::Y, 0.0);
    assert_eq!(Surroundings::new(&scene).has_floor, 1);
    let [camera, _] = cameras();
    let frame = Frame::plain(&camera, SIZE, &scene, wavy_pool(&camera), [0.5; 4], 1e3);
    let turbid = Fluid::from_parameters(&parameters).unwrap();
    assert_ne!(render(&frame, &gpu, &model), render(&frame, &gpu, &turbid));
}

/// Spray whitens a single drop, and neither waves nor the edges of the pool.
#[test]
fn spray_is_for_single_drops() {
    let gpu = gpu();
    let [camera, _] = cameras();
    let pool = |p: Vec3| if p.y > 0.4 { 1.0 } else { waves(p) };
    let without_drop = cast(&CameraUniform::new(&camera, SIZE), BOUNDS, 0.01, pool).distance;
    let frame = Frame::plain(&camera, SIZE, &tiled_scene(), wavy_pool(&camera), [0.1, 0.1, 0.1, 1.0], 1e3);
    let image =
        |spray| render(&frame, &gpu, &Fluid::new(FluidParameters { spray, ..Default::default() }).unwrap());
    let whitened: Vec<usize> = image(0.0)
        .iter()
        .zip(image(1.0))
        .enumerate()
        .filter_map(|(i, (clear, white))| (white[2] - clear[2] > 0.1).then_some(i))
        .collect();
    let (drop, rest): (Vec<usize>, Vec<usize>) =
        whitened.into_iter().partition(|&i| frame.water.distance[i] < without_drop[i]);
    assert!(drop.len() >= 5, "{drop:?}");
    // The pool's corners stick out to all sides in the picture, as a drop does: a few pixels each.
    assert!(rest.len() <= 20, "{rest:?}");
}
