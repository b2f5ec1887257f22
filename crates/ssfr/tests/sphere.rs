//! `algorithms.md` 14.5: the surface of a sphere of particles.

mod common;

use common::{Scene, gpu, is_fluid, params, perspective};
use glam::{DVec2, DVec3};
use meniscus_cases::lattice;
use meniscus_ssfr::twin;

#[test]
fn a_sphere_of_particles_is_a_sphere_and_does_not_shrink_with_iterations() {
    let gpu = gpu();
    // Smoothing flattens what is curved: by sigma squared over the radius of curvature, here 0.05 r.
    let center = DVec3::new(0.0, 0.0, -4.0);
    let body = lattice::shell(center.as_vec3().to_array(), 1.0, 20_000);
    // The shell has one particle per area of a square of the spacing.
    let spacing = (4.0 * std::f64::consts::PI / 20000.0).sqrt();
    // A shell one particle thick has no holes from 0.71 spacings on.
    let radius = 0.8 * spacing;
    // Mean height of a sphere's cap over a disc of that area: where the smoothed surface should lie.
    let disc = spacing * spacing / std::f64::consts::PI;
    let height = 2.0 / (3.0 * disc) * (radius.powi(3) - (radius * radius - disc).powf(1.5));
    let scene = Scene::new(perspective(0.0, 0.6), [480, 360], &body.positions, radius as f32, spacing as f32);
    let view = scene.view();
    let mut means = Vec::new();
    for iterations in [1, 2, 4, 8] {
        let mut params = params("narrow-range", 2, 1.0);
        params.filter.parameters.insert("iterations".into(), iterations.into());
        let frame = scene.render(&gpu, &params);
        let mut errors = Vec::new();
        let mut turned = 0;
        for (i, &d) in frame.distance.iter().enumerate().filter(|(_, d)| is_fluid(**d)) {
            let (origin, step) = view.ray(DVec2::new((i % 480) as f64 + 0.5, (i / 480) as f64 + 0.5));
            let from_center = origin + f64::from(d) * step - center;
            let exact = from_center.normalize();
            // Where the surface turns away, height and place in the picture are one.
            if exact.dot(-step.normalize()) > 0.5 {
                errors.push((from_center.length() - 1.0 - height) / (0.5 * spacing));
                let found = twin::unpack_normal(frame.normal[i]).as_dvec3();
                turned += usize::from(found.dot(exact) < 0.99);
            }
        }
        errors.sort_by(f64::total_cmp);
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let spread = [errors[errors.len() / 100], errors[errors.len() * 99 / 100]];
        // In units of half the spacing, the particle's radius r: the specification's 0.25.
        assert!(spread.iter().all(|e| e.abs() < 0.25), "{iterations} iterations: {spread:?}, mean {mean}");
        // 0.99: eight degrees.
        assert!(turned * 100 < errors.len(), "{turned} of {} normals are off", errors.len());
        means.push(mean);
    }
    assert!(means.iter().all(|m| (m - means[0]).abs() < 0.05), "drifts with iterations: {means:?}");
}
