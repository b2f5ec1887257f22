//! The conformance suite itself: a plain filter passes it, and each mistake in that filter is caught by the check that is there
//! for it.

mod common;

use common::gpu;
use meniscus_gpu::{
    Binding, CameraUniform, ComputePipeline, ComputePipelineDescriptor, Dispatch, Gpu, Recorder, Shader,
};
use meniscus_ssfr::conformance::{Check, violations};
use meniscus_ssfr::filter::{HostSurface, INCLUDES, Properties, TAPS};
use meniscus_ssfr::twin::HostView;
use meniscus_ssfr::{FilterImages, SurfaceFilter};

/// One pass over discs of pairs, weighted by `(1 - rho^2)^2`, whose standard deviation is `reach / sqrt(8)`.
const DISC: &str = r"
#import meniscus::tally::count
#import meniscus::covered::{CoveredPixels, unpack_pixel}
#import meniscus::camera::{Camera, px_per_world}
#import meniscus::key::{key_of, distance_of, key_per_distance, is_gap}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var front: texture_2d<f32>;
@group(0) @binding(2) var<storage, read> covered: CoveredPixels;
@group(0) @binding(3) var smoothed: texture_storage_2d<r32float, write>;

fn smooth_pixel(at: vec2<i32>) -> u32 {
    let size = vec2<i32>(camera.size_px);
    let own = textureLoad(front, at, 0);
    let d = own.x;
    let center = key_of(camera, d);
    textureStore(smoothed, at, vec4(d));
    let reach = 2.8284271 * 1.6 * own.y * px_per_world(camera, d);
    if !(reach > 1.0 && reach < 1e5) {
        return 0u;
    }
    var step = 1.0;
    while reach > 24.0 * step {
        step *= 2.0;
    }
    let fade = 1.0 - smoothstep(12.0, 24.0, reach / step);
    let range = 8.0 * own.y * key_per_distance(camera, center);
    let taps = i32(reach / step);
    var total = 0.0;
    var weights = 1.0;
    var read = 0u;
    for (var j = -taps; j <= taps; j++) {
        for (var i = -taps; i <= taps; i++) {
            let offset = vec2(i, j) * i32(step);
            let after_at = at + offset;
            let before_at = at - offset;
            if min(min(after_at.x, after_at.y), min(before_at.x, before_at.y)) < 0
                || any(max(after_at, before_at) >= size) || (i == 0 && j == 0) {
                continue;
            }
            let after = key_of(camera, textureLoad(front, after_at, 0).x);
            let before = key_of(camera, textureLoad(front, before_at, 0).x);
            read += 2u;
            let p = vec2<f32>(offset) / reach;
            let place = max(1.0 - dot(p, p), 0.0);
            if min(after, before) < -1e38 {
                continue;
            }
            let odd = select(1.0, fade, (i & 1) == 1) * select(1.0, fade, (j & 1) == 1);
            let deviation = max(abs(after - center), abs(before - center));
            let weight = place * place * odd * clamp(2.0 - 2.0 * deviation / range, 0.0, 1.0);
            total += weight * 0.5 * ((after - center) + (before - center));
            weights += weight;
        }
    }
    textureStore(smoothed, at, vec4(distance_of(camera, center + total / weights)));
    return read;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    var taps = 0u;
    for (var i = id.x; i < covered.count; i += groups.x * 64u) {
        taps += smooth_pixel(vec2<i32>(unpack_pixel(covered.packed[i])));
    }
    count(taps);
}
";

struct Disc {
    pass: ComputePipeline,
    /// Factor on the twin's result: 1 for a right twin.
    twin_factor: f64,
}

impl Disc {
    fn new(gpu: &Gpu, source: String, twin_factor: f64) -> Self {
        let shader = Shader { name: "test/disc", source: Box::leak(source.into_boxed_str()) };
        let descriptor = ComputePipelineDescriptor {
            includes: INCLUDES,
            counts: Some(TAPS),
            ..ComputePipelineDescriptor::new(shader)
        };
        Self { pass: gpu.compute_pipeline(&descriptor).unwrap(), twin_factor }
    }
}

impl SurfaceFilter for Disc {
    fn name(&self) -> &'static str {
        "disc"
    }

    fn record(&self, recorder: &mut Recorder, gpu: &Gpu, camera: &Binding, images: &FilterImages<'_>) {
        let bindings = [
            ("camera", camera.clone()),
            ("front", images.front.bind()),
            ("covered", images.covered.list(recorder, gpu)),
            ("smoothed", images.target.bind()),
        ];
        let groups = Dispatch::Groups(1024);
        recorder.compute(gpu, "test.disc", &self.pass, &bindings, groups);
    }

    fn filter_on_cpu(&self, camera: &CameraUniform, surface: &HostSurface<'_>) -> Vec<f32> {
        let view = HostView::new(camera);
        let [width, height] = view.size_px.map(|side| side as i64);
        let is_parallel = camera.orthographic != 0;
        let key = |d: f64| if is_parallel { -d } else { 1.0 / d };
        let keys: Vec<Option<f64>> =
            surface.distance.iter().map(|&d| (d > 0.0 && d < 1e38).then(|| key(d.into()))).collect();
        let smooth = |pixel: usize| -> Option<f64> {
            let center = keys[pixel]?;
            let (d, radius) = (key(center), f64::from(surface.radius[pixel]));
            let reach = 8f64.sqrt() * 1.6 * radius * view.px_per_world(d);
            if !(reach > 1.0 && reach < 1e5) {
                return Some(d);
            }
            let step = (reach / 24.0).log2().ceil().max(0.0).exp2();
            let t = ((reach / step - 12.0) / 12.0).clamp(0.0, 1.0);
            let fade = 1.0 - t * t * (3.0 - 2.0 * t);
            let range = 8.0 * radius * if is_parallel { 1.0 } else { center * center };
            let taps = (reach / step) as i64;
            let (mut total, mut weights) = (0.0, 1.0);
            for j in -taps..=taps {
                for i in -taps..=taps {
                    let [dx, dy] = [i, j].map(|k| k * step as i64);
                    let (x, y) = (pixel as i64 % width, pixel as i64 / width);
                    let is_inside = |x, y| (0..width).contains(&x) && (0..height).contains(&y);
                    if !is_inside(x + dx, y + dy) || !is_inside(x - dx, y - dy) || (i, j) == (0, 0) {
                        continue;
                    }
                    let pair = [1, -1].map(|side| keys[((y + side * dy) * width + x + side * dx) as usize]);
                    let [Some(after), Some(before)] = pair else { continue };
                    let rho = (dx * dx + dy * dy) as f64 / (reach * reach);
                    let odd = [i, j].map(|k| if k % 2 == 0 { 1.0 } else { fade });
                    let deviation = (after - center).abs().max((before - center).abs());
                    let weight = (1.0 - rho).max(0.0).powi(2)
                        * odd[0]
                        * odd[1]
                        * (2.0 - 2.0 * deviation / range).clamp(0.0, 1.0);
                    total += weight * 0.5 * (after + before - 2.0 * center);
                    weights += weight;
                }
            }
            Some(key(center + total / weights) * self.twin_factor)
        };
        (0..keys.len()).map(|pixel| smooth(pixel).map_or(f32::MAX, |d| d as f32)).collect()
    }

    fn properties(&self) -> Properties {
        Properties {
            exact_up_to_silhouettes: true,
            nominal_sigma: Some(1.0),
            range_radii: Some(8.0),
            ..Properties::exact_on_tilted_planes()
        }
    }
}

#[test]
fn a_plain_filter_passes() {
    let gpu = gpu();
    let found = violations(&gpu, &Disc::new(&gpu, DISC.into(), 1.0));
    assert!(found.is_empty(), "{found:#?}");
}

/// A mistake: what is replaced by what, and the check that has to notice.
const MISTAKES: &[(Check, &str, &str)] = &[
    (
        Check::EmptyStaysEmpty,
        "    count(taps);",
        "    if id.x == 0u { textureStore(smoothed, vec2(0), vec4(1.0)); }
    count(taps);",
    ),
    (Check::OnlyFluidCosts, "    count(taps);", "    count(taps + camera.size_px.x * camera.size_px.y);"),
    (
        Check::ZeroRadiusIsIdentity,
        "if !(reach > 1.0 && reach < 1e5) {",
        "if !(reach > 1.0 && reach < 1e5) {
        textureStore(smoothed, at, vec4(1.001 * d));",
    ),
    (Check::ConstantPlanes, "center + total / weights", "center * 1.001 + total / weights"),
    (
        Check::TiltedPlanes,
        "0.5 * ((after - center) + (before - center))",
        "(after - center) * f32(i > 0 || j > 0)",
    ),
    (
        Check::Silhouettes,
        "if min(after, before) < -1e38 {
                continue;
            }",
        "if min(after, before) < -1e38 {
                weights += place;
                total -= place * 0.01 * abs(center);
                continue;
            }",
    ),
    (Check::NoiseDoesNotGrow, "center + total / weights", "center + 3.0 * total / weights"),
    (Check::Mirror, "0.5 * ((after - center) + (before - center))", "(after - center) * f32(i > 0)"),
    (Check::Scaling, "let range = 8.0 * own.y", "let range = 0.9"),
    (
        Check::NanNeverSpreads,
        "let before = key_of(camera, textureLoad(front, before_at, 0).x);",
        "let raw = textureLoad(front, before_at, 0).x;
            let before = select(select(1.0 / raw, -raw, camera.orthographic != 0u), -3.4e38, raw > 1e38);",
    ),
    (Check::Borders, "let after_at = at + offset;", "let after_at = (at + offset + size) % size;"),
    (
        Check::TinyAndHuge,
        "smooth_pixel(vec2<i32>(unpack_pixel(covered.packed[i])))",
        "smooth_pixel(vec2<i32>(unpack_pixel(covered.packed[i] & 0xffff0fffu)))",
    ),
    (Check::NoRings, "let reach = 2.8284271", "let reach = ceil(2.8284271"),
    (Check::CloseUps, "while reach > 24.0 * step", "while reach < 0.0"),
    (Check::NominalSigma, "let reach = 2.8284271", "let reach = 2.0"),
    (Check::Range, "clamp(2.0 - 2.0 * deviation / range, 0.0, 1.0)", "select(0.0, 1.0, deviation < 1e38)"),
];

#[test]
fn every_mistake_is_caught_by_its_check() {
    let gpu = gpu();
    for (check, find, replace) in MISTAKES {
        assert_eq!(DISC.matches(find).count(), 1, "{find}");
        let mut source = DISC.replace(find, replace);
        match check {
            // An integer reach; and a loop that stops where the budget of taps does.
            Check::NoRings => {
                source = source.replace("px_per_world(camera, d);", "px_per_world(camera, d));")
            }
            Check::CloseUps => {
                source = source.replace("let taps = i32(reach / step);", "let taps = min(i32(reach), 16);");
            }
            _ => {}
        }
        let broken = Disc::new(&gpu, source, 1.0);
        let outcome = check.run(&gpu, &broken);
        assert!(outcome.is_err(), "{check:?} let this pass: {replace}");
    }
}

#[test]
fn a_wrong_twin_is_caught() {
    let gpu = gpu();
    let broken = Disc::new(&gpu, DISC.into(), 1.0 + 1e-3);
    assert!(Check::Twin.run(&gpu, &broken).is_err());
    assert_eq!(Check::ALL.len(), MISTAKES.len() + 1, "every check has its mistake");
}

/// What a filter does not declare is not asked of it.
#[test]
fn only_what_is_declared_is_checked() {
    struct Undeclared(Disc);
    impl SurfaceFilter for Undeclared {
        fn name(&self) -> &'static str {
            self.0.name()
        }
        fn record(&self, recorder: &mut Recorder, gpu: &Gpu, camera: &Binding, images: &FilterImages<'_>) {
            self.0.record(recorder, gpu, camera, images);
        }
        fn filter_on_cpu(&self, camera: &CameraUniform, surface: &HostSurface<'_>) -> Vec<f32> {
            self.0.filter_on_cpu(camera, surface)
        }
    }
    let gpu = gpu();
    for (check, find, replace) in MISTAKES {
        if let Check::TiltedPlanes | Check::Silhouettes | Check::NominalSigma | Check::Range = check {
            let broken = Undeclared(Disc::new(&gpu, DISC.replace(find, replace), 1.0));
            assert_eq!(check.run(&gpu, &broken), Ok(()), "{check:?}");
        }
    }
}
