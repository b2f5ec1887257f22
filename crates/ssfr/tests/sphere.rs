//! `algorithms.md` 14.5: the surface of a sphere of particles.

mod common;

use common::{Scene, gpu, is_fluid, params, perspective};
use glam::{DVec2, DVec3};
use meniscus_cases::lattice;
use meniscus_gpu::Gpu;
use meniscus_ssfr::{FilterRegistry, twin};

/// Errors of a smoothed sphere of particles.
struct Errors {
    /// Height over the sphere through the particles' mean surface, in particle radii: mean, first and last percent.
    mean: f64,
    spread: [f64; 2],
    /// Fraction of normals that are off by more than eight degrees.
    turned: f64,
}

fn sphere(gpu: &Gpu, filter: &str, parameters: &str) -> Errors {
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
    let mut params = params(filter, 2, 1.0);
    params.filter.parameters = serde_json::from_str(parameters).unwrap();
    let frame = scene.render(gpu, &params);
    let mut errors = Vec::new();
    let mut turned = 0;
    for (i, &d) in frame.distance.iter().enumerate().filter(|(_, d)| is_fluid(**d)) {
        let (origin, step) = view.ray(DVec2::new((i % 480) as f64 + 0.5, (i / 480) as f64 + 0.5));
        let from_center = origin + f64::from(d) * step - center;
        let exact = from_center.normalize();
        // Where the surface turns away, height and place in the picture are one.
        if exact.dot(-step.normalize()) > 0.5 {
            // In units of half the spacing, the particle's radius r.
            errors.push((from_center.length() - 1.0 - height) / (0.5 * spacing));
            let found = twin::unpack_normal(frame.normal[i]).as_dvec3();
            turned += usize::from(found.dot(exact) < 0.99);
        }
    }
    errors.sort_by(f64::total_cmp);
    Errors {
        mean: errors.iter().sum::<f64>() / errors.len() as f64,
        spread: [errors[errors.len() / 100], errors[errors.len() * 99 / 100]],
        turned: turned as f64 / errors.len() as f64,
    }
}

/// The specification's quarter of a particle's radius, with every filter; and one in a hundred normals off.
#[test]
fn a_sphere_of_particles_is_a_sphere() {
    let gpu = gpu();
    for entry in FilterRegistry::builtin().entries().iter().filter(|entry| entry.name() != "none") {
        let Errors { mean, spread, turned } = sphere(&gpu, entry.name(), "{}");
        assert!(spread.iter().all(|e| e.abs() < 0.25), "{}: {spread:?}, mean {mean}", entry.name());
        assert!(turned < 0.01, "{}: {turned} of the normals are off", entry.name());
    }
}

#[test]
fn a_sphere_does_not_shrink_with_iterations() {
    let gpu = gpu();
    for (filter, iterations) in [("narrow-range", [1, 2, 4, 8]), ("curvature-flow", [8, 16, 32, 64])] {
        let means = iterations.map(|n| sphere(&gpu, filter, &format!(r#"{{"iterations": {n}}}"#)).mean);
        assert!(means.iter().all(|m| (m - means[0]).abs() < 0.05), "{filter} drifts: {means:?}");
    }
}
