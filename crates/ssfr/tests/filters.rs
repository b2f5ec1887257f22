//! What every filter must keep to (`algorithms.md` 3.7, 14.4), and the passes against their twins.

mod common;

use common::{gpu, is_fluid, parallel, perspective};
use glam::DVec3;
use meniscus_core::Camera;
use meniscus_gpu::role::{EffectiveRadius, EyeDistance, NO_SURFACE, Scratch};
use meniscus_gpu::{Buffer, CameraUniform, Gpu, Image, Recorder, Timing};
use meniscus_ssfr::filter::HostSurface;
use meniscus_ssfr::twin::HostView;
use meniscus_ssfr::{FilterChoice, FilterImages, FilterRegistry, SurfaceFilter};
use serde_json::json;

const SIZE: [u32; 2] = [160, 120];
const SPACING_PER_RADIUS: f32 = 1.6;

fn filters(gpu: &Gpu) -> Vec<Box<dyn SurfaceFilter>> {
    [json!({}), json!({"variant": "paper"}), json!({"sigma": 1.5, "iterations": 3, "clamp": 0.5})]
        .into_iter()
        .map(|parameters| narrow_range(gpu, &parameters))
        .collect()
}

fn narrow_range(gpu: &Gpu, parameters: &serde_json::Value) -> Box<dyn SurfaceFilter> {
    let parameters = parameters.as_object().unwrap().clone();
    let choice = FilterChoice { name: "narrow-range".into(), parameters };
    FilterRegistry::builtin().create(gpu, &choice).unwrap()
}

/// Runs the passes and compares with the twin before giving the result.
fn run(
    gpu: &Gpu,
    filter: &dyn SurfaceFilter,
    camera: &Camera,
    size: [u32; 2],
    distance: &[f32],
    radius: f32,
) -> Vec<f32> {
    let uniform = CameraUniform::new(camera, size);
    let radii: Vec<f32> = distance.iter().map(|&d| if is_fluid(d) { radius } else { 0.0 }).collect();
    let source = Image::<EyeDistance>::from_pixels(gpu, size, distance).unwrap();
    let radius_image = Image::<EffectiveRadius>::from_pixels(gpu, size, &radii).unwrap();
    let target = Image::<EyeDistance>::from_pixels(gpu, size, &vec![NO_SURFACE; distance.len()]).unwrap();
    let fluid = (0..distance.len() as u32).filter(|&i| is_fluid(distance[i as usize]));
    let mut covered: Vec<u32> = fluid.map(|i| (i % size[0]) | ((i / size[0]) << 16)).collect();
    covered.insert(0, covered.len() as u32);
    // A binding has room for at least one pixel.
    covered.push(0);
    let covered = Buffer::<Scratch>::from_slice(gpu, &covered).unwrap();
    let scratch = [Image::<Scratch>::new(gpu, size).unwrap(), Image::<Scratch>::new(gpu, size).unwrap()];
    let mut recorder = Recorder::new(gpu, Timing::Stamps);
    let camera = recorder.uniform(&uniform);
    let images = FilterImages {
        source: &source,
        radius: &radius_image,
        target: &target,
        covered: &covered,
        scratch: [&scratch[0], &scratch[1]],
        spacing_per_radius: SPACING_PER_RADIUS,
    };
    filter.record(&mut recorder, gpu, &camera, &images);
    let _ = recorder.submit(gpu).unwrap();
    let found = target.read(gpu).unwrap();
    let surface = HostSurface { distance, radius: &radii, spacing_per_radius: SPACING_PER_RADIUS };
    let expected = filter.filter_on_cpu(&uniform, &surface);
    let mut off = 0;
    for (i, (&f, &e)) in found.iter().zip(&expected).enumerate() {
        assert_eq!(is_fluid(f), is_fluid(distance[i]), "the mask changed at {i}");
        assert_eq!(is_fluid(e), is_fluid(distance[i]), "the twin's mask changed at {i}");
        assert!(!is_fluid(f) || f > 0.0, "{f} at {i}");
        // Single precision of distances of some 5 over up to a hundred taps; a pixel at the edge of the range may fall on
        // either side of it.
        off += u32::from((f - e).abs() > 1e-3 * radius + 4e-6 * e);
    }
    assert!(off as usize * 500 <= found.len(), "{}: {off} pixels differ from the twin", filter.name());
    found
}

/// Distance image of what `distance_along` says of each ray.
fn image(camera: &Camera, size: [u32; 2], along: impl Fn(DVec3, DVec3) -> Option<f64>) -> Vec<f32> {
    let view = HostView::new(&CameraUniform::new(camera, size));
    (0..size[0] * size[1])
        .map(|i| {
            let at = glam::DVec2::new(f64::from(i % size[0]) + 0.5, f64::from(i / size[0]) + 0.5);
            let (origin, step) = view.ray(at);
            along(origin, step).map_or(NO_SURFACE, |d| d as f32)
        })
        .collect()
}

fn plane(normal: DVec3, point: DVec3) -> impl Fn(DVec3, DVec3) -> Option<f64> {
    move |origin, step| Some(normal.dot(point - origin) / normal.dot(step))
}

/// Pixels further than `margin` from the picture's border.
fn interior(size: [u32; 2], margin: u32) -> impl Iterator<Item = usize> {
    let inside = move |c: u32, axis: usize| c >= margin && c + margin < size[axis];
    (0..size[0] * size[1])
        .filter(move |&i| inside(i % size[0], 0) && inside(i / size[0], 1))
        .map(|i| i as usize)
}

#[test]
fn planes_are_fixed_points() {
    let gpu = gpu();
    for filter in filters(&gpu) {
        for camera in [perspective(0.0, 1.0), parallel(0.0, 5.0)] {
            let flat = image(&camera, SIZE, plane(DVec3::Z, DVec3::new(0.0, 0.0, -5.0)));
            let found = run(&gpu, &*filter, &camera, SIZE, &flat, 0.1);
            for (f, d) in found.iter().zip(&flat) {
                // Rounding of distance to key and back, some units in the last place.
                assert!((f - d).abs() < 3e-6, "{f} {d}");
            }
        }
    }
}

/// Exact in the slope-compensated form only: 60 degrees under perspective and in parallel projection.
#[test]
fn tilted_planes_are_fixed_points() {
    let gpu = gpu();
    for parameters in [json!({}), json!({"sigma": 2.0})] {
        let filter = narrow_range(&gpu, &parameters);
        for camera in [perspective(0.0, 0.7), parallel(0.0, 2.0)] {
            let tilted = image(&camera, SIZE, plane(DVec3::new(0.3, 0.8, 0.5), DVec3::new(0.0, 0.0, -5.0)));
            let found = run(&gpu, &*filter, &camera, SIZE, &tilted, 0.1);
            for (f, d) in found.iter().zip(&tilted) {
                assert!((f - d).abs() < 3e-6 * d, "{f} {d}");
            }
        }
    }
}

/// Two planes further apart than the range: the one behind stays, the edge of the one in front is rounded: by at
/// most half of the clamp in each pass, because half of its weight lies on the plane.
#[test]
fn surfaces_beyond_the_range_do_not_mix() {
    let gpu = gpu();
    let camera = perspective(0.0, 1.0);
    for filter in filters(&gpu) {
        let step = image(&camera, SIZE, |_, step| Some(if step.x < 0.0 { 4.0 } else { 6.0 }));
        let found = run(&gpu, &*filter, &camera, SIZE, &step, 0.1);
        let mut rounded = 0;
        for (f, d) in found.iter().zip(&step) {
            if *d > 5.0 {
                assert!((f - d).abs() < 1e-5, "the plane behind moved from {d} to {f}");
            } else {
                assert!((d - 1e-5..d + 0.15).contains(&{ *f }), "the plane in front moved from {d} to {f}");
                rounded += u32::from(*f > d + 0.01);
            }
        }
        assert!(rounded > 100, "the silhouette was not rounded");
    }
}

fn bumpy(camera: &Camera, size: [u32; 2], scale: f64) -> Vec<f32> {
    image(camera, size, |_, step| {
        let (u, v) = (step.x * 40.0, step.y * 40.0);
        let bump = 0.1 * scale * (u.sin() * v.cos() + 0.3 * (0.7 * u).cos());
        let far = if step.x + 0.6 * step.y > 0.2 { 2.0 * scale } else { 0.0 };
        (step.x * step.x + step.y * step.y < 0.35).then_some(5.0 * scale + bump + far)
    })
}

#[test]
fn mirrored_pictures_and_other_units_give_the_same() {
    let gpu = gpu();
    let camera = perspective(0.0, 1.2);
    for filter in filters(&gpu) {
        let source = bumpy(&camera, SIZE, 1.0);
        let found = run(&gpu, &*filter, &camera, SIZE, &source, 0.12);
        let width = SIZE[0] as usize;
        let mirror = |image: &[f32]| -> Vec<f32> {
            image.chunks(width).flat_map(|row| row.iter().rev().copied()).collect()
        };
        let mirrored = mirror(&run(&gpu, &*filter, &camera, SIZE, &mirror(&source), 0.12));
        let scaled = run(&gpu, &*filter, &camera, SIZE, &bumpy(&camera, SIZE, 1000.0), 120.0);
        for i in 0..found.len() {
            // The order of additions differs.
            assert!((found[i] - mirrored[i]).abs() <= 2e-6 * found[i], "{} {}", found[i], mirrored[i]);
            if is_fluid(found[i]) {
                // The bumps themselves are rounded differently, by some 1e-7 of the distance.
                assert!((found[i] * 1000.0 - scaled[i]).abs() <= 3e-2, "{} {}", found[i], scaled[i]);
            }
        }
        // It does smooth: bumps of 0.1 shrink.
        assert!(found.iter().zip(&source).any(|(f, s)| (f - s).abs() > 0.03));
    }
}

/// `algorithms.md` 14.4: the response to a bump of 0.01 of the range has the standard deviation that the filter declares.
#[test]
fn the_response_to_an_impulse_has_the_nominal_width() {
    let gpu = gpu();
    let size = [129, 129];
    for camera in [perspective(0.0, 1.0), parallel(0.0, 5.0)] {
        for parameters in
            [json!({}), json!({"sigma": 2.0, "iterations": 1}), json!({"sigma": 1.5, "iterations": 4})]
        {
            for variant in ["slope_compensated", "paper"] {
                let mut parameters = parameters.clone();
                parameters["variant"] = variant.into();
                let filter = narrow_range(&gpu, &parameters);
                let radius = 0.1;
                let mut source = vec![5.0f32; 129 * 129];
                source[64 * 129 + 64] -= 0.01 * 6.0 * radius;
                let found = run(&gpu, &*filter, &camera, size, &source, radius);
                // Against what became of the plane far from the bump, which rounding may have moved as a whole.
                let plane = f64::from(found[64 * 129 + 25]);
                let response: Vec<f64> = found.iter().map(|&d| plane - f64::from(d)).collect();
                let spacing_px = f64::from(radius * SPACING_PER_RADIUS * camera.px_per_world(size, 5.0));
                let nominal = f64::from(filter.nominal_sigma().unwrap()) * spacing_px;
                // Within four sigmas: further out rounding noise outweighs the response.
                let near = |i: usize| {
                    [i % 129, i / 129].map(|c| (c as f64 - 64.0).abs() < 4.0 * nominal) == [true; 2]
                };
                let moment = |power: i32| -> f64 {
                    let near = (0..129 * 129).filter(|&i| near(i));
                    near.map(|i| response[i] * ((i % 129) as f64 - 64.0).powi(power)).sum()
                };
                let measured = (moment(2) / moment(0)).sqrt();
                assert!((measured / nominal - 1.0).abs() < 0.05, "{parameters}: {measured} px of {nominal}");
            }
        }
    }
}

#[test]
fn no_radius_no_change_and_empty_stays_empty() {
    let gpu = gpu();
    let camera = perspective(0.0, 1.0);
    for filter in filters(&gpu) {
        let source = bumpy(&camera, SIZE, 1.0);
        let found = run(&gpu, &*filter, &camera, SIZE, &source, 0.0);
        assert!(found.iter().zip(&source).all(|(f, s)| (f - s).abs() < 1e-6 * s));
        let empty = vec![NO_SURFACE; source.len()];
        assert_eq!(run(&gpu, &*filter, &camera, SIZE, &empty, 0.1), empty);
    }
}

#[test]
fn tiny_and_long_pictures() {
    let gpu = gpu();
    let camera = perspective(0.0, 1.0);
    for filter in filters(&gpu) {
        for size in [[1, 1], [2, 1], [4097, 3], [3, 300]] {
            let source = bumpy(&camera, size, 1.0);
            let found = run(&gpu, &*filter, &camera, size, &source, 0.1);
            assert!(found.iter().all(|d| d.is_finite()));
        }
    }
}

/// A kernel much wider than the loop allows: bumps go all the same, and evenly.
#[test]
fn close_ups_are_smoothed_as_well() {
    let gpu = gpu();
    let camera = parallel(0.0, 5.0);
    let size = [400, 400];
    let filter = narrow_range(&gpu, &json!({}));
    // Caps of spheres on a square lattice, spacing 0.8 (64 px), radius 0.5.
    let caps = image(&camera, size, |origin, _| {
        let cell = |c: f64| (c / 0.8).fract().abs().min(1.0 - (c / 0.8).fract().abs()) * 0.8;
        let q = cell(origin.x).powi(2) + cell(origin.y).powi(2);
        Some(5.0 - (0.25 - q).max(0.0).sqrt())
    });
    let found = run(&gpu, &*filter, &camera, size, &caps, 0.5);
    let inside: Vec<f64> = interior(size, 110).map(|i| found[i].into()).collect();
    let (low, high) = inside.iter().fold((f64::MAX, f64::MIN), |(l, h), &d| (l.min(d), h.max(d)));
    // Of bumps 0.5 deep less than a hundredth is left.
    assert!(high - low < 0.005, "{low} to {high}");
}
