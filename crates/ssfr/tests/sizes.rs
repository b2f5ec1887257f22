//! Particles of different sizes in one set.

mod common;

use common::{Frame, Scene, gpu, is_fluid, parallel, params, perspective, ranges_of, render_together};
use glam::DVec2;
use meniscus_cases::lattice;
use meniscus_gpu::role::{KeptRange, PackedParticle};
use meniscus_ssfr::Radii;

/// `scene` with the relative size of each particle.
fn sized(scene: Scene, sizes: impl Iterator<Item = f32>) -> Scene {
    let particles = std::iter::zip(&scene.particles, sizes)
        .map(|(particle, size)| PackedParticle::sized(particle.position_world, particle.hash(), size))
        .collect();
    Scene { particles, radii: Radii::Different, ..scene }
}

/// Two blocks, one of twice the spacing, are the same picture as one set of two sizes and as two sets of one size each.
#[test]
fn blocks_of_two_spacings_are_one_set_as_well_as_two() {
    let gpu = gpu();
    let (spacing, radius) = (0.1, 0.0625);
    let fine = lattice::cuboid([-1.2, -0.6, -4.0], [12, 12, 12], spacing, 0.2, 1).positions;
    let coarse = lattice::cuboid([0.0, -0.6, -4.0], [6, 6, 6], 2.0 * spacing, 0.2, 2).positions;
    let together: Vec<[f32; 3]> = fine.iter().chain(&coarse).copied().collect();
    let sizes = || std::iter::repeat_n(1.0, fine.len()).chain(std::iter::repeat(2.0));
    for camera in [perspective(0.5, 0.8), parallel(0.5, 2.4)] {
        for size in [[320, 240], [40, 30]] {
            let scene = |positions: &[[f32; 3]], factor: f32| {
                Scene::new(camera, size, positions, factor * radius, factor * spacing)
            };
            let one = sized(scene(&together, 1.0), sizes());
            // The same weights of the same particles: thinned to a half.
            for keep in [KeptRange::KEEP_ALL, 32_768] {
                let thinned = |mut scene: Scene| {
                    scene.particles.retain(|particle| u32::from(particle.hash()) < keep);
                    scene.ranges = ranges_of(scene.particles.len(), keep);
                    Scene { radii: Radii::Different, ..scene }
                };
                let first_hashes = scene(&together, 1.0).particles;
                let mut two = [scene(&fine, 1.0), scene(&coarse, 2.0)];
                std::iter::zip(two.iter_mut().flat_map(|scene| &mut scene.particles), &first_hashes)
                    .for_each(|(particle, same)| *particle = *same);
                let [one, fine, coarse] = [one.clone(), two[0].clone(), two[1].clone()].map(thinned);
                let params = params("narrow-range", 2, 1.0);
                let expected = render_together(&gpu, &[&fine, &coarse], &params, 1).0;
                let found = one.render(&gpu, &params);
                assert!(expected.distance.iter().filter(|d| is_fluid(**d)).count() > 100);
                // Doubling is exact. The noise that rounds thin addends up or down is another for another size, by at most a
                // step for each particle in a column; a hundred of the finest set's 1024 per spacing.
                let off = std::iter::zip(&found.thickness, &expected.thickness);
                let most = off.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(most < 100.0 * spacing / 1024.0, "{camera:?} {size:?} {keep}: {most}");
                let thickness = expected.thickness.clone();
                assert_eq!(Frame { thickness, ..found }, expected, "{camera:?} {size:?} {keep}");
            }
        }
    }
}

#[test]
fn a_large_particle_has_the_outline_of_a_large_sphere() {
    let gpu = gpu();
    for camera in [perspective(0.0, 0.8), parallel(0.0, 3.0)] {
        for size in [0.25, 1.75] {
            let center = [0.4, -0.2, -3.0];
            let scene = sized(Scene::new(camera, [320, 240], &[center], 0.4, 0.6), [size].into_iter());
            let frame = scene.render(&gpu, &params("none", 1, 0.0));
            let (view, radius) = (scene.view(), 0.4 * f64::from(size));
            let center = glam::Vec3::from(center).as_dvec3();
            for (i, &distance) in frame.unfiltered.iter().enumerate() {
                let (x, y) = (i % 320, i / 320);
                let (origin, step) = view.ray(DVec2::new(x as f64 + 0.5, y as f64 + 0.5));
                let from_center = center - origin;
                let passes = from_center.reject_from(step).length();
                // What passes by within the rounding of f32 may be either.
                if (passes - radius).abs() > 1e-5 {
                    assert_eq!(is_fluid(distance), passes < radius, "pixel {x}, {y}, size {size}");
                }
            }
        }
    }
}

/// `algorithms.md` 14.3 with sizes: the integral over the picture is the sum of the volumes.
#[test]
fn the_integral_over_the_picture_is_the_sum_of_the_volumes() {
    let gpu = gpu();
    let positions = lattice::cuboid([-1.0, -1.0, -6.0], [20, 20, 20], 0.1, 0.4, 1).positions;
    let of_index = |i: usize| [0.5, 0.8, 1.0, 1.3, 2.1][i * 7 % 5];
    let sizes = || (0..positions.len()).map(of_index);
    let expected: f64 = sizes().map(|size| (0.1 * f64::from(size)).powi(3)).sum();
    for side in [400, 100] {
        let scene = sized(Scene::new(parallel(0.0, 4.0), [side, side], &positions, 0.0625, 0.1), sizes());
        let frame = scene.render(&gpu, &params("none", 1, 0.0));
        let pixel_area = (4.0 / f64::from(side)).powi(2);
        let volume = frame.thickness.iter().map(|&t| f64::from(t)).sum::<f64>() * pixel_area;
        // A tenth of a percent, and as much for sizes in half precision (2^-12, three times in a volume).
        assert!((volume / expected - 1.0).abs() < 2e-3, "{side}: {volume} of {expected}");
    }
}
