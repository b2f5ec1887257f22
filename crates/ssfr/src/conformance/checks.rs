use glam::DVec3;
use meniscus_core::Camera;
use meniscus_gpu::role::NO_SURFACE;

use super::pictures::{
    Picture, SIZE, SPACING_PER_RADIUS, is_surface, mirrored, parallel, perspective, plane,
};
use super::run::Run;

type Outcome = Result<(), String>;

const SMALL_AND_LONG: [[u32; 2]; 6] = [[1, 1], [2, 1], [1, 2], [5, 4], [4097, 3], [3, 300]];

pub(super) fn twin(run: &Run<'_>) -> Outcome {
    let tilted = [perspective(0.7), parallel(2.0)].map(|camera| tilted(camera, 0.1));
    let small = SMALL_AND_LONG.map(|size| Picture::bumpy(perspective(1.0), size, 0.1));
    // The last one is so close that taps of a clean-up may lie apart too.
    let others =
        [(7.3, 90), (40.0, 150), (150.0, 60)].map(|(spacing_px, side)| Picture::lattice(spacing_px, side));
    let others = [&[Picture::step(0.1)], &others[..]].concat();
    let pictures = [&Picture::both_bumpy()[..], &tilted, &small, &others].concat();
    for picture in &pictures {
        let expected = run.on_cpu(picture)?;
        agrees(picture, &run.on_gpu(picture)?, &expected)?;
        // Also where much smaller spheres are taken for typical, and where nothing is known.
        for radii_px in [[0.0, picture.most_radius_px()], [f32::INFINITY; 2]] {
            agrees(picture, &run.of_size(picture, radii_px)?, &expected)?;
        }
    }
    Ok(())
}

fn agrees(picture: &Picture, found: &[f32], expected: &[f32]) -> Outcome {
    // Single precision of distances and of sums over up to a hundred taps. At a threshold the last bit decides to which
    // side a pixel falls: two in a thousand may.
    let off = |i: &usize| {
        let tolerance = 1e-3 * picture.radius[*i] + 4e-6 * expected[*i];
        (found[*i] - expected[*i]).abs() > tolerance
    };
    let pixels: Vec<usize> = (0..found.len()).filter(off).collect();
    if let Some(&first) = pixels.first()
        && pixels.len() * 500 > found.len()
    {
        let (place, found, expected) = (picture.place(first), found[first], expected[first]);
        let others = pixels.len() - 1;
        return Err(format!("the passes make {found} of {place}, the twin {expected}; {others} more differ"));
    }
    Ok(())
}

pub(super) fn empty_stays_empty(run: &Run<'_>) -> Outcome {
    let empty = Picture::new(perspective(1.0), SIZE, 0.1, |_, _| None);
    run.on_cpu(&empty)?;
    run.on_gpu(&empty)?;
    // A picture that is mostly empty, too.
    Picture::both_bumpy().iter().try_for_each(|picture| run.on_gpu(picture).map(|_| ()))
}

pub(super) fn only_fluid_costs(run: &Run<'_>) -> Outcome {
    let empty = Picture::new(perspective(1.0), SIZE, 0.1, |_, _| None);
    if let (_, Some(taps @ 1..)) = run.counted(&empty, true)? {
        return Err(format!("{taps} samples were read for a picture without a surface"));
    }
    // Parallel projection: the same water in the same pixels, in a picture four times as large.
    let disc = |scale: u32| {
        Picture::new(parallel(6.0 * scale as f32), SIZE.map(|side| side * scale), 0.12, |origin, _| {
            (origin.truncate().length() < 1.0).then_some(5.0)
        })
    };
    let taps = |picture: Picture| run.counted(&picture, true).map(|(_, taps)| taps);
    match (taps(disc(1))?, taps(disc(2))?) {
        // Wide kernels reach the small picture's border, where they are cut.
        (Some(small), Some(large)) if large > small + small / 10 => {
            Err(format!("{small} samples were read for some water, {large} for the same with more sky"))
        }
        _ => Ok(()),
    }
}

pub(super) fn zero_radius_is_identity(run: &Run<'_>) -> Outcome {
    for picture in Picture::both_bumpy() {
        let found = run.on_gpu(&picture.with_radius(0.0))?;
        // Distances to keys and back.
        near(&picture, &found, &picture.distance, 1e-6)?;
    }
    Ok(())
}

pub(super) fn constant_planes(run: &Run<'_>) -> Outcome {
    for picture in Picture::flat() {
        // Rounding of distances to keys and back, and of sums: some units in the last place.
        near(&picture, &run.on_gpu(&picture)?, &picture.distance, 1e-6)?;
    }
    Ok(())
}

pub(super) fn tilted_planes(run: &Run<'_>) -> Outcome {
    for camera in cameras_with_exact_planes(run) {
        let picture = tilted(camera, 0.1);
        // As for constant planes; slopes are differences of rounded distances.
        near(&picture, &run.on_gpu(&picture)?, &picture.distance, 4e-6)?;
    }
    Ok(())
}

pub(super) fn silhouettes(run: &Run<'_>) -> Outcome {
    if !run.filter.properties().exact_up_to_silhouettes {
        return Ok(());
    }
    for camera in cameras_with_exact_planes(run) {
        let mut picture = tilted(camera, 0.1);
        let [width, _] = picture.size;
        // Bays and headlands of some twenty pixels, and a few that are cut off.
        let is_there =
            |i: u32| (0.3 * f64::from(i % width)).sin() + (0.37 * f64::from(i / width)).cos() > -0.7;
        for i in (0..picture.distance.len()).filter(|&i| !is_there(i as u32)) {
            (picture.distance[i], picture.radius[i]) = (NO_SURFACE, 0.0);
        }
        near(&picture, &run.on_gpu(&picture)?, &picture.distance, 4e-6)?;
    }
    Ok(())
}

fn cameras_with_exact_planes(run: &Run<'_>) -> impl Iterator<Item = Camera> + use<> {
    let declared = run.filter.properties();
    let cameras = [
        (declared.exact_on_tilted_planes_perspective, perspective(0.7)),
        (declared.exact_on_tilted_planes_parallel, parallel(2.0)),
    ];
    cameras.into_iter().filter_map(|(is_declared, camera)| is_declared.then_some(camera))
}

/// 60 degrees, seen with an axis oblique to the picture.
fn tilted(camera: Camera, radius: f32) -> Picture {
    Picture::new(camera, SIZE, radius, plane(DVec3::new(0.3, 0.8, 0.5), DVec3::new(0.0, 0.0, -5.0)))
}

pub(super) fn noise_does_not_grow(run: &Run<'_>) -> Outcome {
    // Multiplicative hash of the pixel's number, one radius from lowest to highest.
    let noise = |i: usize| f64::from((i as u32).wrapping_mul(2_654_435_769) >> 8) / f64::from(1 << 24) - 0.5;
    for mut picture in Picture::flat() {
        picture = picture.with_radius(0.2);
        for i in 0..picture.distance.len() {
            picture.distance[i] += 0.2 * noise(i) as f32;
        }
        let found = run.on_gpu(&picture)?;
        // Between neighbours in a row, and about the mean.
        let roughness = |image: &[f32]| {
            let steps = image.windows(2).map(|pair| f64::from(pair[1] - pair[0]).powi(2));
            (steps.sum::<f64>() / image.len() as f64).sqrt()
        };
        let spread = |image: &[f32]| {
            let deviations = image.iter().map(|&d| (f64::from(d) - 5.0).powi(2));
            (deviations.sum::<f64>() / image.len() as f64).sqrt()
        };
        for (what, before, after) in [
            ("between neighbours", roughness(&picture.distance), roughness(&found)),
            ("about the plane", spread(&picture.distance), spread(&found)),
        ] {
            // Distances to keys and back.
            if after > before + 1e-6 {
                return Err(format!("noise of {before:.3e} {what} became {after:.3e}"));
            }
        }
    }
    Ok(())
}

pub(super) fn mirror(run: &Run<'_>) -> Outcome {
    for picture in Picture::both_bumpy() {
        let found = run.on_gpu(&picture)?;
        for axis in [0, 1] {
            let other = picture.mirrored(axis);
            let back = mirrored(&run.on_gpu(&other)?, picture.size, axis);
            // The order of additions differs.
            near(&picture, &back, &found, 1e-5).map_err(|e| format!("mirrored along axis {axis}, {e}"))?;
        }
    }
    Ok(())
}

pub(super) fn scaling(run: &Run<'_>) -> Outcome {
    for picture in Picture::both_bumpy() {
        let found = run.on_gpu(&picture)?;
        // Powers of two: nothing is rounded differently, and no pixel falls to the other side of a threshold.
        for factor in [1024.0, 1.0 / 1024.0] {
            let scaled = run.on_gpu(&picture.scaled(factor))?;
            let back: Vec<f32> = scaled.iter().map(|&d| if is_surface(d) { d / factor } else { d }).collect();
            near(&picture, &back, &found, 1e-6).map_err(|e| format!("all lengths times {factor}, {e}"))?;
        }
    }
    Ok(())
}

pub(super) fn nan_never_spreads(run: &Run<'_>) -> Outcome {
    // A speck here and there, also at the border.
    let specks: Vec<usize> = (0..SIZE[0] as usize * SIZE[1] as usize).step_by(611).collect();
    for picture in Picture::both_bumpy() {
        let specked = |distance: f32| {
            let mut other = picture.clone();
            specks.iter().for_each(|&i| other.distance[i] = distance);
            other
        };
        let expected = run.on_gpu(&specked(NO_SURFACE))?;
        for distance in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -5.0, 0.0] {
            let found = run.on_gpu(&specked(distance))?;
            near(&picture, &found, &expected, 0.0).map_err(|e| format!("distances of {distance}: {e}"))?;
            run.on_cpu(&specked(distance))?;
        }
        let sized = |radius: f32| {
            let mut other = picture.clone();
            specks.iter().for_each(|&i| other.radius[i] = radius);
            other
        };
        let expected = run.on_gpu(&sized(0.0))?;
        for radius in [f32::NAN, f32::INFINITY, -1.0] {
            let found = run.on_gpu(&sized(radius))?;
            near(&picture, &found, &expected, 0.0).map_err(|e| format!("radii of {radius}: {e}"))?;
        }
    }
    Ok(())
}

pub(super) fn borders(run: &Run<'_>) -> Outcome {
    // The last sixth of the columns, or of the rows, lies a little further back: within any range, far from the first ones.
    for axis in [0, 1] {
        let [width, height] = SIZE.map(|side| side as usize);
        let last = SIZE[axis] as usize / 6;
        let place = |i: usize| if axis == 0 { i % width } else { i / width };
        let mut picture = Picture::flat()[1].with_radius(0.05);
        for i in (0..width * height).filter(|&i| place(i) + last >= SIZE[axis] as usize) {
            picture.distance[i] = 5.0625;
        }
        let found = run.on_gpu(&picture)?;
        for i in (0..found.len()).filter(|&i| place(i) == 0 || place(i) + 1 == SIZE[axis] as usize) {
            if (found[i] - picture.distance[i]).abs() > 1e-6 * found[i] {
                let (given, found, place) = (picture.distance[i], found[i], picture.place(i));
                return Err(format!("{given} became {found} at {place}, where all around is as far away"));
            }
        }
    }
    Ok(())
}

pub(super) fn tiny_and_huge(run: &Run<'_>) -> Outcome {
    for size in SMALL_AND_LONG {
        for camera in [perspective(1.0), parallel(5.0)] {
            run.on_gpu(&Picture::bumpy(camera, size, 0.1))?;
            // Kernels larger than the picture, even without end, and a plane to lie on.
            for radius in [50.0, 1e6] {
                let flat = Picture::new(camera, size, radius, plane(DVec3::Z, DVec3::new(0.0, 0.0, -5.0)));
                near(&flat, &run.on_gpu(&flat)?, &flat.distance, 1e-6)?;
            }
        }
    }
    Ok(())
}

pub(super) fn no_rings(run: &Run<'_>) -> Outcome {
    // Bumps of 20 pixels and radii from 4 to 18 pixels by 1.5 %: every length of a kernel passes, also those where taps begin
    // to be spread out. In parallel projection every pixel does so at the same radius.
    let size = [64, 64];
    let bumps = Picture::new(parallel(6.4), size, 0.1, |origin, _| {
        Some(50.0 + 0.1 * ((origin.x * 3.1).sin() * (origin.y * 2.9).cos() + 0.5 * (1.7 * origin.x).cos()))
    });
    const STEPS: i32 = 101;
    const GROWTH: f32 = 1.015;
    let mut before = None::<Vec<f32>>;
    let mut changes = Vec::new();
    for step in 0..STEPS {
        let found = run.on_gpu(&bumps.with_radius(0.4 * GROWTH.powi(step)))?;
        if let Some(before) = &before {
            let squares = found.iter().zip(before).map(|(a, b)| f64::from(a - b).powi(2));
            changes.push((squares.sum::<f64>() / found.len() as f64).sqrt());
        }
        before = Some(found);
    }
    // Against the usual change among the nearest twenty steps.
    for (step, change) in changes.iter().enumerate() {
        let first = step.saturating_sub(10).min(changes.len() - 20);
        let mut around = changes[first..first + 20].to_vec();
        around.sort_by(f64::total_cmp);
        let usual = around[10];
        // Distances of 50 are rounded to 4e-6.
        if *change > 4.0 * usual + 1e-5 {
            let radius_px = 4.0 * GROWTH.powi(step as i32);
            return Err(format!(
                "as the radius passes {radius_px:.2} px, the picture changes by {change:.2e}, {:.1} times as much as \
                 around it: a ring",
                change / usual
            ));
        }
    }
    Ok(())
}

pub(super) fn close_ups(run: &Run<'_>) -> Outcome {
    let declared = run.filter.properties();
    let Some(sigma @ 0.8..=3.0) = declared.nominal_sigma else { return Ok(()) };
    for spacing_px in [12.0, 24.0, 40.0] {
        let side = ((3.0 + 6.0 * f64::from(sigma)) * spacing_px) as u32;
        let picture = Picture::lattice(spacing_px, side);
        let found = run.on_gpu(&picture)?;
        // A cell in the middle, away from the border where kernels are cut.
        let middle = |c: usize| (c as f64 - f64::from(side) / 2.0).abs() < 0.5 * spacing_px;
        let depth = |image: &[f32]| {
            let inside = |i: &usize| middle(i % side as usize) && middle(i / side as usize);
            let cell = (0..image.len()).filter(inside).map(|i| image[i]);
            let (low, high) = cell.fold((f32::MAX, f32::MIN), |(l, h), d| (l.min(d), h.max(d)));
            high - low
        };
        // What taps spread out over a close-up cannot see of the creases between spheres: some hundredths.
        let left = depth(&found) / depth(&picture.distance);
        if left > 0.05 {
            return Err(format!(
                "of particles {spacing_px} px apart {:.1} % of the bumps are left",
                100.0 * left
            ));
        }
        // Wider filters take wider steps than the published clean-up (algorithms.md 3.5) evens out.
        if sigma > 1.5 || !declared.even_in_close_ups {
            continue;
        }
        // Bends over four pixels: of what repeats every few pixels all is seen, of what repeats with the particles next to nothing.
        let bend = |i: usize, stride: usize| found[i - 2 * stride] - 2.0 * found[i] + found[i + 2 * stride];
        let cell = (0..found.len()).filter(|i| middle(i % side as usize) && middle(i / side as usize));
        let bends = cell.flat_map(|i| [bend(i, 1), bend(i, side as usize)]);
        let (count, squares) = bends.fold((0, 0.0), |(n, sum), b| (n + 1, sum + b * b));
        let pattern = (squares / count as f32).sqrt() / depth(&picture.distance);
        // Twice what waves of that height bend that repeat with the particles; a ten-thousandth is not seen in any mirror.
        let of_bumps = left * (4.0 * std::f32::consts::PI / spacing_px as f32).powi(2);
        if pattern > 1e-4 + of_bumps {
            return Err(format!(
                "particles {spacing_px} px apart leave a pattern of single pixels, {pattern:.1e} of their depth: taps are too far \
                 apart for what evens them out"
            ));
        }
    }
    Ok(())
}

pub(super) fn nominal_sigma(run: &Run<'_>) -> Outcome {
    let declared = run.filter.properties();
    let Some(sigma) = declared.nominal_sigma else { return Ok(()) };
    // Spheres wide compared to their distance, so that what is rounded is small compared to the impulse, which is a tenth of
    // the distance.
    let (distance, impulse) = (1.0, 0.1);
    let radius = 100.0 * impulse / declared.range_radii.unwrap_or(10.0).max(1.0);
    let spacing = radius * SPACING_PER_RADIUS;
    for spacing_px in [4.3, 8.0, 19.0] {
        let nominal_px = f64::from(sigma) * spacing_px;
        // Less is hardly more than the pixel itself; wider ones are flatter than distances are precise.
        if sigma > 0.0 && !(1.5..30.0).contains(&nominal_px) {
            continue;
        }
        let half = (5.0 * nominal_px).ceil() as u32 + 8;
        let side = 2 * half + 1;
        let px_per_world = spacing_px as f32 / spacing;
        let height_world = side as f32 / px_per_world;
        for camera in [perspective(2.0 * (0.5 * height_world / distance).atan()), parallel(height_world)] {
            let facing = plane(DVec3::Z, DVec3::new(0.0, 0.0, -f64::from(distance)));
            let mut picture = Picture::new(camera, [side; 2], radius, facing);
            let middle = (half * side + half) as usize;
            picture.distance[middle] -= impulse;
            let found = run.on_gpu(&picture)?;
            // Against what became of the plane far from the bump, which rounding may have moved as a whole.
            let plane = f64::from(found[(half * side + half / 8) as usize]);
            let offset =
                |i: usize| [i % side as usize, i / side as usize].map(|c| c as f64 - f64::from(half));
            // Within four sigmas: further out rounding noise outweighs the response.
            let near = |i: &usize| offset(*i).iter().all(|c| c.abs() < 4.0 * nominal_px + 1.0);
            let moment = |axis: usize, power: i32| -> f64 {
                let response = |i: usize| (plane - f64::from(found[i])) * offset(i)[axis].powi(power);
                (0..found.len()).filter(near).map(response).sum()
            };
            for axis in [0, 1] {
                let measured_px = (moment(axis, 2) / moment(axis, 0)).max(0.0).sqrt();
                if (measured_px - nominal_px).abs() > 0.05 * nominal_px + 0.01 {
                    return Err(format!(
                        "a small bump spreads to a sigma of {measured_px:.2} px along axis {axis}, declared are \
                         {sigma} spacings = {nominal_px:.2} px ({:?})",
                        camera.projection
                    ));
                }
            }
        }
    }
    Ok(())
}

pub(super) fn range(run: &Run<'_>) -> Outcome {
    let declared = run.filter.properties();
    let Some(range) = declared.range_radii else { return Ok(()) };
    // The planes are two units apart: twice the range.
    let radius = (1.0 / range).min(0.2);
    let picture = Picture::step(radius);
    let found = run.on_gpu(&picture)?;
    let spacing_px = radius * SPACING_PER_RADIUS * picture.camera.px_per_world(SIZE, 4.0);
    let reach_px = 8.0 * spacing_px * declared.nominal_sigma.unwrap_or(1.0).max(1.0) + 2.0;
    for (pixel, (&found, &given)) in found.iter().zip(&picture.distance).enumerate() {
        let from_edge = ((pixel % SIZE[0] as usize) as f32 + 0.5 - SIZE[0] as f32 / 2.0).abs();
        // The edge of the one in front may be rounded off, the one behind may not come nearer.
        let backwards = if given < 5.0 && from_edge < reach_px { 0.5 } else { 1e-5 };
        if !(-1e-5..backwards).contains(&(found - given)) {
            let place = picture.place(pixel);
            return Err(format!(
                "{given} became {found} at {place}, {from_edge} px from a surface that is twice the range of {range} \
                 radii away"
            ));
        }
    }
    Ok(())
}

/// Whether `found` is `expected` within a fraction of it.
fn near(picture: &Picture, found: &[f32], expected: &[f32], tolerance: f32) -> Outcome {
    for (pixel, (&found, &expected)) in found.iter().zip(expected).enumerate() {
        if is_surface(expected) && (found - expected).abs() > tolerance * expected {
            return Err(format!("{found} instead of {expected} at {}", picture.place(pixel)));
        }
    }
    Ok(())
}
