//! The pass against its twin, and what a reader of the chart relies on.

use custom_lighting::{Chart, ChartParams, VIRIDIS};
use glam::Vec3;
use meniscus_core::{Aabb, Camera, Projection, UpAxis};
use meniscus_gpu::role::{
    EyeDistance, NO_SURFACE, Radiance, SceneColor, SceneDistance, Thickness, ViewNormal,
};
use meniscus_gpu::{AdapterChoice, CameraUniform, Gpu, Image, Recorder, Texture, Timing};
use meniscus_scene::Scene;
use meniscus_shading::twin::TwinInput;
use meniscus_shading::{LightingInputs, LightingModel, SunPath, Surroundings, WaterScale, WaterShadow};

const SIZE: [u32; 2] = [96, 64];
const PIXELS: usize = (SIZE[0] * SIZE[1]) as usize;
/// Exact in half precision.
const SCENE: [f32; 4] = [0.25, 0.5, 0.75, 1.0];

/// Surface images as the surface stage would give them, over a scene of one colour.
struct Water {
    distance: Vec<f32>,
    thickness: Vec<f32>,
    normal: Vec<u32>,
    scene_distance: f32,
    scale: WaterScale,
}

impl Water {
    /// Level water whose thickness follows `thickness(x, y)` (pixels); none where that is not positive.
    fn level(thickness: impl Fn(f32, f32) -> f32) -> Self {
        let at = |i: usize| [(i % SIZE[0] as usize) as f32, (i / SIZE[0] as usize) as f32];
        let thickness: Vec<f32> = (0..PIXELS).map(at).map(|[x, y]| thickness(x, y)).collect();
        Self {
            distance: thickness.iter().map(|&t| if t > 0.0 { 5.0 } else { NO_SURFACE }).collect(),
            normal: vec![0; PIXELS],
            thickness,
            scene_distance: 1e3,
            scale: WaterScale { depth_world: 0.5, spacing_world: 0.01, metres_per_world: 1.0 },
        }
    }

    /// What the GPU makes of it; with `is_exact` compared with the twin.
    fn render(&self, model: &Chart, is_exact: bool) -> Vec<[f32; 4]> {
        let gpu = &Gpu::new(&AdapterChoice::default()).expect("an adapter, at least mesa-vulkan-drivers");
        let camera = Camera {
            eye: Vec3::new(0.0, 10.0, 1.0),
            target: Vec3::ZERO,
            up: Vec3::Y,
            projection: Projection::Perspective { fovy_rad: 0.8 },
            near: 0.1,
        };
        let camera = CameraUniform::new(&camera, SIZE);
        let bounds = Aabb { min: Vec3::ZERO, max: Vec3::ONE };
        let surroundings = Surroundings::new(&Scene::around(bounds, UpAxis::Y, 0.01));

        let scene_color = Texture::<SceneColor>::new(gpu, SIZE).unwrap();
        let halves = SCENE.map(|c| half::f16::from_f32(c).to_le_bytes());
        scene_color.write(gpu, &halves.as_flattened().repeat(PIXELS));
        let scene_distance = Texture::<SceneDistance>::new(gpu, SIZE).unwrap();
        scene_distance.write(gpu, &self.scene_distance.to_le_bytes().repeat(PIXELS));
        let distance = Image::<EyeDistance>::from_pixels(gpu, SIZE, &self.distance).unwrap();
        let thickness = Image::<Thickness>::from_pixels(gpu, SIZE, &self.thickness).unwrap();
        let normal = Image::<ViewNormal>::from_pixels(gpu, SIZE, &self.normal).unwrap();
        let sun_path = Image::<SunPath>::new(gpu, WaterShadow::size_blocks(SIZE)).unwrap();
        let output = Image::<Radiance>::new(gpu, SIZE).unwrap();
        let inputs = LightingInputs {
            camera: &camera,
            surroundings: &surroundings,
            scale: self.scale,
            distance: &distance,
            thickness: &thickness,
            normal: &normal,
            surface_color: &Image::new(gpu, [1, 1]).unwrap(),
            scene_color: &scene_color,
            scene_distance: &scene_distance,
            sun_path: &sun_path,
        };
        let mut recorder = Recorder::new(gpu, Timing::Stamps);
        model.compile(gpu).unwrap().record(gpu, &mut recorder, &inputs, &output);
        let _ = recorder.submit(gpu).unwrap();
        let found = output.read(gpu).unwrap();
        if is_exact {
            let input = TwinInput {
                camera: &camera,
                surroundings: &surroundings,
                scale: self.scale,
                distance: &self.distance,
                thickness: &self.thickness,
                normal: &self.normal,
                surface_color: &[],
                scene_color: &vec![SCENE; PIXELS],
                scene_distance: &vec![self.scene_distance; PIXELS],
                sun_path: &vec![0.0; PIXELS.div_ceil(16)],
            };
            for (i, found) in found.iter().enumerate() {
                let expected = model.twin(&input, [i as u32 % SIZE[0], i as u32 / SIZE[0]]);
                // Differences of thickness over their own size, in f32, amplify rounding at the edge of a line.
                let off = (0..4).map(|c| (found[c] - expected[c]).abs()).fold(0.0, f32::max);
                assert!(off < 2e-3, "pixel {i}: {found:?}, the twin has {expected:?}");
            }
        }
        found
    }
}

fn flat() -> ChartParams {
    ChartParams { contours: 0.0, relief: 0.0, depth: Some(1.0), ..Default::default() }
}

fn chart(params: ChartParams) -> Chart {
    Chart::new(params).unwrap()
}

#[test]
fn the_pass_follows_its_twin() {
    let mut water =
        Water::level(|x, y| 0.6 + 0.3 * (0.08 * x).sin() * (0.11 * y).cos() - 1e-4 * (x - 40.0).powi(2));
    for (i, normal) in water.normal.iter_mut().enumerate() {
        *normal = (i as u32).wrapping_mul(0x9e37_79b9);
    }
    water.render(&chart(ChartParams::default()), true);
    water.render(&chart(ChartParams { contours: 40.0, line_px: 3.0, relief: 1.0, depth: Some(0.7) }), true);
}

/// The colours of the legend, nothing else: dry is the bright end, the given depth and beyond the dark one.
#[test]
fn thickness_is_read_from_the_map() {
    let water = Water::level(|x, _| [0.125, 0.5, 1.0, 7.0][x as usize % 4]);
    let image = water.render(&chart(flat()), true);
    for (pixel, stop) in image.iter().zip([7, 4, 0, 0].into_iter().cycle()) {
        let srgb = [0, 1, 2].map(|c| {
            let linear = pixel[c];
            let curve =
                if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
            (255.0 * curve).round() as u8
        });
        assert_eq!(srgb, VIRIDIS[stop]);
    }
}

/// A wedge of 32 px per contour step: lines as wide as asked for, at the places asked for, and none at zero.
#[test]
fn contours_lie_where_the_steps_are() {
    let per_px = 0.1 / 32.0;
    let water = Water::level(|x, _| per_px * (x + 0.5));
    let lines = ChartParams { contours: 10.0, line_px: 3.0, ..flat() };
    let [plain, lined] = [flat(), lines].map(|params| water.render(&chart(params), true));
    let row: Vec<f32> = (0..SIZE[0] as usize).map(|x| 1.0 - lined[x][1] / plain[x][1]).collect();
    for (x, ink) in row.iter().enumerate() {
        let off_px = [32.0, 64.0, 96.0].map(|line: f32| (x as f32 + 0.5 - line).abs());
        assert_eq!(*ink > 0.01, off_px.iter().any(|off| *off < 2.0), "{x}: {ink}");
    }
    let inked: f32 = row[16..48].iter().sum();
    // Ink takes three quarters of the light over the width of the line.
    assert!((inked - 0.75 * 3.0).abs() < 1e-3, "{inked}");
}

#[test]
fn steep_water_is_not_covered_by_lines() {
    let water = Water::level(|x, _| 0.09 * (x + 1.0));
    let lines = ChartParams { contours: 10.0, ..flat() };
    assert_eq!(water.render(&chart(lines), true), water.render(&chart(flat()), true));
}

#[test]
fn no_water_and_water_behind_an_object_show_the_scene() {
    let mut water = Water::level(|x, _| if x < 40.0 { 0.3 } else { 0.0 });
    let image = water.render(&chart(ChartParams::default()), true);
    for (i, pixel) in image.iter().enumerate() {
        assert_eq!(*pixel == SCENE, i % SIZE[0] as usize >= 40);
    }
    water.scene_distance = 1.0;
    assert!(water.render(&chart(ChartParams::default()), true).iter().all(|pixel| *pixel == SCENE));
}

#[test]
fn absurd_inputs_stay_finite() {
    let mut water = Water::level(|_, _| 1.0);
    for i in 0..PIXELS {
        water.distance[i] = [1e-3, 5.0, 1e12, 1e30, NO_SURFACE][i % 5];
        water.thickness[i] = [0.0, -1.0, 1e-30, 1e6, 1e20, 0.3][i % 6];
        water.normal[i] = [0, u32::MAX, 0x8000_8000, 0x7fff_7fff, 0x8001_0000][i % 7 % 5];
    }
    for depth_world in [0.0, 1e-20, 1.0, 1e20, f32::NAN] {
        water.scale.depth_world = depth_world;
        for pixel in water.render(&chart(ChartParams { contours: 100.0, ..Default::default() }), false) {
            assert!(pixel.iter().all(|c| (0.0..=1.0).contains(c)), "depth {depth_world}: {pixel:?}");
        }
    }
}

#[test]
fn bad_parameters_do_not_change_the_pass() {
    let gpu = Gpu::new(&AdapterChoice::default()).expect("an adapter, at least mesa-vulkan-drivers");
    let model = Chart::default();
    let mut pass = model.compile(&gpu).unwrap();
    let mut parameters = model.parameters();
    pass.set_parameters(&parameters).unwrap();
    parameters["line_px"] = 0.into();
    assert!(pass.set_parameters(&parameters).unwrap_err().to_string().contains("line_px is 0"));
}
