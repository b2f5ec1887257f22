//! Objects in the mirror of the water against plane mirrors.

use glam::{Mat4, Vec2, Vec3};
use meniscus_core::{Aabb, Camera, Projection};
use meniscus_gpu::CameraUniform;
use meniscus_gpu::role::NO_SURFACE;
use meniscus_scene::{Scene, Sky};
use meniscus_shading::conformance::{Frame, Water, pack_normal};
use meniscus_shading::{Fluid, FluidParameters};

use crate::support::{gpu, render, tiled_scene, world_ray};

const SIZE: [u32; 2] = [160, 120];
/// A wall that stands in the water, whose surface is y = 0.
const WALL: Aabb = Aabb { min: Vec3::new(-1.0, -0.5, -2.3), max: Vec3::new(0.8, 1.0, -2.0) };

/// Light of 1 from everywhere, no floor.
fn white_scene() -> Scene {
    let mut scene = tiled_scene();
    scene.floor = None;
    scene.sky = Sky { zenith: [1.0; 3], horizon: [1.0; 3], ground: [1.0; 3], glow: 0.0 };
    scene.sun.irradiance = [0.0; 3];
    scene
}

/// Water that only mirrors.
fn mirror() -> Fluid {
    let parameters =
        FluidParameters { additional_reflection: 1.0, roughness: 0.01, spray: 0.0, ..Default::default() };
    Fluid::new(parameters).unwrap()
}

fn looking(eye: Vec3, target: Vec3, projection: Projection) -> Camera {
    Camera { eye, target, up: Vec3::Y, projection, near: 0.01 }
}

/// Red and green of the wall say where on it a point is, and it has no blue; half floats hold them to a thousandth.
fn paint(point: Vec3) -> [f32; 4] {
    let place = (point - WALL.min) / WALL.extent();
    [0.1 + 0.5 * place.x, 0.1 + 0.5 * place.y, 0.0, 1.0]
}

/// The wall in flat water, up to which it reaches from 3 in front of it.
fn frame(camera: &Camera) -> Frame {
    frame_with(camera, &[WALL])
}

fn frame_with(camera: &Camera, objects: &[Aabb]) -> Frame {
    let uniform = CameraUniform::new(camera, SIZE);
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    let up = Vec3::Y * (camera.eye.y).signum();
    let normal = Mat4::from_cols_array_2d(&uniform.view_from_world).transform_vector3(up);
    let water = Water {
        distance: (0..pixels).map(|i| water_distance(&uniform, i)).collect(),
        thickness: vec![1.0; pixels],
        normal: vec![pack_normal(normal); pixels],
    };
    let mut frame = Frame::plain(camera, SIZE, &white_scene(), water, [1.0, 1.0, 1.0, 0.0], NO_SURFACE);
    for i in 0..pixels {
        let (origin, step) = world_ray(&uniform, i);
        for object in objects {
            let (a, b) = ((object.min - origin) / step, (object.max - origin) / step);
            let (near, far) = (a.min(b).max_element(), a.max(b).min_element());
            if near < far && near > 0.0 && near < frame.scene_distance[i] {
                frame.scene_distance[i] = near;
                frame.scene_color[i] = paint(origin + near * step);
            }
        }
    }
    frame.objects = objects.iter().copied().reduce(Aabb::union);
    frame
}

fn water_distance(camera: &CameraUniform, pixel: usize) -> f32 {
    let (origin, step) = world_ray(camera, pixel);
    let distance = -origin.y / step.y;
    let at = origin + distance * step;
    let is_water = distance > 0.01 && at.x.abs() < 3.0 && (WALL.max.z..WALL.max.z + 3.0).contains(&at.z);
    if is_water { distance } else { NO_SURFACE }
}

fn project_px(camera: &CameraUniform, point: Vec3) -> Vec2 {
    let view = Mat4::from_cols_array_2d(&camera.view_from_world).transform_point3(point);
    let scale = if camera.orthographic != 0 { 1.0 } else { -view.z };
    let ndc = view.truncate() / scale / Vec2::from(camera.half_extent);
    (ndc * Vec2::new(0.5, -0.5) + 0.5) * Vec2::new(SIZE[0] as f32, SIZE[1] as f32)
}

/// A pixel shows the point of the wall that a plane mirror shows there, to a pixel, and the sky where that shows none.
#[test]
fn a_wall_is_mirrored_where_a_plane_mirror_shows_it() {
    let gpu = gpu();
    let (eye, target) = (Vec3::new(0.4, 1.0, 2.5), Vec3::new(0.0, 0.1, -1.5));
    for projection in
        [Projection::Perspective { fovy_rad: 0.7 }, Projection::Orthographic { height_world: 2.6 }]
    {
        let frame = frame(&looking(eye, target, projection));
        let without = Frame { objects: None, ..frame.clone() };
        let (image, sky) = (render(&frame, &gpu, &mirror()), render(&without, &gpu, &mirror()));
        let (mut shown, mut empty) = (0, 0);
        for (i, pixel) in image.iter().enumerate().filter(|(i, _)| frame.water.distance[*i] < NO_SURFACE) {
            let (origin, step) = world_ray(&frame.camera, i);
            let at = origin + frame.water.distance[i] * step;
            let mirrored = step * Vec3::new(1.0, -1.0, 1.0);
            let meets = at + (WALL.max.z - at.z) / mirrored.z * mirrored;
            // How far inside the wall's front the point is, in pixels.
            let px = project_px(&frame.camera, meets);
            let sides = [(WALL.min.x, meets.y), (WALL.max.x, meets.y), (meets.x, WALL.max.y)];
            let from_sides =
                sides.map(|(x, y)| px.distance(project_px(&frame.camera, Vec3::new(x, y, meets.z))));
            let is_inside = (WALL.min.x..WALL.max.x).contains(&meets.x) && meets.y < WALL.max.y;
            let is_at_side = from_sides.iter().any(|distance| *distance < 2.0);
            if is_inside && !is_at_side {
                let share = 1.0 - pixel[2];
                assert!(share > 0.999, "pixel {i} shows {meets}: {pixel:?}");
                let place = [pixel[0], pixel[1]].map(|c| (c - 0.1) / 0.5);
                let found = WALL.min + Vec3::new(place[0], place[1], 1.0) * WALL.extent();
                let off = project_px(&frame.camera, found).distance(px);
                assert!(off < 1.0, "pixel {i} shows {found}, {off} px from {meets}");
                shown += 1;
            } else if !is_inside && !is_at_side {
                assert_eq!(pixel, &sky[i], "pixel {i} shows the sky: {meets}");
                empty += 1;
            }
        }
        assert!(shown > 1500 && empty > 1500, "{shown} pixels of the wall, {empty} of the sky");
        let twin = frame.twin(&mirror());
        let differ =
            (0..image.len()).filter(|&i| (0..4).any(|c| (image[i][c] - twin[i][c]).abs() > 1e-3)).count();
        // Last bits decide on which side of the wall's edge a ray passes: its outline is some 300 pixels.
        assert!(differ < 30, "{differ} pixels differ from the twin's");
    }
}

/// A beam above the water, nearer than the water whose mirrored rays pass behind it on their way to the wall.
#[test]
fn rays_go_on_behind_what_they_do_not_meet() {
    let gpu = gpu();
    let beam = Aabb { min: Vec3::new(-0.7, 0.5, 1.0), max: Vec3::new(0.7, 0.65, 1.1) };
    let camera = looking(
        Vec3::new(0.0, 1.0, 2.5),
        Vec3::new(0.0, 0.1, -1.5),
        Projection::Perspective { fovy_rad: 0.9 },
    );
    let (with, without) = (frame_with(&camera, &[WALL, beam]), frame(&camera));
    let (found, expected) = (render(&with, &gpu, &mirror()), render(&without, &gpu, &mirror()));
    let is_beam = |i: usize| with.scene_distance[i] != without.scene_distance[i];
    let width = SIZE[0] as usize;
    let mut behind = 0;
    for i in 0..found.len() {
        let (origin, step) = world_ray(&with.camera, i);
        let at = origin + with.water.distance[i] * step;
        let is_water = with.water.distance[i] < with.scene_distance[i].min(NO_SURFACE);
        // Three pixels inside of the wall's edges; rays behind it for less than two may miss it.
        let [red, green, blue, _] = expected[i];
        let is_wall = blue < 1e-3 && (0.13..0.57).contains(&red) && green < 0.55;
        if !is_water || at.z > beam.min.z - 0.05 || !is_wall {
            continue;
        }
        let mirrored = step * Vec3::new(1.0, -1.0, 1.0);
        let px = project_px(&with.camera, at + (WALL.max.z - at.z) / mirrored.z * mirrored);
        // The camera does not roll: in the picture, mirrored rays go straight up.
        let passes = (px.y as usize..i / width).any(|row| is_beam(row * width + i % width));
        let is_hidden =
            (-2..=2).any(|rows| is_beam((px.y as usize).saturating_add_signed(rows) * width + i % width));
        if passes && !is_hidden {
            // A ray may sample other points on its way: half a pixel.
            let off = (0..3).map(|c| (found[i][c] - expected[i][c]).abs()).fold(0.0, f32::max);
            assert!(off < 0.01, "pixel {i}: {:?} instead of {:?}", found[i], expected[i]);
            behind += 1;
        }
    }
    assert!(behind > 200, "{behind}");
}

/// Nothing is seen beyond the picture: towards its border the mirrored wall fades into the sky.
#[test]
fn what_leaves_the_picture_fades() {
    let gpu = gpu();
    // The wall goes on above the picture.
    let camera = looking(
        Vec3::new(0.0, 0.6, 1.0),
        Vec3::new(0.0, -0.1, -2.0),
        Projection::Perspective { fovy_rad: 0.5 },
    );
    let frame = frame(&camera);
    let image = render(&frame, &gpu, &mirror());
    let share: Vec<f32> =
        (0..SIZE[1]).map(|y| 1.0 - image[(y * SIZE[0] + SIZE[0] / 2) as usize][2]).collect();
    let is_water = |y: &usize| frame.water.distance[y * SIZE[0] as usize + SIZE[0] as usize / 2] < NO_SURFACE;
    let rows: Vec<usize> = (0..SIZE[1] as usize).filter(is_water).collect();
    assert!(share[rows[2]] > 0.999 && share[rows[rows.len() - 1]] == 0.0, "{share:?}");
    for pair in rows.windows(2) {
        let (above, below) = (share[pair[0]], share[pair[1]]);
        // A twentieth of 120 rows, at most 1.5 of the mean slope.
        assert!(below <= above + 1e-3 && above - below < 0.3, "rows {pair:?}: {above} and {below}");
    }
}

#[test]
fn odd_cameras_are_sane() {
    let gpu = gpu();
    let perspective = Projection::Perspective { fovy_rad: 1.2 };
    let target = Vec3::new(0.0, 0.0, -2.0);
    for eye in [
        // Below the water, grazing, straight above, above the wall, behind it, inside of it.
        Vec3::new(0.3, -0.6, 1.0),
        Vec3::new(0.3, 2e-3, 1.0),
        Vec3::new(0.0, 3.0, -1.99),
        Vec3::new(0.0, 1.2, -2.2),
        Vec3::new(0.2, 0.9, -4.0),
        Vec3::new(0.0, 0.5, -2.1),
    ] {
        let frame = frame(&looking(eye, target + Vec3::new(1e-3, 0.0, 0.1), perspective));
        for model in [mirror(), Fluid::default()] {
            for pixel in render(&frame, &gpu, &model) {
                // Nothing is brighter than 1; 2e-3 as in the conformance suite.
                assert!(pixel.iter().all(|c| (0.0..=1.0 + 2e-3).contains(c)), "{pixel:?} from {eye}");
            }
        }
    }
}

/// A rough surface shows no sharp image.
#[test]
fn rough_water_leaves_objects_to_the_environment() {
    let gpu = gpu();
    let perspective = Projection::Perspective { fovy_rad: 0.7 };
    let frame = frame(&looking(Vec3::new(0.4, 1.0, 2.5), Vec3::new(0.0, 0.1, -1.5), perspective));
    // A box that no mirrored ray meets: objects count for the refracted path all the same.
    let elsewhere = Aabb { min: Vec3::new(0.0, -100.0, 0.0), max: Vec3::new(1.0, -99.0, 1.0) };
    let without = Frame { objects: Some(elsewhere), ..frame.clone() };
    let [rough, smooth] =
        [0.9, 0.15].map(|roughness| Fluid::new(FluidParameters { roughness, ..Default::default() }).unwrap());
    let difference = |model| {
        let (with, without) = (render(&frame, &gpu, model), render(&without, &gpu, model));
        let channels = with.iter().flatten().zip(without.iter().flatten());
        channels.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    };
    assert_eq!(difference(&rough), 0.0);
    assert!(difference(&smooth) > 0.01, "{}", difference(&smooth));
}
