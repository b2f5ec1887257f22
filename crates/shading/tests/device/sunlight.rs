//! Shadows and caustics against rays and closed forms.

use glam::{Mat4, Vec2, Vec3};
use meniscus_core::{Aabb, Camera, Projection};
use meniscus_gpu::role::{
    EyeDistance, NO_SURFACE, SceneColor, SceneDistance, Sunlight, Thickness, ViewNormal,
};
use meniscus_gpu::{CameraUniform, Gpu, Image, Recorder, Texture, Timing};
use meniscus_scene::{Material, Mesh, Object, Scene, Sides};
use meniscus_shading::conformance::pack_normal;
use meniscus_shading::{Caustics, CausticsPass, CausticsScratch, SunView, SunWater, SunlightPass, Waves};

use crate::support::{draw_scene, gpu, tiled_scene, world_ray};

const SIZE: [u32; 2] = [96, 72];
const SUN_SIZE: [u32; 2] = [256, 256];

/// Looks along the sun's rays at a square of `height` around `target`.
fn sun_camera(scene: &Scene, target: Vec3, height_world: f32) -> CameraUniform {
    let camera = Camera {
        eye: target + 5.0 * scene.sun.direction,
        target,
        up: scene.sun.direction.any_orthonormal_vector(),
        projection: Projection::Orthographic { height_world },
        near: 1e-3,
    };
    CameraUniform::new(&camera, SUN_SIZE)
}

/// Where the ray through the middle of a pixel meets the floor at y = 0.
fn on_floor(camera: &CameraUniform, pixel: usize) -> Option<Vec3> {
    let (origin, along) = world_ray(camera, pixel);
    (along.y < 0.0).then(|| origin - along * (origin.y / along.y))
}

/// How far inside of `bounds` a ray gets, by slabs; negative where it passes by.
fn meets(origin: Vec3, direction: Vec3, bounds: Aabb) -> f32 {
    let (a, b) = ((bounds.min - origin) / direction, (bounds.max - origin) / direction);
    a.max(b).min_element() - a.min(b).max_element().max(0.0)
}

#[test]
fn objects_throw_shadows_where_they_stand_between_sun_and_floor() {
    let gpu = gpu();
    let bounds = Aabb { min: Vec3::new(0.7, 0.0, 0.3), max: Vec3::new(1.2, 0.6, 0.7) };
    let mut scene = tiled_scene();
    let material = Material { scale: 0.5, ..Material::named("concrete").unwrap() };
    scene.objects.push(Object {
        name: "box".into(),
        mesh: Mesh::cuboid(bounds),
        material,
        sides: Sides::Both,
    });
    // From the side that is turned away from the sun.
    let camera = Camera {
        eye: bounds.center() + Vec3::new(-2.0, 3.0, -2.0) * (scene.sun.direction.with_y(1.0)),
        target: bounds.center() - 0.5 * scene.sun.direction.with_y(0.6),
        up: Vec3::Y,
        projection: Projection::Perspective { fovy_rad: 0.7 },
        near: 0.01,
    };
    let camera = CameraUniform::new(&camera, SIZE);
    let sun = sun_camera(&scene, bounds.center(), 3.0);
    let (_, seen) = draw_scene(&gpu, &sun, &scene, None);
    let sun = SunView { camera: &sun, scene_distance: &seen };
    let lit = read(&gpu, &draw_scene(&gpu, &camera, &scene, None).0);
    let shadowed = read(&gpu, &draw_scene(&gpu, &camera, &scene, Some(&sun)).0);
    let eye = Mat4::from_cols_array_2d(&camera.world_from_view).w_axis.truncate();
    let (mut dark, mut light) = (0, 0);
    for (i, (with, without)) in shadowed.iter().zip(&lit).enumerate() {
        let Some(floor) = on_floor(&camera, i) else { continue };
        // The box itself, and its silhouette to within a pixel.
        if meets(eye, floor - eye, bounds.inflated(0.03)) > 0.0 {
            continue;
        }
        let inside = meets(floor, scene.sun.direction, bounds);
        // Two pixels of the sun's picture, over the floor's slope, and a pixel of the camera's.
        if inside > 0.1 {
            assert!(with[0] < 0.6 * without[0], "pixel {i} lies in shadow: {with:?} of {without:?}");
            dark += 1;
        } else if inside < 0.0 && meets(floor, scene.sun.direction, bounds.inflated(0.08)) < 0.0 {
            assert_eq!(with, without, "pixel {i} lies in the sun");
            light += 1;
        }
    }
    assert!(dark > 50 && light > 1000, "{dark} in shadow, {light} in the sun");
}

fn read(gpu: &Gpu, color: &Texture<SceneColor>) -> Vec<[f32; 4]> {
    color.read_floats(gpu).unwrap()
}

/// The sun straight above water `depth` over a level floor, and the images of it.
struct Above {
    camera: CameraUniform,
    scene_distance: Texture<SceneDistance>,
}

const EYE: f32 = 2.0;

fn above(gpu: &Gpu, height_world: f32) -> Above {
    let camera = Camera {
        eye: Vec3::new(0.0, EYE, 0.0),
        target: Vec3::ZERO,
        up: Vec3::Z,
        projection: Projection::Orthographic { height_world },
        near: 1e-3,
    };
    let scene_distance = Texture::new(gpu, SUN_SIZE).unwrap();
    scene_distance.write(gpu, bytemuck::cast_slice(&vec![EYE; (SUN_SIZE[0] * SUN_SIZE[1]) as usize]));
    Above { camera: CameraUniform::new(&camera, SUN_SIZE), scene_distance }
}

/// Brightness of the floor under a surface of height `h` (x, y in [-1, 1] across the picture) and the slopes of it per world unit.
fn caustics_under(gpu: &Gpu, sun: &Above, water: impl Fn(Vec2) -> Option<(f32, Vec2)>) -> Vec<f32> {
    caustics_of(gpu, sun, 0.0, water)
}

/// The same for particles that are so far apart.
fn caustics_of(
    gpu: &Gpu,
    sun: &Above,
    spacing_world: f32,
    water: impl Fn(Vec2) -> Option<(f32, Vec2)>,
) -> Vec<f32> {
    let [width, height] = SUN_SIZE;
    let (mut distance, mut normal) = (Vec::new(), Vec::new());
    for i in 0..width * height {
        let at = Vec2::new((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
        let at = at / Vec2::new(width as f32, height as f32) * Vec2::new(2.0, -2.0) + Vec2::new(-1.0, 1.0);
        match water(at) {
            Some((level, slope)) => {
                distance.push(EYE - level);
                normal.push(pack_normal((-slope).extend(1.0).normalize()));
            }
            None => {
                distance.push(NO_SURFACE);
                normal.push(0);
            }
        }
    }
    let distance = Texture::<EyeDistance>::from_texels(gpu, SUN_SIZE, &distance).unwrap();
    let normal = Texture::<ViewNormal>::from_texels(gpu, SUN_SIZE, &normal).unwrap();
    let scratch = CausticsScratch::new(gpu, SUN_SIZE).unwrap();
    let output = Image::<Caustics>::new(gpu, SUN_SIZE).unwrap();
    let view = SunView { camera: &sun.camera, scene_distance: &sun.scene_distance };
    let mut recorder = Recorder::new(gpu, Timing::Stamps);
    let pass = CausticsPass::new(gpu).unwrap();
    let waves = Waves { distance: &distance, normal: &normal, spacing_world, strength: 1.0 };
    pass.record(gpu, &mut recorder, &view, &waves, &scratch, &output);
    let _ = recorder.submit(gpu).unwrap();
    output.read(gpu).unwrap()
}

/// Pixels at least `margin` away from the border.
fn inner(margin: u32) -> impl Iterator<Item = usize> + Clone {
    let [width, height] = SUN_SIZE;
    (margin..height - margin)
        .flat_map(move |y| (margin..width - margin).map(move |x| (y * width + x) as usize))
}

#[test]
fn flat_water_and_none_leave_the_light_as_it_is() {
    let gpu = gpu();
    let sun = above(&gpu, 1.0);
    for level in [None, Some((0.5, Vec2::ZERO))] {
        let found = caustics_under(&gpu, &sun, |_| level);
        // 1e-3: weights of 1/4096 are rounded.
        assert!(inner(4).all(|i| (found[i] - 1.0).abs() < 1e-3), "{level:?}");
    }
}

/// A ray that meets the surface at x with slope s arrives at x - depth (1 - 1/n) s for small slopes, so that under a surface of
/// curvature c light is denser by 1 / (1 - depth (1 - 1/n) c): twice for a wave crest here, less under a trough.
#[test]
fn a_crest_gathers_light_and_a_trough_scatters_it() {
    let gpu = gpu();
    let sun = above(&gpu, 1.0);
    let depth = 0.5;
    for (curvature, expected) in [(4.0f32, 2.0), (-4.0, 2.0 / 3.0)] {
        let found = caustics_under(&gpu, &sun, |at| {
            let x = 0.5 * at.x;
            // Flat beyond a tenth, so that rays stay in the picture.
            (x.abs() < 0.1).then_some((depth, Vec2::new(-curvature * x, 0.0))).or(Some((depth, Vec2::ZERO)))
        });
        let middle = (SUN_SIZE[1] / 2 * SUN_SIZE[0] + SUN_SIZE[0] / 2) as usize;
        let around: f32 = (middle - 4..middle + 4).map(|i| found[i]).sum::<f32>() / 8.0;
        // 4 %: slopes are not quite small, and the eighth of the pixels of a lens is smoothed over five of them.
        assert!(
            (around / expected - 1.0).abs() < 0.04,
            "{around} under a curvature of {curvature}, not {expected}"
        );
    }
}

#[test]
fn waves_move_light_and_make_none() {
    let gpu = gpu();
    let sun = above(&gpu, 1.0);
    let found = caustics_under(&gpu, &sun, |at| {
        // No light comes to the border.
        let wave = (at.abs().max_element() < 0.7) as u8 as f32;
        Some((0.5, 0.1 * wave * Vec2::new((20.0 * at.x).sin(), (17.0 * at.y).cos())))
    });
    let mean: f64 = inner(0).map(|i| f64::from(found[i])).sum::<f64>() / found.len() as f64;
    // Half a percent: what is brighter than 3.9 times is cut off.
    assert!((mean - 1.0).abs() < 5e-3, "{mean}");
    let brightest = found.iter().copied().fold(0.0, f32::max);
    assert!(brightest > 1.3, "waves are seen: {brightest}");
}

/// Rows of particles are no waves: what repeats with their spacing is not seen, what is eight times as long is.
#[test]
fn caustics_are_no_finer_than_the_particles() {
    let gpu = gpu();
    let sun = above(&gpu, 1.0);
    let spacing = 1.0 / 16.0;
    let contrast = |wavelength: f32| {
        let wave_number = 2.0 * std::f32::consts::PI / wavelength;
        // The most that a crest gathers is three halves: curvature times depth times 1 - 1/n is a third.
        let slope = 4.0 / 3.0 / wave_number / 0.5;
        let found = caustics_of(&gpu, &sun, spacing, |at| {
            Some((0.5, Vec2::new(slope * (wave_number * 0.5 * at.x).sin(), 0.0)))
        });
        let inner = inner(64).map(|i| found[i]);
        inner.clone().fold(0.0, f32::max) - inner.fold(f32::MAX, f32::min)
    };
    let [fine, coarse] = [spacing, 8.0 * spacing].map(contrast);
    // A wave of the eightfold length keeps 78 % of what it is without smoothing; of one of a spacing it leaves what the Gaussian
    // is cut off at, 0.3 %.
    assert!(fine < 1e-2 && coarse > 0.4, "{fine} at the spacing, {coarse} at eight of them");
}

#[test]
fn light_crosses_the_water_above_a_point_and_no_more() {
    let gpu = gpu();
    let sun = above(&gpu, 2.0);
    let pixels = (SUN_SIZE[0] * SUN_SIZE[1]) as usize;
    // Water over the left half, from 0.3 to 0.5 above the floor.
    let is_water = |i: usize| (i as u32 % SUN_SIZE[0]) < SUN_SIZE[0] / 2;
    let of = |inside: f32, outside: f32| -> Vec<f32> {
        (0..pixels).map(|i| if is_water(i) { inside } else { outside }).collect()
    };
    let distance = Texture::<EyeDistance>::from_texels(&gpu, SUN_SIZE, &of(EYE - 0.5, NO_SURFACE)).unwrap();
    let thickness = Texture::<Thickness>::from_texels(&gpu, SUN_SIZE, &of(0.2, 0.0)).unwrap();
    let caustics = Image::<Caustics>::from_pixels(&gpu, SUN_SIZE, &vec![1.0; pixels]).unwrap();
    let seen = SunWater { distance: &distance, thickness: &thickness, caustics: &caustics };
    let view = SunView { camera: &sun.camera, scene_distance: &sun.scene_distance };
    // The picture is taken from where the sun is; its scene is the floor, or something in the water.
    let camera = CameraUniform { size_px: SIZE, ..sun.camera };
    let scale = SIZE[0] as f32 / SUN_SIZE[0] as f32;
    let camera = CameraUniform { px_per_world_at_one: camera.px_per_world_at_one * scale, ..camera };
    let water =
        Texture::<EyeDistance>::from_texels(&gpu, SIZE, &vec![NO_SURFACE; (SIZE[0] * SIZE[1]) as usize])
            .unwrap();
    for (height, expected) in [(0.0, 0.2), (0.4, 0.1), (0.6, 0.0)] {
        let scene = Texture::<SceneDistance>::new(&gpu, SIZE).unwrap();
        scene.write(&gpu, &vec![EYE - height; (SIZE[0] * SIZE[1]) as usize]);
        let output = Texture::<Sunlight>::new(&gpu, SunlightPass::size_blocks(SIZE)).unwrap();
        let mut recorder = Recorder::new(&gpu, Timing::Stamps);
        let pass = SunlightPass::new(&gpu).unwrap();
        pass.record(&gpu, &mut recorder, &camera, &view, &seen, &water, &scene, false, &output);
        let _ = recorder.submit(&gpu).unwrap();
        let found = output.read(&gpu).unwrap();
        let [width, rows] = output.size();
        for (i, value) in found.iter().enumerate() {
            let [path, focus, share] = Sunlight::unpack(*value);
            assert_eq!([focus, share], [1.0, 1.0], "block {i} of {width} x {rows}, {height} up");
            let x = i as u32 % width;
            // At the border of the sun's picture, and where the water ends, it is between.
            let is_near_border =
                x < 2 || x > width - 3 || i as u32 / width < 2 || i as u32 / width > rows - 3;
            if is_near_border || x.abs_diff(width / 2) < 2 {
                continue;
            }
            let expected = if x < width / 2 { expected } else { 0.0 };
            assert!((path - expected).abs() < 1e-6, "{path} at {x} of {width}, {height} up, not {expected}");
        }
    }
    assert_eq!(Sunlight::unpack(Sunlight::UNCHANGED), [0.0, 1.0, 1.0]);
}
