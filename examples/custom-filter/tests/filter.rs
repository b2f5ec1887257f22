//! What every filter must keep to, and the passes against their twin.

use custom_filter::{PlaneFit, PlaneFitParams};
use glam::{DVec2, DVec3, Vec3};
use meniscus_core::{Camera, Projection};
use meniscus_gpu::role::{EffectiveRadius, EyeDistance, NO_SURFACE, Scratch};
use meniscus_gpu::{AdapterChoice, Buffer, CameraUniform, Gpu, Image, Recorder, Timing};
use meniscus_ssfr::filter::HostSurface;
use meniscus_ssfr::twin::HostView;
use meniscus_ssfr::{FilterImages, SurfaceFilter};

const SIZE: [u32; 2] = [120, 90];
const SPACING_PER_RADIUS: f32 = 1.6;

fn gpu() -> Gpu {
    Gpu::new(&AdapterChoice::default()).expect("an adapter, at least mesa-vulkan-drivers")
}

fn filters(gpu: &Gpu) -> Vec<PlaneFit> {
    [
        PlaneFitParams::default(),
        PlaneFitParams { passes: 1, ..Default::default() },
        PlaneFitParams { sigma: 2.0, range: 3.0, passes: 3 },
    ]
    .map(|params| PlaneFit::new(gpu, params).unwrap())
    .into()
}

/// At the origin, looking along -z.
fn camera(projection: Projection) -> Camera {
    Camera { eye: Vec3::ZERO, target: Vec3::NEG_Z, up: Vec3::Y, projection, near: 0.01 }
}

fn cameras() -> [Camera; 2] {
    [Projection::Perspective { fovy_rad: 0.9 }, Projection::Orthographic { height_world: 5.0 }].map(camera)
}

fn is_fluid(distance: f32) -> bool {
    distance < NO_SURFACE
}

/// Runs the passes and compares with the twin before giving the result.
fn run(
    gpu: &Gpu,
    filter: &PlaneFit,
    camera: &Camera,
    size: [u32; 2],
    source: &[f32],
    radius: f32,
) -> Vec<f32> {
    let uniform = CameraUniform::new(camera, size);
    let radii: Vec<f32> = source.iter().map(|&d| if is_fluid(d) { radius } else { 0.0 }).collect();
    let source_image = Image::<EyeDistance>::from_pixels(gpu, size, source).unwrap();
    let radius_image = Image::<EffectiveRadius>::from_pixels(gpu, size, &radii).unwrap();
    let target = Image::<EyeDistance>::from_pixels(gpu, size, &vec![NO_SURFACE; source.len()]).unwrap();
    let fluid = (0..source.len() as u32).filter(|&i| is_fluid(source[i as usize]));
    let mut covered: Vec<u32> = fluid.map(|i| (i % size[0]) | ((i / size[0]) << 16)).collect();
    covered.insert(0, covered.len() as u32);
    let covered = Buffer::<Scratch>::from_slice(gpu, &covered).unwrap();
    let scratch = [(); 2].map(|()| Image::<Scratch>::new(gpu, size).unwrap());
    let mut recorder = Recorder::new(gpu, Timing::Stamps);
    let camera = recorder.uniform(&uniform);
    let images = FilterImages {
        source: &source_image,
        radius: &radius_image,
        target: &target,
        covered: &covered,
        scratch: [&scratch[0], &scratch[1]],
        spacing_per_radius: SPACING_PER_RADIUS,
    };
    filter.record(&mut recorder, gpu, &camera, &images);
    let _ = recorder.submit(gpu).unwrap();
    let found = target.read(gpu).unwrap();

    let surface = HostSurface { distance: source, radius: &radii, spacing_per_radius: SPACING_PER_RADIUS };
    let expected = filter.filter_on_cpu(&uniform, &surface);
    let mut off = 0;
    for (i, (&f, &e)) in found.iter().zip(&expected).enumerate() {
        assert_eq!([is_fluid(f), is_fluid(e)], [is_fluid(source[i]); 2], "the mask changed at {i}");
        assert!(!is_fluid(f) || f > 0.0, "{f} at {i}");
        // Single precision of distances and of sums over 121 taps; where a tap falls between two pixels, the last bit
        // decides which one it is.
        off += u32::from((f - e).abs() > 1e-3 * radius + 4e-6 * e);
    }
    assert!(off as usize * 500 <= found.len(), "{off} pixels differ from the twin");
    found
}

/// Distance image of what `along` says of each ray.
fn image(camera: &Camera, size: [u32; 2], along: impl Fn(DVec3, DVec3) -> Option<f64>) -> Vec<f32> {
    let view = HostView::new(&CameraUniform::new(camera, size));
    (0..size[0] * size[1])
        .map(|i| {
            let at = DVec2::new(f64::from(i % size[0]) + 0.5, f64::from(i / size[0]) + 0.5);
            let (origin, step) = view.ray(at);
            along(origin, step).map_or(NO_SURFACE, |d| d as f32)
        })
        .collect()
}

fn plane(normal: DVec3, origin: DVec3, step: DVec3) -> f64 {
    normal.dot(DVec3::new(0.0, 0.0, -5.0) - origin) / normal.dot(step)
}

/// A disc of bumps with a step across it.
fn bumpy(camera: &Camera, size: [u32; 2], scale: f64) -> Vec<f32> {
    image(camera, size, |_, step| {
        let (u, v) = (step.x * 40.0, step.y * 40.0);
        let bump = 0.1 * scale * (u.sin() * v.cos() + 0.3 * (0.7 * u).cos());
        let far = if step.x + 0.6 * step.y > 0.2 { 2.0 * scale } else { 0.0 };
        (step.x * step.x + step.y * step.y < 0.2).then_some(5.0 * scale + bump + far)
    })
}

/// Tilted ones too, cut by a ragged silhouette: up to the last pixel, where averages leave the plane.
#[test]
fn planes_are_fixed_points_up_to_their_edges() {
    let gpu = gpu();
    for filter in filters(&gpu) {
        for camera in cameras() {
            for normal in [DVec3::Z, DVec3::new(0.3, 0.8, 0.5)] {
                let flat = image(&camera, SIZE, |origin, step| {
                    let at = origin + plane(normal, origin, step) * step;
                    let is_there = (3.0 * at.x).sin() + (4.0 * at.y).cos() > -0.7;
                    (is_there && (1.0..20.0).contains(&-at.z)).then_some(-at.z)
                });
                let found = run(&gpu, &filter, &camera, SIZE, &flat, 0.1);
                for (f, d) in found.iter().zip(&flat) {
                    // Rounding of distances to keys and back, some units in the last place.
                    assert!(!is_fluid(*d) || (f - d).abs() < 2e-6 * d, "{f} {d}");
                }
            }
        }
    }
}

#[test]
fn surfaces_beyond_the_range_do_not_mix() {
    let gpu = gpu();
    let [camera, _] = cameras();
    for filter in filters(&gpu) {
        let step = image(&camera, SIZE, |_, step| Some(if step.x < 0.0 { 4.0 } else { 6.0 }));
        let found = run(&gpu, &filter, &camera, SIZE, &step, 0.1);
        assert!(found.iter().zip(&step).all(|(f, d)| (f - d).abs() < 1e-5));
    }
}

#[test]
fn mirrored_pictures_and_other_units_give_the_same() {
    let gpu = gpu();
    let [camera, _] = cameras();
    for filter in filters(&gpu) {
        let source = bumpy(&camera, SIZE, 1.0);
        let found = run(&gpu, &filter, &camera, SIZE, &source, 0.12);
        let mirror = |image: &[f32]| -> Vec<f32> {
            image.chunks(SIZE[0] as usize).flat_map(|row| row.iter().rev().copied()).collect()
        };
        let mirrored = mirror(&run(&gpu, &filter, &camera, SIZE, &mirror(&source), 0.12));
        let scaled = run(&gpu, &filter, &camera, SIZE, &bumpy(&camera, SIZE, 1000.0), 120.0);
        for i in (0..found.len()).filter(|&i| is_fluid(found[i])) {
            // Sums in another order, amplified by the plane fit where the window is thin.
            assert!((found[i] - mirrored[i]).abs() <= 1e-5 * found[i], "{} {}", found[i], mirrored[i]);
            assert!((found[i] * 1000.0 - scaled[i]).abs() <= 1e-5 * scaled[i], "{} {}", found[i], scaled[i]);
        }
    }
}

/// Spheres on a square lattice become a plane. What is left of bumps one radius deep is what taps 0.4 spacings apart cannot
/// see of the sharp creases between spheres: some three hundredths.
#[test]
fn particles_become_a_surface() {
    let gpu = gpu();
    let [_, camera] = cameras();
    let (spacing, radius) = (0.32, 0.2);
    let caps = image(&camera, SIZE, |origin, _| {
        let cell = |c: f64| c - spacing * (c / spacing).round();
        let q = cell(origin.x).powi(2) + cell(origin.y).powi(2);
        Some(5.0 - (radius * radius - q).max(0.0).sqrt())
    });
    let depth = |image: &[f32]| {
        let far_from_border = |i: &usize| {
            (30..90).contains(&(i % SIZE[0] as usize)) && (30..60).contains(&(i / SIZE[0] as usize))
        };
        let inside = (0..image.len()).filter(far_from_border).map(|i| image[i]);
        let (low, high) = inside.fold((f32::MAX, f32::MIN), |(l, h), d| (l.min(d), h.max(d)));
        high - low
    };
    assert!(depth(&caps) > 0.1, "{}", depth(&caps));
    let found =
        run(&gpu, &PlaneFit::new(&gpu, Default::default()).unwrap(), &camera, SIZE, &caps, radius as f32);
    assert!(depth(&found) < 0.05 * depth(&caps), "{}", depth(&found));
}

/// `algorithms.md` 14.4: the response to a small bump has the standard deviation that the filter declares.
#[test]
fn the_response_to_a_bump_has_the_nominal_width() {
    let gpu = gpu();
    let (side, radius) = (65, 0.1);
    // 22 px per world unit: a window of 2 sqrt(2) sigma reaches 5 px, so that each of its pixels is a tap.
    let camera = camera(Projection::Orthographic { height_world: side as f32 / 22.0 });
    for passes in [1, 2] {
        let params = PlaneFitParams { sigma: 0.5 * (passes as f32).sqrt(), passes, ..Default::default() };
        let filter = PlaneFit::new(&gpu, params).unwrap();
        let mut source = vec![5.0f32; side * side];
        source[side / 2 * side + side / 2] -= 0.01 * radius;
        let found = run(&gpu, &filter, &camera, [side as u32; 2], &source, radius);
        let moment = |power: i32| -> f64 {
            let response = |i: usize| 5.0 - f64::from(found[i]);
            (0..side * side).map(|i| response(i) * ((i % side) as f64 - (side / 2) as f64).powi(power)).sum()
        };
        let measured = (moment(2) / moment(0)).sqrt();
        let nominal = f64::from(filter.nominal_sigma().unwrap() * SPACING_PER_RADIUS * radius * 22.0);
        // Sums over pixels stand for integrals over discs of two pixels at least, and distances are rounded.
        assert!((measured / nominal - 1.0).abs() < 0.05, "{passes}: {measured} px of {nominal}");
    }
}

#[test]
fn no_radius_no_change_and_empty_stays_empty() {
    let gpu = gpu();
    let [camera, _] = cameras();
    for filter in filters(&gpu) {
        let source = bumpy(&camera, SIZE, 1.0);
        assert_eq!(run(&gpu, &filter, &camera, SIZE, &source, 0.0), source);
        let empty = vec![NO_SURFACE; source.len()];
        assert_eq!(run(&gpu, &filter, &camera, SIZE, &empty, 0.1), empty);
    }
}

#[test]
fn tiny_and_long_pictures() {
    let gpu = gpu();
    let [camera, _] = cameras();
    let filter = PlaneFit::new(&gpu, Default::default()).unwrap();
    for size in [[1, 1], [2, 1], [1027, 3], [3, 300]] {
        let found = run(&gpu, &filter, &camera, size, &bumpy(&camera, size, 1.0), 0.1);
        assert!(found.iter().all(|d| d.is_finite()));
    }
}

#[test]
fn parameters_out_of_range_are_named() {
    let message = |params: PlaneFitParams| params.validate().unwrap_err().to_string();
    assert!(
        message(PlaneFitParams { sigma: f32::NAN, ..Default::default() }).contains("filter.sigma is NaN")
    );
    assert!(message(PlaneFitParams { passes: 9, ..Default::default() }).contains("filter.passes is 9"));
}
