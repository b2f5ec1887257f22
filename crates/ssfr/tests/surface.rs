//! Depth, radius and normals against closed forms and the CPU twins.

mod common;

use common::{Frame, Scene, gpu, is_fluid, parallel, params, perspective};
use glam::{DVec2, Vec3};
use meniscus_cases::lattice;
use meniscus_gpu::role::{KeptRange, NO_SURFACE, Occludee, PackedParticle};
use meniscus_ssfr::twin;

/// `algorithms.md` 14.1.
#[test]
fn one_sphere_off_axis_has_the_distance_and_outline_of_the_closed_form() {
    let gpu = gpu();
    let center = Vec3::new(2.6, -1.7, -3.0);
    for camera in [perspective(0.0, 1.9), parallel(0.0, 6.0)] {
        let scene = Scene::new(camera, [320, 240], &[center.to_array()], 0.8, 1.0);
        let frame = scene.render(&gpu, &params("none", 1, 0.0));
        let view = scene.view();
        let mut drawn = 0;
        for y in 0..240 {
            for x in 0..320 {
                let found = frame.unfiltered[y * 320 + x];
                // A point of the plane through the centre, perpendicular to the ray: the sphere's outline is where the ray
                // passes at exactly the radius; one pixel is the tolerance of the specification.
                let miss = |at: DVec2| {
                    let (origin, step) = view.ray(at);
                    let v = step.normalize();
                    let p = center.as_dvec3() - origin;
                    (p - v.dot(p) * v).length()
                };
                let here = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let q = miss(here);
                let px = (miss(here + DVec2::X) - q).abs().max((miss(here + DVec2::Y) - q).abs());
                assert!(is_fluid(found) || q > 0.8 - px, "hole at {x}, {y}");
                assert!(!is_fluid(found) || q < 0.8 + px, "beyond the outline at {x}, {y}");
                if is_fluid(found) && q < 0.8 {
                    let (origin, step) = view.ray(here);
                    let (p, a) = (center.as_dvec3() - origin, step.length_squared());
                    let b = step.dot(p);
                    let exact = (b - (b * b - a * (p.length_squared() - 0.64)).sqrt()) / a;
                    // At the very edge the root magnifies rounding without bound.
                    let tolerance = if q < 0.799 { 1e-5 } else { 1e-3 };
                    assert!((f64::from(found) - exact).abs() < tolerance * exact, "{found} {exact}");
                    drawn += 1;
                }
            }
        }
        assert!(drawn > 500, "{drawn}");
    }
}

/// The same numbers, but for the few pixels in which rounding decides: where a ray touches a sphere, and where two spheres
/// meet so that both count as visible or one.
fn assert_same_surface(frame: &Frame, expected: &twin::DepthImages, radius: f32) {
    let differs = |i: &usize| {
        let (found, exact) = (frame.unfiltered[*i], expected.distance[*i]);
        is_fluid(found) != is_fluid(exact)
            || (found - exact).abs() > 1e-3 * radius
            || (frame.radius[*i] - expected.radius[*i]).abs() > 1e-5 * radius
    };
    let count = (0..frame.unfiltered.len()).filter(differs).count();
    assert!(count * 1000 <= frame.unfiltered.len(), "{count} pixels differ");
    assert!(expected.distance.iter().any(|&d| is_fluid(d)));
}

#[test]
fn depth_and_radius_agree_with_their_twin() {
    let gpu = gpu();
    let body = lattice::cuboid([-1.0, -0.7, -4.0], [14, 10, 16], 0.15, 0.3, 1);
    for camera in [perspective(0.5, 1.2), parallel(0.5, 2.2)] {
        for radius in [0.09, 0.004, 0.3] {
            let mut scene = Scene::new(camera, [160, 120], &body.positions, radius, 0.15);
            // A wall through the body hides the right half of what lies behind it.
            for (i, limit) in scene.scene_distance.iter_mut().enumerate() {
                *limit = if i % 160 > 80 { 2.5 } else { NO_SURFACE };
            }
            let frame = scene.render(&gpu, &params("none", 2, 1.0));
            let expected = twin::depth(&scene.view(), &[scene.host_set()], &scene.scene_distance);
            assert_same_surface(&frame, &expected, radius);
            // Half of what is kept fades and grows: the radius pass.
            scene.radii = meniscus_ssfr::Radii::Different;
            for range in &mut scene.ranges {
                range.keep = 30_000;
            }
            for (i, particle) in scene.particles.iter_mut().enumerate() {
                let relative = half_bits(0.6 + 0.8 * (i % 7) as f32 / 7.0);
                *particle = PackedParticle {
                    packed: relative << 16 | u32::from(particle.hash() % 30_000),
                    ..*particle
                };
            }
            let frame = scene.render(&gpu, &params("none", 2, 1.0));
            let expected = twin::depth(&scene.view(), &[scene.host_set()], &scene.scene_distance);
            assert_same_surface(&frame, &expected, radius);
        }
    }
}

/// Software drivers end the loops of an invocation after so many pixels, whatever is left of a sphere; GPUs let all wait for it.
#[test]
fn spheres_that_fill_the_picture_are_whole() {
    let gpu = gpu();
    let size = [640, 480];
    let positions: Vec<[f32; 3]> =
        (0..12).map(|i| [0.02 * i as f32, 0.3 - 0.05 * i as f32, -3.0 - 0.1 * (i % 5) as f32]).collect();
    for camera in [perspective(0.0, 0.9), parallel(0.0, 2.0)] {
        let mut scene = Scene::new(camera, size, &positions, 0.9, 1.0);
        // A bound that says no more than that they are large.
        scene.most_half_px = 1000.0;
        for radii in [meniscus_ssfr::Radii::Equal, meniscus_ssfr::Radii::Different] {
            scene.radii = radii;
            let frame = scene.render(&gpu, &params("none", 1, 0.0));
            let expected = twin::depth(&scene.view(), &[scene.host_set()], &scene.scene_distance);
            assert_same_surface(&frame, &expected, 0.9);
            let covered = expected.distance.iter().filter(|d| is_fluid(**d)).count();
            assert!(covered > 100_000, "more than the 65 536 that such drivers draw: {covered}");
            let found = frame.unfiltered.iter().filter(|d| is_fluid(**d)).count();
            assert_eq!(frame.covered_pixels as usize, found);
            let profile = params("none", 1, 0.0).thickness.profile_half_px(1.0 / 0.9).into();
            let set = [scene.host_set()];
            let sum = twin::thickness_sum(&scene.view(), &set, &scene.scene_distance, (1, profile));
            for (i, (&found, &exact)) in frame.thickness.iter().zip(&sum).enumerate() {
                // Each of the splats is rounded by at most a step of its volume's length over 1024.
                assert!((f64::from(found) - exact).abs() < 12.0 / 1024.0, "{i}: {found} {exact}");
            }
        }
    }
}

/// Where level of detail makes spheres grow, grades in the last bits of the distances take the place of the radius pass.
#[test]
fn grades_tell_the_radius_of_the_visible_sphere_and_hardly_change_its_distance() {
    let gpu = gpu();
    let body = lattice::cuboid([-1.0, -0.7, -4.0], [14, 10, 16], 0.15, 0.3, 1);
    for camera in [perspective(0.5, 1.2), parallel(0.5, 2.2)] {
        let mut scene = Scene::new(camera, [160, 120], &body.positions, 0.09, 0.15);
        for (i, limit) in scene.scene_distance.iter_mut().enumerate() {
            *limit = if i % 160 > 80 { 2.5 } else { NO_SURFACE };
        }
        scene.radii = meniscus_ssfr::Radii::Grown;
        // From those that have twice the radius to those that fade.
        let count = scene.particles.len() as u32;
        scene.ranges = (0..count)
            .step_by(64)
            .zip([4000, 20_000, 30_000, 65_000].into_iter().cycle())
            .map(|(first, keep)| KeptRange { first, count: (count - first).min(64), keep, shape: 0 })
            .collect();
        for (i, particle) in scene.particles.iter_mut().enumerate() {
            particle.packed = particle.packed & 0xffff_0000 | (i * 37 % 4000) as u32;
        }
        let frame = scene.render(&gpu, &params("none", 2, 1.0));
        let expected = twin::depth(&scene.view(), &[scene.host_set()], &scene.scene_distance);
        let mut grown = 0;
        let differs = |i: &usize| {
            let (found, exact) = (frame.unfiltered[*i], expected.distance[*i]);
            if !(is_fluid(found) && is_fluid(exact)) {
                return is_fluid(found) != is_fluid(exact);
            }
            let (radius, exact_radius) = (frame.radius[*i], expected.radius[*i]);
            grown += u32::from(radius > 0.12);
            // 31 steps of a float; half of a fifteenth of a factor of two. Below half of the set's radius spheres that fade have
            // the lowest grade.
            (found - exact).abs() > 1e-4 * 0.09 + 4e-6 * exact
                || (radius - exact_radius.max(0.0429)).abs() > 0.0235 * exact_radius
        };
        let count = (0..frame.unfiltered.len()).filter(differs).count();
        // As `assert_same_surface`, and where two spheres are about equally near the grades decide.
        assert!(count * 500 <= frame.unfiltered.len(), "{count} pixels differ");
        assert!(grown > 1000, "{grown} pixels of grown spheres");
    }
}

/// A run that nothing hides as a whole.
fn anywhere(range: KeptRange) -> Occludee {
    Occludee { range, front: 0.0, first_tile: 0, last_tile: 0, pad: 0 }
}

/// Only what is hidden for sure may be left out: spheres whose centres lie within a wall of others, and which bulge out of it.
#[test]
fn tested_spheres_show_where_they_bulge_out_of_those_drawn_first() {
    let gpu = gpu();
    let wall = lattice::cuboid([-1.0, -0.8, -4.0], [20, 16, 1], 0.1, 0.0, 1).positions;
    let between = wall.iter().map(|p| p.map(|c| c + 0.05));
    let positions: Vec<[f32; 3]> = wall.iter().copied().chain(between).collect();
    for camera in [perspective(0.0, 0.4), parallel(0.0, 1.4)] {
        let at_once = Scene::new(camera, [160, 120], &positions, 0.12, 0.1);
        let count = wall.len() as u32;
        let first = KeptRange { first: 0, count, keep: KeptRange::KEEP_ALL, shape: 0 };
        let tested = anywhere(KeptRange { first: count, ..first });
        let walls_alone = Scene { ranges: vec![first], ..at_once.clone() };
        let in_two_waves = Scene { occludees: vec![tested], ..walls_alone.clone() };
        let params = params("none", 1, 0.0);
        let [expected, wall, found] =
            [&at_once, &walls_alone, &in_two_waves].map(|scene| scene.render(&gpu, &params).unfiltered);
        assert_ne!(wall, expected, "the others must show");
        assert_eq!(found, expected, "{camera:?}");
    }
}

/// However large they are on software drivers; GPUs look at few tiles only (`shaders/ssfr/depth.wgsl`).
#[test]
fn hidden_spheres_are_not_walked_through() {
    let gpu = gpu();
    let size = [320, 240];
    // Outlines of 2, 5, 10 and 20 tiles.
    let radii = [0.05, 0.135, 0.27, 0.54];
    for &radius in if gpu.summary().is_software() { &radii[..] } else { &radii[..1] } {
        let count = (3.5 / radius) as u32;
        let side = 0.5 * radius * count as f32;
        let wall = |z| lattice::cuboid([-side, -side, z], [count, count, 1], radius, 0.0, 1).positions;
        let positions = [wall(-4.0), wall(-4.0 - 4.0 * radius)].concat();
        let count = count * count;
        let first = KeptRange { first: 0, count, keep: KeptRange::KEEP_ALL, shape: 0 };
        let behind = anywhere(KeptRange { first: count, ..first });
        let both = Scene::new(perspective(0.0, 0.4), size, &positions, radius, radius);
        let wall_alone = Scene { ranges: vec![first], ..both.clone() };
        let tested = Scene { occludees: vec![behind], ..wall_alone.clone() };
        let params = params("none", 1, 0.0);
        let [expected, found, all] =
            [&wall_alone, &tested, &both].map(|scene| common::visited_pixels(&gpu, scene, &params));
        assert!(all > expected && expected > 320 * 240, "{all} {expected}");
        assert_eq!(found, expected, "radius {radius}");
    }
}

fn half_bits(value: f32) -> u32 {
    // Enough for values in [0.5, 2): truncation of the significand.
    let bits = value.to_bits();
    ((bits >> 23) - 112) << 10 | (bits >> 13 & 0x3ff)
}

#[test]
fn normals_of_a_plane_and_of_a_sphere() {
    let gpu = gpu();
    // One huge sphere: smooth, with known normals.
    for camera in [perspective(0.0, 1.0), parallel(0.0, 8.0)] {
        let center = Vec3::new(0.5, 0.3, -8.0);
        let scene = Scene::new(camera, [320, 240], &[center.to_array()], 3.0, 1.0);
        let frame = scene.render(&gpu, &params("none", 1, 0.0));
        let view = scene.view();
        let expected = twin::normal(&view, &frame.distance, &frame.radius);
        for (i, &bits) in frame.normal.iter().enumerate() {
            if !is_fluid(frame.distance[i]) {
                assert_eq!(bits, 0);
                continue;
            }
            let n = twin::unpack_normal(bits);
            let (origin, step) = view.ray(DVec2::new((i % 320) as f64 + 0.5, (i / 320) as f64 + 0.5));
            let point = (origin + f64::from(frame.distance[i]) * step).as_vec3();
            let exact = (point - center) / 3.0;
            let facing = exact.dot((-step.normalize()).as_vec3());
            // Single precision of distances of 8 gives slopes to about 1e-3 per pixel; where the surface turns away a
            // pixel spans a large angle.
            if facing > 0.5 {
                assert!(n.dot(expected[i]) > 0.99999, "{n} {}", expected[i]);
                assert!(n.dot(exact) > 0.9995, "{n} {exact}");
            }
            assert!(n.is_normalized() && n.dot((-step.normalize()).as_vec3()) > 0.0);
        }
    }
}

/// Beside the outline of what lies in front, the difference towards it says nothing about the surface behind
/// (`algorithms.md` 7): the mean of both sides would stand it on edge.
#[test]
fn normals_beside_an_edge_are_those_of_their_own_surface() {
    let gpu = gpu();
    let centers = [Vec3::new(0.0, 0.0, -12.0), Vec3::new(3.0, 0.5, -6.0)];
    for camera in [perspective(0.0, 1.0), parallel(0.0, 8.0)] {
        let scene = Scene::new(camera, [320, 240], &centers.map(|c| c.to_array()), 3.0, 1.0);
        let frame = scene.render(&gpu, &params("none", 1, 0.0));
        let view = scene.view();
        let mut beside_the_edge = 0;
        for (i, &bits) in frame.normal.iter().enumerate().filter(|(i, _)| is_fluid(frame.distance[*i])) {
            let (origin, step) = view.ray(DVec2::new((i % 320) as f64 + 0.5, (i / 320) as f64 + 0.5));
            let point = (origin + f64::from(frame.distance[i]) * step).as_vec3();
            // 0.1: the spheres do not touch, so that a point on one is farther than that from the other.
            let center = centers.into_iter().find(|c| (point.distance(*c) - 3.0).abs() < 0.1).unwrap();
            let exact = (point - center) / 3.0;
            if exact.dot((-step.normalize()).as_vec3()) > 0.6 {
                let n = twin::unpack_normal(bits);
                // One-sided differences lag by half a pixel, a hundredth of the radius.
                assert!(n.dot(exact) > 0.9995, "pixel {i}: {n}, expected {exact}");
                let jump =
                    |j: usize| is_fluid(frame.distance[j]) && frame.distance[j] < frame.distance[i] - 1.0;
                beside_the_edge += u32::from(jump(i - 1) || jump(i + 1));
            }
        }
        assert!(beside_the_edge > 20, "{beside_the_edge} pixels");
    }
}

#[test]
fn a_splat_before_the_near_distance_is_not_drawn_and_nothing_is_nan() {
    let gpu = gpu();
    let camera = perspective(0.0, 1.0);
    let positions =
        [[0.0, 0.0, 0.0], [0.0, 0.0, -0.05], [0.0, 0.0, 0.3], [0.1, 0.1, -0.1001], [0.0, 0.0, -5.0]];
    let scene = Scene::new(camera, [64, 48], &positions, 0.1, 0.1);
    let frame = scene.render(&gpu, &params("none", 2, 1.0));
    assert!(frame.distance.iter().all(|d| d.is_finite() && *d > 0.0));
    assert!(frame.thickness.iter().all(|t| t.is_finite() && *t >= 0.0));
    assert!(frame.distance.iter().filter(|&&d| is_fluid(d)).all(|&d| (4.89..5.0).contains(&d)));
    assert!(frame.distance.iter().any(|&d| is_fluid(d)));
}

#[test]
fn tiny_and_odd_pictures_and_no_particles() {
    let gpu = gpu();
    let body = lattice::ball([0.0, 0.0, -4.0], 1.0, 0.2);
    for size in [[1, 1], [4097, 3], [3, 517], [7, 5]] {
        for (positions, expect) in [(&body.positions[..], true), (&[], false)] {
            let scene = Scene::new(perspective(0.0, 0.5), size, positions, 0.125, 0.2);
            for scale in [1, 2, 4] {
                let frame = scene.render(&gpu, &params("none", scale, 1.0));
                assert_eq!(frame.distance.iter().any(|&d| is_fluid(d)), expect, "{size:?}");
                let agree = |(&d, &t): (&f32, &f32)| is_fluid(d) == (t > 0.0) && t.is_finite();
                assert!(frame.distance.iter().zip(&frame.thickness).all(agree), "{size:?} {scale}");
            }
        }
    }
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let gpu = gpu();
    let body = lattice::cuboid([-1.0, -0.7, -4.0], [24, 20, 16], 0.1, 0.3, 1);
    let mut scene = Scene::new(perspective(0.5, 1.2), [160, 120], &body.positions, 0.06, 0.1);
    scene.radii = meniscus_ssfr::Radii::Different;
    scene.ranges.iter_mut().for_each(|range: &mut KeptRange| range.keep = 65_000);
    let first = scene.render(&gpu, &params("none", 2, 1.0));
    for _ in 0..3 {
        assert_eq!(scene.render(&gpu, &params("none", 2, 1.0)), first);
    }
}
