//! Splats drawn as triangles are the picture of the compute passes.

mod common;

use common::{Frame, Scene, gpu, is_fluid, parallel, params, perspective, triangles};
use meniscus_cases::lattice;
use meniscus_core::Camera;
use meniscus_gpu::Gpu;
use meniscus_gpu::role::{KeptRange, NO_SURFACE};
use meniscus_ssfr::{Anisotropy, AnisotropyParams, Radii, SsfrParams, twin};

const SIZE: [u32; 2] = [160, 120];

/// A body with a wall through it, which hides the right half of what lies behind.
fn body(camera: Camera, radius: f32) -> Scene {
    let body = lattice::cuboid([-1.0, -0.7, -4.0], [14, 10, 16], 0.15, 0.3, 1);
    let mut scene = Scene::new(camera, SIZE, &body.positions, radius, 0.15);
    for (i, limit) in scene.scene_distance.iter_mut().enumerate() {
        *limit = if i % 160 > 80 { 2.5 } else { NO_SURFACE };
    }
    scene
}

fn both(gpu: &Gpu, scene: &Scene, params: &SsfrParams) -> [Frame; 2] {
    [true, false].map(|always| scene.render(gpu, &triangles(params.clone(), always)))
}

/// Pixels that differ by more than rounding does: 1e-4 of a radius, where a root magnifies it, and four ulps of the distance.
fn differing(a: &[f32], b: &[f32], radius: f32) -> usize {
    assert!(b.iter().filter(|d| is_fluid(**d)).count() > 300, "an empty picture");
    std::iter::zip(a, b)
        .filter(|(a, b)| is_fluid(**a) != is_fluid(**b) || (**a - **b).abs() > 1e-4 * radius + 5e-7 * **b)
        .count()
}

/// One in a thousand may lie so near an outline that rounding decides.
const MOST_DIFFERING: usize = (SIZE[0] * SIZE[1] / 1000) as usize;

#[test]
fn triangles_of_spheres_agree_with_the_twin_and_with_the_compute_passes() {
    let gpu = gpu();
    assert!(gpu.keeps_least(), "an adapter that cannot blend floats leaves this test nothing to compare");
    // Points, small ones, and some that fill the picture.
    for radius in [0.004, 0.03, 0.09, 0.6] {
        for camera in [perspective(0.5, 1.2), parallel(0.5, 2.2)] {
            let scene = body(camera, radius);
            let [drawn, computed] = both(&gpu, &scene, &params("none", 2, 1.0));
            let expected = twin::depth(&scene.view(), &[scene.host_set()], &scene.scene_distance).distance;
            for (other, expected) in [("compute", &computed.unfiltered), ("twin", &expected)] {
                let count = differing(&drawn.unfiltered, expected, radius);
                assert!(
                    count <= MOST_DIFFERING,
                    "{count} pixels differ from {other} at {radius}, {camera:?}"
                );
            }
            assert_ne!(drawn.unfiltered, computed.unfiltered, "nothing was drawn as triangles");
        }
    }
}

/// Where some are thinned out, grades of radii are the last bits of what blending compares.
#[test]
fn triangles_carry_the_grades_of_radii() {
    let gpu = gpu();
    for camera in [perspective(0.5, 1.2), parallel(0.5, 2.2)] {
        let mut scene = body(camera, 0.09);
        scene.radii = Radii::Grown;
        for range in &mut scene.ranges {
            range.keep = 30_000;
        }
        let [drawn, computed] = both(&gpu, &scene, &params("none", 2, 1.0));
        assert!(differing(&drawn.unfiltered, &computed.unfiltered, 0.09) <= MOST_DIFFERING);
        let radii = std::iter::zip(&drawn.radius, &computed.radius).filter(|(a, b)| a != b).count();
        assert!(radii <= MOST_DIFFERING, "{radii} pixels have another radius");
        assert!(computed.radius.iter().any(|&radius| radius > 0.1), "none has grown");
    }
}

#[test]
fn triangles_of_ellipsoids_agree_with_the_compute_passes() {
    let gpu = gpu();
    let anisotropy = AnisotropyParams { form: Some(Anisotropy::YuTurk), ..Default::default() };
    for radius in [0.02, 0.06, 0.12] {
        for camera in [perspective(0.5, 1.2), parallel(0.5, 2.2)] {
            let mut scene = body(camera, radius);
            scene.shapes = Some(anisotropy);
            let params = SsfrParams { anisotropy, ..params("none", 2, 1.0) };
            // All spheres, then ellipsoids but for the first range.
            let spheres = scene.render(&gpu, &triangles(params.clone(), true)).unfiltered;
            let (_, shaped) = scene.ranges.split_first_mut().unwrap();
            assert!(!shaped.is_empty(), "a range of each kind");
            for range in shaped {
                *range = KeptRange { shape: 1 + range.first, ..*range };
            }
            let [drawn, computed] = both(&gpu, &scene, &params);
            let count = differing(&drawn.unfiltered, &computed.unfiltered, radius);
            assert!(count <= MOST_DIFFERING, "{count} pixels differ at {radius}, {camera:?}");
            assert!(differing(&drawn.unfiltered, &spheres, radius) > MOST_DIFFERING, "no ellipsoids");
        }
    }
}
