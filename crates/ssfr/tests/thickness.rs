//! Thickness against known volumes and the CPU twin.

mod common;

use common::{Scene, gpu, is_fluid, parallel, params, perspective};
use meniscus_cases::lattice;
use meniscus_core::Projection;
use meniscus_gpu::role::{NO_SURFACE, StandIn};
use meniscus_ssfr::{Radii, twin};

fn mean(values: impl Iterator<Item = f32>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), v| (sum + f64::from(v), count + 1));
    sum / f64::from(count)
}

/// `algorithms.md` 14.2: a box of depth 2 seen along its depth; s is the drawn radius per half spacing.
#[test]
fn a_box_is_as_thick_as_it_is_deep_whatever_the_radius() {
    let gpu = gpu();
    let spacing = 0.1;
    let body = lattice::cuboid([-1.5, -1.5, -6.0], [30, 30, 20], spacing, 0.0, 1);
    // Interior pixels: away from the box's sides by more than the largest radius.
    for (size, scale) in [([256, 256], 1), ([256, 256], 2), ([256, 256], 4), ([48, 48], 1)] {
        for s in [1.0, 1.24, 1.5, 2.0] {
            let scene = Scene::new(parallel(0.0, 4.0), size, &body.positions, s * spacing / 2.0, spacing);
            let frame = scene.render(&gpu, &params("none", scale, 1.0));
            let interior = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).filter(|&(x, y)| {
                [x, y]
                    .iter()
                    .zip(size)
                    .all(|(&c, side)| ((c as f32 + 0.5) / side as f32 * 4.0 - 2.0).abs() < 1.2)
            });
            let found = mean(interior.map(|(x, y)| frame.thickness[(y * size[0] + x) as usize]));
            assert!((found - 2.0).abs() < 0.02, "s {s}, size {size:?}, scale {scale}: {found}");
        }
    }
}

/// `algorithms.md` 14.3, from splats of many pixels to splats of a hundredth of one.
#[test]
fn the_integral_over_the_picture_is_the_volume() {
    let gpu = gpu();
    let body = lattice::cuboid([-1.0, -1.0, -6.0], [20, 20, 20], 0.1, 0.4, 1);
    for side in [400, 100, 33, 9] {
        let scene = Scene::new(parallel(0.0, 4.0), [side, side], &body.positions, 0.0625, 0.1);
        let frame = scene.render(&gpu, &params("none", 1, 0.0));
        let pixel_area = (4.0 / f64::from(side)).powi(2);
        let volume = frame.thickness.iter().map(|&t| f64::from(t)).sum::<f64>() * pixel_area;
        // Volume shared out beyond the last pixel that shows a surface is lost where the splats are small: less than a
        // pixel's ring around the body.
        let tolerance = if side >= 100 { 1e-3 } else { 0.03 };
        assert!((volume / body.volume - 1.0).abs() < tolerance, "{side}: {volume} of {}", body.volume);
    }
}

/// The passes for sets of which no profile is drawn, and none in strips, give the same sums and distances; a set that is said to be
/// larger is drawn with its profiles.
#[test]
fn sets_of_small_splats_are_drawn_as_all_others() {
    let gpu = gpu();
    let body = lattice::cuboid([-1.0, -1.0, -6.0], [20, 20, 20], 0.1, 0.4, 1);
    for radii in [Radii::Equal, Radii::Different] {
        for (side, is_small) in [(96, true), (1000, false)] {
            let scene = Scene::new(parallel(0.0, 4.0), [side, side], &body.positions, 0.0625, 0.1);
            let half_px = 0.0625 * side as f32 / 4.0;
            let params = params("none", 2, 1.0);
            assert_eq!(half_px < 2.0 * params.thickness.profile_half_px(0.1 / 0.0625), is_small);
            let unknown = Scene { radii, ..scene };
            let expected = unknown.render(&gpu, &params);
            let known =
                Scene { most_half_px: half_px, most_radius_px: half_px, ..unknown }.render(&gpu, &params);
            assert_eq!(known.thickness, expected.thickness, "{radii:?}, {half_px} px");
            assert_eq!(known.unfiltered, expected.unfiltered, "{radii:?}, {half_px} px");
        }
    }
}

/// Whoever says that nothing cuts a set gets the same sums, where that is so, and all of it, where it is not.
#[test]
fn water_that_nothing_cuts_is_summed_without_the_scene() {
    let gpu = gpu();
    let body = lattice::cuboid([-1.0, -1.0, -6.0], [20, 20, 20], 0.1, 0.4, 1);
    // Spheres of 1.5 spacings and eight particles, as halves.
    let stand_in = |&center_world| StandIn { center_world, packed: 0x3e00 << 16 | 0x4800 };
    let stand_ins: Vec<StandIn> = body.positions.iter().step_by(7).map(stand_in).collect();
    for (side, half_px) in [(96, 1.5), (96, f32::INFINITY), (400, f32::INFINITY)] {
        let open = Scene::new(parallel(0.0, 4.0), [side, side], &body.positions, 0.0625, 0.1);
        let open = Scene { most_half_px: half_px, stand_ins: stand_ins.clone(), ..open };
        // Through the middle of the water.
        let cut = Scene { scene_distance: vec![5.0; open.scene_distance.len()], ..open.clone() };
        let thickness = |scene: &Scene, is_in_front| {
            let scene = Scene { is_in_front, ..scene.clone() };
            scene.render(&gpu, &params("none", 2, 1.0)).thickness
        };
        let whole = thickness(&open, false);
        // A hundredth of a spacing: drivers may fuse what is added to a factor of 1, which rounds otherwise.
        let off = thickness(&open, true).iter().zip(&whole).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off <= 0.001, "{side}, {half_px}: {off}");
        let middle = whole.len() / 2 + side as usize / 2;
        let [all, rest] = [true, false].map(|is_in_front| thickness(&cut, is_in_front)[middle]);
        assert!((all - whole[middle]).abs() <= 0.001, "{side}, {half_px}: {all} of {}", whole[middle]);
        assert!((0.4..0.6).contains(&(rest / all)), "{side}, {half_px}: {rest} of {all}");
    }
}

/// Far water neither vanishes nor grows: the mean thickness over the picture follows the inverse square of the distance.
#[test]
fn far_water_keeps_its_volume() {
    let gpu = gpu();
    let body = lattice::cuboid([-1.0, -1.0, -1.0], [20, 20, 20], 0.1, 0.4, 1);
    for distance in [20.0, 100.0, 500.0] {
        let mut camera = perspective(distance, 1.0);
        camera.projection = Projection::Perspective { fovy_rad: 1.0 };
        let scene = Scene::new(camera, [256, 256], &body.positions, 0.0625, 0.1);
        let set = [scene.host_set()];
        let exact: f64 =
            twin::thickness_sum(&scene.view(), &set, &scene.scene_distance, (1, 2.0)).iter().sum();
        let frame = scene.render(&gpu, &params("none", 1, 0.0));
        let found: f64 = frame.thickness.iter().map(|&t| f64::from(t)).sum();
        let pixel = 2.0 * 0.5f64.tan() / 256.0 * f64::from(distance);
        let expected = body.volume / (pixel * pixel);
        // The body is 2 deep: its front is seen larger than its middle.
        assert!((exact / expected - 1.0).abs() < 0.02, "{distance}: twin {exact} of {expected}");
        assert!((found / exact - 1.0).abs() < 0.03, "{distance}: {found} of {exact}");
    }
}

/// Where the taps of the smoothing are some samples apart, what repeats by as many is gone all the same: of water in front, whose taps
/// are, and of what is shared out between samples behind it; and beside water further back, whose taps are not.
#[test]
fn close_ups_have_no_mesh() {
    let gpu = gpu();
    let spacing = 0.1;
    let near = lattice::cuboid([-1.0, -1.0, -2.4], [10, 20, 4], spacing, 0.0, 1);
    let far = lattice::cuboid([-1.5, -1.5, -5.0], [30, 30, 24], spacing, 0.0, 1);
    let positions = [near.positions, far.positions].concat();
    for (fovy, apart) in [(1.0, 2.0), (0.5, 5.0)] {
        // Large enough to leave no holes.
        let scene = Scene::new(perspective(0.0, fovy), [400, 400], &positions, 0.08, spacing);
        let thickness = scene.render(&gpu, &params("none", 1, 1.0)).thickness;
        let px_per_world = 200.0 / (0.5 * fovy).tan();
        let sigma_px = px_per_world * spacing / 2.0;
        assert_eq!(
            (2.5 * sigma_px / 24.0_f32).ceil(),
            apart,
            "{fovy}: taps of water in front, two units away"
        );
        let rows = (20..380).step_by(7).map(|y| &thickness[y * 400..][..400]);
        let off = rows.flat_map(|row| {
            // Fourth differences: waves of two samples are in them sixteen times, smooth changes hardly. Not across the silhouette.
            let places = (20..190).chain(210..380);
            places.map(move |x| {
                let [near, far] = [1, 2].map(|d| row[x - d] + row[x + d]);
                ((far - 4.0 * near + 6.0 * row[x]) / (16.0 * row[x])).abs()
            })
        });
        let most = off.fold(0.0, f32::max);
        // Kernels end at 4 % of their height, of which, alternating, one part in their whole weight is left: 0.1 % of such waves.
        assert!(most < 2e-3, "{fovy}: {most} of the thickness");
    }
}

#[test]
fn thickness_agrees_with_its_twin() {
    let gpu = gpu();
    let body = lattice::cuboid([-1.0, -0.7, -4.0], [14, 10, 16], 0.15, 0.3, 1);
    for camera in [perspective(0.5, 1.2), parallel(0.5, 2.2)] {
        for (radius, scale, smoothing) in
            [(0.09, 1, 0.0), (0.09, 2, 1.0), (0.3, 4, 0.5), (0.01, 2, 1.0), (0.09, 1, 3.0)]
        {
            let mut scene = Scene::new(camera, [161, 120], &body.positions, radius, 0.15);
            for (i, limit) in scene.scene_distance.iter_mut().enumerate() {
                *limit = if i % 161 > 80 { 3.1 } else { NO_SURFACE };
            }
            let frame = scene.render(&gpu, &params("none", scale, smoothing));
            let view = scene.view();
            let profile = params("none", scale, smoothing).thickness.profile_half_px(0.15 / radius).into();
            let sum = twin::thickness_sum(
                &view,
                &[scene.host_set()],
                &scene.scene_distance,
                (scale as usize, profile),
            );
            let expected = twin::thickness_smooth(
                &view,
                &sum,
                (&frame.unfiltered, &frame.radius),
                &scene.scene_distance,
                scale as usize,
                (smoothing.into(), 0.15 / f64::from(radius)),
            );
            let step = 0.15 / 1024.0;
            for (i, (&found, &exact)) in frame.thickness.iter().zip(&expected).enumerate() {
                // Fixed point: each of up to some 40 splats on a ray is rounded by at most a step.
                let tolerance = 40.0 * step + 1e-3 * exact;
                assert!((found - exact).abs() < tolerance, "{i}: {found} {exact}, {radius} {scale}");
                assert_eq!(found > 0.0, is_fluid(frame.distance[i]));
            }
        }
    }
}

/// What many people check first: twice the radius, the same water.
#[test]
fn the_radius_does_not_change_the_mean_thickness() {
    let gpu = gpu();
    let body = lattice::cuboid([-1.0, -1.0, -6.0], [20, 20, 20], 0.1, 0.3, 1);
    let total = |radius| {
        let scene = Scene::new(perspective(0.0, 0.8), [300, 300], &body.positions, radius, 0.1);
        let frame = scene.render(&gpu, &params("none", 2, 1.0));
        mean(frame.thickness.iter().copied())
    };
    let (one, two) = (total(0.0625), total(0.125));
    assert!((two / one - 1.0).abs() < 0.01, "{one} {two}");
}

/// The scene cuts the thickness at its own distance.
#[test]
fn a_floor_inside_the_body_halves_it() {
    let gpu = gpu();
    let body = lattice::cuboid([-1.5, -1.5, -6.0], [30, 30, 20], 0.1, 0.0, 1);
    let mut scene = Scene::new(parallel(0.0, 2.0), [64, 64], &body.positions, 0.0625, 0.1);
    scene.scene_distance.fill(5.0);
    for scale in [1, 2, 4] {
        let frame = scene.render(&gpu, &params("none", scale, 1.0));
        let found = mean(frame.thickness.iter().copied());
        assert!((found - 1.0).abs() < 0.01, "{scale}: {found}");
    }
}

/// Half a million particles in one pixel: the sum stops at half of its range and does not wrap.
#[test]
fn sums_saturate() {
    let gpu = gpu();
    let body = lattice::coincident([0.0, 0.0, -4.0], 500_000, 0.1);
    // A spacing is three pixels, so that a particle is nine spacings thick on the pixel that it fills.
    let scene = Scene::new(parallel(0.0, 17.0 * 0.1 / 3.0), [17, 17], &body.positions, 0.0625, 0.1);
    let frame = scene.render(&gpu, &params("none", 1, 0.0));
    let most = frame.thickness.iter().copied().fold(0.0, f32::max);
    // 2^31 steps of 1/1024 of the spacing.
    let saturated = 2f32.powi(31) * 0.1 / 1024.0;
    assert!((most / saturated - 1.0).abs() < 1e-5, "{most} of {saturated}");
    // Whoever knows how thick it may get is given coarser steps instead; rounded by chance, half a million of them are right.
    let known = Scene { most_thickness: 9.0 * 500_000.0, ..scene };
    let frame = known.render(&gpu, &params("none", 1, 0.0));
    let most = frame.thickness.iter().copied().fold(0.0, f32::max);
    assert!((most / (4.5e6 * 0.1) - 1.0).abs() < 1e-3, "{most}");
}

/// Where sums are known to have room they are kept in another form: block by block the same, at the borders of the picture as well.
#[test]
fn sums_with_room_are_those_that_are_watched() {
    let gpu = gpu();
    // Reaches beyond all borders of the picture; less than 2^21 spacings leave room for the same steps.
    let body = lattice::cuboid([-2.0, -2.0, -6.0], [40, 40, 3], 0.1, 0.2, 1);
    // Points of one to three blocks, and profiles of twenty.
    for (side, scale, height) in [(37, 1, 2.0), (96, 2, 2.0), (61, 4, 2.0), (96, 1, 0.8), (97, 2, 0.4)] {
        let scene = Scene::new(parallel(0.0, height), [side, side - 8], &body.positions, 0.09, 0.1);
        let [watched, roomy] = [f64::INFINITY, 1000.0].map(|most_thickness| {
            let scene = Scene { most_thickness, ..scene.clone() };
            scene.render(&gpu, &params("none", scale, 0.0)).thickness
        });
        let least = watched.iter().copied().fold(f32::INFINITY, f32::min);
        assert!(least > 0.0, "{side}: a pixel without water, {least}");
        // Dozens of particles in a block, each rounded to a step of 1/1024 of a spacing from a product taken in another order.
        let off = watched.iter().zip(&roomy).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off < 4.0 / 1024.0 * 0.1, "{side}: {off}");
    }
}

/// The coarsest steps that are taken instead of watching sums change the thickness by less than a hundredth of a spacing.
#[test]
fn coarse_steps_are_fine_enough() {
    let gpu = gpu();
    let body = lattice::cuboid([-1.0, -1.0, -6.0], [20, 20, 2], 0.1, 0.4, 1);
    for side in [96, 400] {
        let scene = Scene::new(parallel(0.0, 4.0), [side, side], &body.positions, 0.0625, 0.1);
        let [fine, coarse] = [f64::INFINITY, 2f64.powi(31 - 7) * 4.0].map(|most_thickness| {
            Scene { most_thickness, ..scene.clone() }.render(&gpu, &params("none", 2, 1.0)).thickness
        });
        assert_ne!(fine, coarse, "{side}");
        let off = fine.iter().zip(&coarse).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off < 0.01 * 0.1, "{side}: {off}");
    }
}
