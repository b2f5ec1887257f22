//! The `fluid` model against paper answers and against its twin, on a real device.

use crate::support::{Frame, Water, cast, gpu, pack_normal, tiled_scene};
use glam::Vec3;
use meniscus_core::{Aabb, Camera, Projection, UpAxis};
use meniscus_gpu::CameraUniform;
use meniscus_gpu::role::NO_SURFACE;
use meniscus_scene::{Scene, Sky};
use meniscus_shading::{Fluid, FluidParameters, LightingModel, Surroundings, WaterScale};

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

/// Furnace test (`algorithms.md` 14.7): what is white all around stays white, whatever the surface does, with scattering
/// and spray but without absorption.
#[test]
fn white_surroundings_make_a_flat_white_image() {
    let gpu = gpu();
    let model = Fluid::new(FluidParameters { attenuation_color: [0.0; 3], ..Default::default() }).unwrap();
    for camera in cameras() {
        let frame = Frame::plain(&camera, SIZE, &white_scene(), wavy_pool(&camera), [1.0; 4], 1e3);
        assert!(frame.water.distance.iter().filter(|d| **d < NO_SURFACE).count() > 1000);
        for pixel in frame.render(&gpu, &model) {
            // 1e-3: irradiance by quadrature, and sums of weights in f32.
            assert!(pixel.iter().all(|c| (c - 1.0).abs() < 1e-3), "{pixel:?}");
        }
    }
}

/// Beer-Lambert wedge (`algorithms.md` 14.8): thickness grows from left to right over a white floor, seen straight down, so
/// the logarithm of the colour falls linearly with slope -sigma.
#[test]
fn a_wedge_darkens_exponentially_with_the_given_slope() {
    let gpu = gpu();
    let camera = Camera {
        eye: Vec3::new(0.0, 10.0, 0.0),
        target: Vec3::ZERO,
        up: Vec3::NEG_Z,
        projection: Projection::Orthographic { height_world: 1.0 },
        near: 0.1,
    };
    let mut scene = white_scene();
    // Black sky: no reflection on top of the transmitted light.
    scene.sky = Sky { zenith: [0.0; 3], horizon: [0.0; 3], ground: [0.0; 3], glow: 0.0 };
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    let thickness: Vec<f32> = (0..pixels).map(|i| 0.05 + 0.02 * (i % SIZE[0] as usize) as f32).collect();
    let water = Water {
        distance: vec![8.0; pixels],
        thickness: thickness.clone(),
        normal: vec![pack_normal(Vec3::Z); pixels],
    };
    let mut frame = Frame::plain(&camera, SIZE, &scene, water, [1.0; 4], 1e3);
    let given = FluidParameters {
        attenuation_color: [1.5, 0.5, 0.1],
        attenuation_depth: Some(1.0),
        turbidity: 0.0,
        ..Default::default()
    };
    let pure = FluidParameters { pure_water: true, ..given.clone() };
    let millimetres = FluidParameters { attenuation_scale: 1e3, ..pure.clone() };
    // Pope & Fry 1997, as stated in `algorithms.md` 10; in millimetres a thousand times as much stands for the same.
    let published = [0.45, 0.07, 0.02];
    let transmitted = 1.0 - ((1.333f32 - 1.0) / (1.333 + 1.0)).powi(2);
    for (parameters, metres_per_world, sigma) in [
        (given, 1.0, [1.5, 0.5, 0.1]),
        (pure.clone(), 1.0, published),
        (pure, 1e-3, published.map(|k| k * 1e-3)),
        (millimetres, 1e-3, published),
    ] {
        frame.scale.metres_per_world = metres_per_world;
        let model = Fluid::new(parameters).unwrap();
        let twin = frame.twin(&model);
        for ((pixel, twin), t) in frame.render(&gpu, &model).iter().zip(&twin).zip(&thickness) {
            for c in 0..3 {
                for value in [pixel[c], twin[c]] {
                    let slope = (value / transmitted).ln() / -t;
                    // 1e-4: the logarithm of numbers near 1 in f32.
                    assert!((slope - sigma[c]).abs() < 1e-4 * (1.0 + 1.0 / t), "{slope} at thickness {t}");
                }
            }
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
    for i in 0..frame.scene_color.len() {
        if is_ball(i) {
            frame.scene_color[i] = [0.0, 0.0, 0.0, 1.0];
        }
    }
    let clear = FluidParameters { attenuation_color: [0.0; 3], turbidity: 0.0, ..Default::default() };
    let image = frame.render(&gpu(), &Fluid::new(clear).unwrap());
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

/// The GPU follows the twin for both projections, over a drawn scene with floor and sky, at the borders too.
#[test]
fn the_pass_follows_its_twin() {
    let gpu = gpu();
    let model = Fluid::default();
    for camera in cameras() {
        let scene = tiled_scene();
        let water = wavy_pool(&camera);
        let mut frame = Frame::plain(&camera, SIZE, &scene, water, [0.0; 4], NO_SURFACE);
        floor_by_hand(&mut frame);
        let (found, expected) = (frame.render(&gpu, &model), frame.twin(&model));
        let mut worst: Vec<f32> = found
            .iter()
            .zip(&expected)
            .map(|(f, e)| (0..4).map(|c| (f[c] - e[c]).abs() / (0.05 + e[c].abs())).fold(0.0, f32::max))
            .collect();
        worst.sort_by(f32::total_cmp);
        // Rounding: 1e-3 relative nearly everywhere. At the rim of the water a last bit decides which pixel a refracted ray
        // samples, and a mirrored ray near the horizon whether it meets the floor: under 1 % of the pixels.
        assert!(worst[worst.len() * 99 / 100] < 1e-3, "99th percentile {}", worst[worst.len() * 99 / 100]);
        let mean = worst.iter().sum::<f32>() / worst.len() as f32;
        assert!(mean < 1e-3, "mean {mean}");
    }
}

/// A floor with a coarse pattern and its exact distance, so that the march and the bilinear fetch matter.
fn floor_by_hand(frame: &mut Frame) {
    let camera = frame.camera;
    let floor = cast(
        &camera,
        Aabb { min: Vec3::new(-3.0, -0.1, -3.0), max: Vec3::new(5.0, 0.004, 4.0) },
        0.002,
        |p| p.y - 0.003,
    );
    for (i, &d) in floor.distance.iter().enumerate() {
        if d < NO_SURFACE {
            frame.scene_distance[i] = d;
            // Exact in half precision.
            let shade = 0.25 + 0.5 * ((i / 7 + i / SIZE[0] as usize / 5) % 2) as f32;
            frame.scene_color[i] = [shade, 0.5, 0.75, 1.0];
        }
    }
}

#[test]
fn water_behind_an_object_and_no_water_show_the_scene() {
    let gpu = gpu();
    let [camera, _] = cameras();
    let mut frame =
        Frame::plain(&camera, SIZE, &tiled_scene(), wavy_pool(&camera), [0.25, 0.5, 0.75, 1.0], 1e-2);
    assert!(frame.render(&gpu, &Fluid::default()).iter().all(|p| *p == [0.25, 0.5, 0.75, 1.0]));
    frame.scene_distance.fill(NO_SURFACE);
    let image = frame.render(&gpu, &Fluid::default());
    assert!(image.iter().any(|p| *p != [0.25, 0.5, 0.75, 1.0]));
}

/// No jump where water ends: as the thickness goes to zero the picture goes to the scene.
#[test]
fn vanishing_thickness_is_the_scene() {
    let gpu = gpu();
    let [camera, _] = cameras();
    let mut water = wavy_pool(&camera);
    water.thickness.iter_mut().for_each(|t| *t = t.min(1e-5));
    let frame = Frame::plain(&camera, SIZE, &tiled_scene(), water, [0.25, 0.5, 0.75, 1.0], 1e3);
    for pixel in frame.render(&gpu, &Fluid::default()) {
        for (c, scene) in [0.25, 0.5, 0.75].into_iter().enumerate() {
            // 1e-3: the soft edge at a thousandth of its width, times a radiance of at most some tens.
            assert!((pixel[c] - scene).abs() < 1e-3, "{pixel:?}");
        }
    }
}

#[test]
fn absurd_inputs_stay_finite() {
    let gpu = gpu();
    let [camera, parallel] = cameras();
    let odd_normals = [0u32, u32::MAX, 0x8000_8000, 0x7fff_7fff, 0x8001_0000];
    for camera in [camera, parallel] {
        let mut frame = Frame::plain(&camera, SIZE, &tiled_scene(), wavy_pool(&camera), [1.0; 4], NO_SURFACE);
        for i in 0..frame.water.distance.len() {
            frame.water.distance[i] = [1e-3, 5.0, 1e12, 1e30, NO_SURFACE][i % 5];
            frame.water.thickness[i] = [0.0, -1.0, 1e-30, 1e6, 1e20, 0.3][i % 6];
            frame.water.normal[i] = odd_normals[i % 7 % 5];
        }
        for depth_world in [0.0, 1e-20, 1.0, 1e20, f32::NAN] {
            frame.scale = WaterScale { depth_world, spacing_world: depth_world, metres_per_world: 1.0 };
            for pixel in frame.render(&gpu, &Fluid::default()) {
                assert!(pixel.iter().all(|c| c.is_finite() && *c >= 0.0), "depth {depth_world}: {pixel:?}");
            }
        }
    }
}

#[test]
fn one_pixel_and_odd_sizes_work_and_repeat_bit_for_bit() {
    let gpu = gpu();
    for size in [[1, 1], [1, 7], [33, 1], [13, 9]] {
        let camera = Camera::fit(&BOUNDS.corners(), Vec3::new(-0.4, -0.6, -0.8), Vec3::Y, 0.8, size, 0.5);
        let water = cast(&CameraUniform::new(&camera, size), BOUNDS, 0.02, waves);
        let frame = Frame::plain(&camera, size, &tiled_scene(), water, [0.5; 4], NO_SURFACE);
        let image = frame.render(&gpu, &Fluid::default());
        assert_eq!(image.len(), (size[0] * size[1]) as usize);
        assert_eq!(image, frame.render(&gpu, &Fluid::default()));
    }
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
    assert_ne!(frame.render(&gpu, &model), frame.render(&gpu, &turbid));
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
        |spray| frame.render(&gpu, &Fluid::new(FluidParameters { spray, ..Default::default() }).unwrap());
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
