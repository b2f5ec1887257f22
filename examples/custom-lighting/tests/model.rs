//! What a reader of the chart relies on, and what every lighting model keeps to.

use custom_lighting::{Chart, ChartParams, VIRIDIS};
use glam::Vec3;
use meniscus_core::{Aabb, Camera, Projection, UpAxis};
use meniscus_gpu::role::NO_SURFACE;
use meniscus_gpu::{AdapterChoice, Gpu};
use meniscus_scene::Scene;
use meniscus_shading::conformance::{Frame, Water, assert_conforms};
use meniscus_shading::{LightingModel, LightingRegistry, WaterScale};

const SIZE: [u32; 2] = [96, 64];
const PIXELS: usize = (SIZE[0] * SIZE[1]) as usize;
/// Exact in half precision.
const SCENE: [f32; 4] = [0.25, 0.5, 0.75, 1.0];

fn gpu() -> Gpu {
    Gpu::new(&AdapterChoice::default()).expect("an adapter, at least mesa-vulkan-drivers")
}

#[test]
fn the_chart_conforms() {
    let registry = LightingRegistry::builtin().with(Chart::NAME, Chart::make);
    let odd = r#"{"contours": 40, "line_px": 3, "relief": 1, "depth": 0.7}"#;
    assert_conforms(&gpu(), &registry, "chart", &[odd, r#"{"contours": 0}"#]);
}

/// Level water whose thickness follows `thickness(x, y)` (pixels), over a scene of one colour; none where that is not
/// positive.
fn level(thickness: impl Fn(f32, f32) -> f32) -> Frame {
    let camera = Camera {
        eye: Vec3::new(0.0, 10.0, 1.0),
        target: Vec3::ZERO,
        up: Vec3::Y,
        projection: Projection::Perspective { fovy_rad: 0.8 },
        near: 0.1,
    };
    let at = |i: usize| [(i % SIZE[0] as usize) as f32, (i / SIZE[0] as usize) as f32];
    let thickness: Vec<f32> = (0..PIXELS).map(at).map(|[x, y]| thickness(x, y)).collect();
    let water = Water {
        distance: thickness.iter().map(|&t| if t > 0.0 { 5.0 } else { NO_SURFACE }).collect(),
        normal: vec![0; PIXELS],
        thickness,
    };
    let scene = Scene::around(Aabb { min: Vec3::ZERO, max: Vec3::ONE }, UpAxis::Y, 0.01);
    let mut frame = Frame::plain(&camera, SIZE, &scene, water, SCENE, 1e3);
    frame.scale = WaterScale { depth_world: 0.5, spacing_world: 0.01, metres_per_world: 1.0 };
    frame
}

fn render(frame: &Frame, params: ChartParams) -> Vec<[f32; 4]> {
    let gpu = gpu();
    let model = Chart::new(params).unwrap();
    frame.draw(&gpu, &*model.compile(&gpu).unwrap()).unwrap()
}

fn flat() -> ChartParams {
    ChartParams { contours: 0.0, relief: 0.0, depth: Some(1.0), ..Default::default() }
}

/// The colours of the legend, nothing else: dry is the bright end, the given depth and beyond the dark one.
#[test]
fn thickness_is_read_from_the_map() {
    let image = render(&level(|x, _| [0.125, 0.5, 1.0, 7.0][x as usize % 4]), flat());
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
    let water = level(|x, _| per_px * (x + 0.5));
    let lines = ChartParams { contours: 10.0, line_px: 3.0, ..flat() };
    let [plain, lined] = [flat(), lines].map(|params| render(&water, params));
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
    let water = level(|x, _| 0.09 * (x + 1.0));
    let lines = ChartParams { contours: 10.0, ..flat() };
    assert_eq!(render(&water, lines), render(&water, flat()));
}
