//! The opaque scene pass against rays cast on the host.

use std::sync::Arc;

use crate::support::{draw_scene, gpu, tiled_scene, world_ray};
use glam::{Mat4, Vec2, Vec3};
use meniscus_core::{Aabb, Camera, Projection};
use meniscus_gpu::role::{
    EyeDistance, NO_SURFACE, Radiance, SceneColor, SceneDistance, Sunlight, Thickness, ViewNormal,
};
use meniscus_gpu::{
    CameraUniform, ComputePipelineDescriptor, Covered, Definition, PicturePipeline, Pixels, Recorder,
    Texture, Timing, shader,
};
use meniscus_scene::{Environment, Material, Mesh, Object, Scene, Sides, UpFrame};
use meniscus_shading::{
    EnvironmentMap, Fluid, INCLUDES, LightingInputs, LightingModel, Surroundings, WaterScale,
};

const SIZE: [u32; 2] = [80, 60];

/// Colour and distance of the drawn scene, read back through a lighting pass without water: radiance is then the scene's,
/// and water at a chosen distance shows exactly where the scene is behind it.
fn scene_colors(camera: &CameraUniform, scene: &Scene, water_distance: f32) -> Vec<[f32; 4]> {
    let gpu = gpu();
    let (color, distance) = draw_scene(&gpu, camera, scene, None);
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    let water = Texture::<EyeDistance>::from_texels(&gpu, SIZE, &vec![water_distance; pixels]).unwrap();
    let thickness = Texture::<Thickness>::from_texels(&gpu, SIZE, &vec![1e9; pixels]).unwrap();
    let normal = Texture::<ViewNormal>::from_texels(&gpu, SIZE, &vec![0; pixels]).unwrap();
    let sunlight = Texture::<Sunlight>::from_texels(&gpu, [1, 1], &[Sunlight::UNCHANGED]).unwrap();
    let output = Texture::<Radiance>::new(&gpu, SIZE).unwrap();
    let mut recorder = Recorder::new(&gpu, Timing::Stamps);
    let inputs = LightingInputs {
        camera,
        surroundings: &Surroundings::new(scene),
        environment: &EnvironmentMap::new(&gpu, scene).unwrap(),
        objects: None,
        scale: WaterScale { depth_world: 1.0, spacing_world: 0.1, metres_per_world: 1.0 },
        covered: &Covered::of(&gpu, SIZE, |_| water_distance < NO_SURFACE).unwrap(),
        distance: &water,
        thickness: &thickness,
        normal: &normal,
        surface_color: &Texture::new(&gpu, [1, 1]).unwrap(),
        scene_color: &color,
        scene_distance: &distance,
        sunlight: &sunlight,
        has_sunlight: false,
    };
    Fluid::default().compile(&gpu).unwrap().record(&gpu, &mut recorder, &inputs, &output);
    let _ = recorder.submit(&gpu).unwrap();
    output.read_floats(&gpu).unwrap()
}

fn cameras() -> [Camera; 2] {
    let perspective = Camera {
        eye: Vec3::new(3.0, 1.5, 4.0),
        target: Vec3::new(1.0, 0.3, 0.5),
        up: Vec3::Y,
        projection: Projection::Perspective { fovy_rad: 0.9 },
        near: 0.01,
    };
    [perspective, Camera { projection: Projection::Orthographic { height_world: 3.0 }, ..perspective }]
}

/// Distance along the view axis to box or floor, by slabs; `NO_SURFACE` for sky.
fn cast_box(camera: &CameraUniform, bounds: Aabb, pixel: usize) -> f32 {
    let (o, d) = world_ray(camera, pixel);
    let (a, b) = ((bounds.min - o) / d, (bounds.max - o) / d);
    let (near, far) = (a.min(b).max_element(), a.max(b).min_element());
    let floor = if o.y > 0.0 && d.y < 0.0 { -o.y / d.y } else { NO_SURFACE };
    if near < far && near > 0.0 { near.min(floor) } else { floor }
}

#[test]
fn boxes_floor_and_sky_lie_where_rays_meet_them() {
    let bounds = Aabb { min: Vec3::new(0.5, 0.0, 0.2), max: Vec3::new(1.5, 0.8, 0.9) };
    let mut scene = tiled_scene();
    let material = Material { scale: 0.5, ..Material::named("concrete").unwrap() };
    scene.objects.push(Object {
        name: "box".into(),
        mesh: Mesh::cuboid(bounds),
        material,
        sides: Sides::Both,
    });
    for camera in cameras() {
        let camera = CameraUniform::new(&camera, SIZE);
        let drawn = scene_colors(&camera, &scene, NO_SURFACE);
        let expected: Vec<f32> = (0..drawn.len()).map(|i| cast_box(&camera, bounds, i)).collect();
        for (pixel, &distance) in drawn.iter().zip(&expected) {
            assert_eq!(pixel[3], if distance < NO_SURFACE { 1.0 } else { 0.0 });
            assert!(pixel.iter().all(|c| c.is_finite() && *c >= 0.0));
            assert!(pixel[..3].iter().any(|c| *c > 0.02), "nothing is black: {pixel:?}");
        }
        // Water just in front of and just behind a distance tells the distance that was written.
        for water in [2.5f32, 3.5, 4.5] {
            let with_water = scene_colors(&camera, &scene, water);
            for (i, (with, without)) in with_water.iter().zip(&drawn).enumerate() {
                // 1e-4: rounding of distances; pixels on the box's edges belong to either face.
                if (expected[i] - water).abs() > 1e-4 * water && !on_edge(&expected, i) {
                    assert_eq!(
                        with != without,
                        expected[i] > water,
                        "pixel {i} at {} water {water}",
                        expected[i]
                    );
                }
            }
        }
    }
}

/// Whether the distance jumps next to `i`.
fn on_edge(distances: &[f32], i: usize) -> bool {
    let width = SIZE[0] as usize;
    [i.wrapping_sub(1), i + 1, i.wrapping_sub(width), i + width]
        .into_iter()
        .filter_map(|j| distances.get(j))
        .any(|d| (d - distances[i]).abs() > 0.15 * distances[i])
}

#[test]
fn a_wall_is_seen_from_inside_only() {
    let camera = CameraUniform::new(&cameras()[0], SIZE);
    let empty = tiled_scene();
    let mut walled = empty.clone();
    let room = Aabb { min: Vec3::new(0.0, 0.0, -1.0), max: Vec3::new(2.0, 0.5, 1.0) };
    walled.add_walls(room, 0.6, Material { scale: 0.5, ..Default::default() });
    let (without, with) =
        (scene_colors(&camera, &empty, NO_SURFACE), scene_colors(&camera, &walled, NO_SURFACE));
    let changed = without.iter().zip(&with).filter(|(a, b)| a != b).count();
    assert!(changed > 100, "the far walls are drawn: {changed}");
    // The nearest corner of the room hides nothing: the floor in front of the far walls is still there.
    let view = Mat4::from_cols_array_2d(&camera.view_from_world).transform_point3(Vec3::new(1.7, 0.0, 0.7));
    let ndc = view.truncate() / -view.z / Vec2::from(camera.half_extent);
    let px = (ndc * Vec2::new(0.5, -0.5) + 0.5) * Vec2::new(SIZE[0] as f32, SIZE[1] as f32);
    let index = px.y as usize * SIZE[0] as usize + px.x as usize;
    assert_eq!(without[index], with[index]);
}

fn luminance(pixel: &[f32; 4]) -> f32 {
    0.2126 * pixel[0] + 0.7152 * pixel[1] + 0.0722 * pixel[2]
}

/// What reflections take for the floor is the mean of what is drawn.
#[test]
fn the_floor_seen_from_above_has_its_mean_radiance() {
    let mut scene = tiled_scene();
    // Not steel: a metal only mirrors, and what it mirrors depends on the view.
    for name in Material::NAMES.into_iter().filter(|name| *name != "steel") {
        let material = Material { scale: 0.1, ..Material::named(name).unwrap() };
        scene.floor.as_mut().unwrap().material = material;
        let above = Camera {
            eye: Vec3::new(0.3, 1e-2, 0.2),
            target: Vec3::new(0.3, 0.0, 0.2),
            up: Vec3::NEG_Z,
            projection: Projection::Orthographic { height_world: 1.5 },
            near: 1e-4,
        };
        let drawn = scene_colors(&CameraUniform::new(&above, SIZE), &scene, NO_SURFACE);
        let mean = drawn.iter().map(luminance).sum::<f32>() / drawn.len() as f32;
        let [red, green, blue] = Surroundings::new(&scene).floor_radiance;
        let expected = luminance(&[red, green, blue, 1.0]);
        // 15 %: Burley's lobe and the specular lobes depend on direction, the mean does not.
        assert!((mean / expected - 1.0).abs() < 0.15, "{name}: {mean}, expected {expected}");
    }
}

/// The pattern is averaged over each pixel: towards the horizon it fades instead of flickering.
#[test]
fn nothing_aliases_at_the_horizon() {
    let mut scene = tiled_scene();
    scene.floor.as_mut().unwrap().material.scale = 0.05;
    let level = Camera {
        eye: Vec3::new(0.3, 1.0, 30.0),
        target: Vec3::new(0.3, 1.0, 0.0),
        up: Vec3::Y,
        projection: Projection::Perspective { fovy_rad: 0.5 },
        near: 1e-2,
    };
    let drawn = scene_colors(&CameraUniform::new(&level, SIZE), &scene, NO_SURFACE);
    let (width, height) = (SIZE[0] as usize, SIZE[1] as usize);
    // Rows just below the horizon, where a pixel covers many tiles.
    for y in height / 2 + 1..height / 2 + 8 {
        for x in 1..width {
            let (a, b) = (luminance(&drawn[y * width + x - 1]), luminance(&drawn[y * width + x]));
            // 1 %: half of what the eye can tell.
            assert!((a / b - 1.0).abs() < 0.01, "row {y}, column {x}: {a} beside {b}");
        }
    }
}

/// Level views to north, east and up show what the picture has there.
#[test]
fn a_picture_of_the_surroundings_is_the_background() {
    let mut scene = tiled_scene();
    scene.floor = None;
    let frame = UpFrame::new(scene.up);
    scene.environment = Some(Arc::new(Environment::from_fn([128, 64], |d| 0.5 + 0.5 * d)));
    for [east, north, up] in [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [-0.6, -0.48, 0.64]] {
        let along = frame.world(east, north, up);
        let camera = Camera {
            eye: Vec3::ZERO,
            target: along,
            up: frame.up,
            projection: Projection::Perspective { fovy_rad: 0.1 },
            near: 0.01,
        };
        let drawn = scene_colors(&CameraUniform::new(&camera, SIZE), &scene, NO_SURFACE);
        let middle = drawn[drawn.len() / 2 + SIZE[0] as usize / 2];
        let expected = [east, north, up].map(|c| 0.5 + 0.5 * c);
        // 0.02: linear between texels of 2.8 degrees, half a pixel off the axis, half precision.
        assert!((0..3).all(|c| (middle[c] - expected[c]).abs() < 0.02), "{middle:?}, expected {expected:?}");
        assert_eq!(middle[3], 0.0, "only sky");
    }
}

/// Straight down there is the floor, or ground where there is none.
#[test]
fn without_a_floor_the_background_is_sky_and_ground() {
    let mut scene = tiled_scene();
    scene.objects.clear();
    let up = UpFrame::new(scene.up);
    let camera = Camera {
        eye: 2.0 * up.up,
        target: Vec3::ZERO,
        up: up.world(0.0, 1.0, 0.0),
        projection: Projection::Perspective { fovy_rad: 0.1 },
        near: 0.01,
    };
    let mut middle = |floor| {
        scene.floor = floor;
        let drawn = scene_colors(&CameraUniform::new(&camera, SIZE), &scene, NO_SURFACE);
        (drawn[drawn.len() / 2 + SIZE[0] as usize / 2], Surroundings::new(&scene).sky.ground)
    };
    let floor = tiled_scene().floor;
    assert!(floor.is_some());
    assert_eq!(middle(floor).0[3], 1.0, "a floor");
    let (seen, ground) = middle(None);
    // Half precision.
    assert!((0..3).all(|c| (seen[c] / ground[c] - 1.0).abs() < 1e-3), "{seen:?}, expected {ground:?}");
    assert_eq!(seen[3], 0.0, "nothing that water could stand on");
}

/// Sky and floor are a triangle on software drivers and a compute pass on GPUs, of the same source.
#[test]
fn the_background_is_the_same_computed_and_drawn() {
    let distances = computed_as_drawn(&tiled_scene(), &[]);
    assert!(distances.contains(&NO_SURFACE) && distances.iter().any(|d| *d < 10.0));
    let floorless = Scene { floor: None, ..tiled_scene() };
    let distances = computed_as_drawn(&floorless, &[Definition { name: "FLOORLESS", value: 1 }]);
    assert!(distances.iter().all(|d| *d == NO_SURFACE));
}

/// Checks that the background of `scene`, compiled with `definitions` where it is computed, is as it is drawn; its distances.
fn computed_as_drawn(scene: &Scene, definitions: &[Definition]) -> Vec<f32> {
    let gpu = gpu();
    let camera = CameraUniform::new(&cameras()[0], SIZE);
    let drawn = draw_scene(&gpu, &camera, scene, None);
    let computed = PicturePipeline::computed(
        gpu.compute_pipeline(&ComputePipelineDescriptor {
            includes: INCLUDES,
            definitions: &[definitions, &[Definition { name: "HARDWARE", value: 1 }]].concat(),
            ..ComputePipelineDescriptor::new(shader!("shading/background"))
        })
        .unwrap(),
        Pixels::All,
    );
    let color = Texture::<SceneColor>::new(&gpu, SIZE).unwrap();
    let distance = Texture::<SceneDistance>::new(&gpu, SIZE).unwrap();
    let mut recorder = Recorder::new(&gpu, Timing::Stamps);
    let bindings = [
        ("camera", recorder.uniform(&camera)),
        ("surroundings", recorder.uniform(&Surroundings::new(scene))),
    ];
    let targets = [("scene_color", color.view()), ("scene_distance", distance.view())];
    recorder.picture(&gpu, "test.background", &computed, &bindings, &targets, None);
    let _ = recorder.submit(&gpu).unwrap();
    let colors = [drawn.0, color].map(|color| color.read_floats(&gpu).unwrap());
    for (pixel, (drawn, computed)) in std::iter::zip(&colors[0], &colors[1]).enumerate() {
        // Both forms may round a half to either side.
        let is_near = |(a, b): (&f32, &f32)| (a - b).abs() <= Radiance::ROUNDING * a.max(*b);
        assert!(std::iter::zip(drawn, computed).all(is_near), "pixel {pixel}: {drawn:?}, {computed:?}");
    }
    let [drawn, computed] = [drawn.1, distance].map(|distance| distance.read(&gpu).unwrap());
    for (drawn, computed) in std::iter::zip(&drawn, &computed) {
        // Single precision, in another order.
        assert!((drawn - computed).abs() <= 1e-5 * drawn, "{drawn}, {computed}");
    }
    drawn
}
