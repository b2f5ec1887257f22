//! Selection: the promises of `main-renderer.md` 3 to the user.

#[allow(dead_code, reason = "shared with the other tests")]
mod common;

use std::collections::HashMap;

use common::{cameras, center, chunked, kept_slots, of_many_sizes, pool, random, size, viewpoint};
use glam::Vec3;
use meniscus_core::{Camera, CameraError, ParticleFrame, Projection};
use meniscus_gpu::role::{KeptRange, PackedParticle};
use meniscus_lod::select::RANGE_PARTICLES;
use meniscus_lod::weight::kept;
use meniscus_lod::{
    ChunkOptions, ChunkedSet, Identity, LodError, LodParams, Mode, PageSelection, Policy, Selection,
    Selector, Viewpoint, chunks, select,
};
use proptest::prelude::*;

const SIZE: [u32; 2] = [640, 360];
const RADIUS: f32 = 0.625;
const POLICIES: [Policy; 2] = [Policy::Default, Policy::Thesis];

fn at(threshold: f32) -> LodParams {
    LodParams { threshold, ..Default::default() }
}

fn seen_by(camera: &Camera) -> Viewpoint {
    viewpoint(camera, SIZE, RADIUS)
}

fn choose(set: &ChunkedSet, camera: &Camera, params: &LodParams) -> Selection {
    select(set, &seen_by(camera), params).unwrap()
}

/// All ranges that the surface is drawn from.
fn surface(selection: &Selection) -> impl Iterator<Item = &KeptRange> {
    selection.pages.iter().flat_map(PageSelection::surface)
}

/// Views of a 64^3 pool: from outside, and from inside along the surface with most of it out of the picture.
fn views() -> Vec<Camera> {
    let mut views = cameras(Vec3::new(-60.0, -40.0, 90.0), Vec3::new(32.0, 32.0, 20.0)).to_vec();
    views.extend(cameras(Vec3::new(20.0, 10.0, 66.0), Vec3::new(60.0, 40.0, 50.0)));
    views
}

#[test]
fn the_threshold_is_the_kept_fraction() {
    let set = chunked(&pool([64, 64, 64], 40));
    for camera in views() {
        for threshold in [0.1, 0.2, 0.3, 0.6, 0.9, 0.99] {
            let selection = choose(&set, &camera, &at(threshold));
            let fraction = selection.counts.kept as f64 / selection.visible as f64;
            let off = fraction / f64::from(threshold) - 1.0;
            // The specification's 2 %; the spread of the hashes of the smallest count here (3,000) has a deviation of
            // at most 1.8 % under uniform p and less under the fixed hashes of this set.
            assert!(off.abs() < 0.02, "{camera:?} at {threshold}: {fraction} of {}", selection.visible);
        }
    }
}

#[test]
fn what_is_kept_stays_kept_under_higher_thresholds() {
    let pool = pool([48, 48, 24], 40);
    let sets = [chunked(&pool), chunked(&of_many_sizes(pool))];
    for (set, policy) in sets.iter().flat_map(|set| POLICIES.map(|policy| (set, policy))) {
        for camera in views() {
            let mut before: HashMap<usize, u32> = HashMap::new();
            let close: Vec<f32> =
                std::iter::successors(Some(0.37f32), |t| Some(t.next_up())).take(4).collect();
            for threshold in [&[0.0, 1e-6, 0.01, 0.2], close.as_slice(), &[0.5, 0.8, 0.999, 1.0]].concat() {
                let now: HashMap<usize, u32> =
                    kept_slots(set, &choose(set, &camera, &LodParams { policy, ..at(threshold) }))
                        .into_iter()
                        .collect();
                for (slot, keep) in &before {
                    assert!(now.get(slot).is_some_and(|now| now >= keep), "{policy:?} {threshold} {slot}");
                }
                before = now;
            }
            assert!(!before.is_empty());
        }
    }
}

#[test]
fn full_detail_keeps_every_particle_of_the_chunks_in_view_as_it_is() {
    let set = chunked(&pool([40, 40, 20], 40));
    for policy in POLICIES {
        for camera in views() {
            let selection = choose(&set, &camera, &LodParams { policy, ..at(1.0) });
            assert_eq!(selection.counts.kept, selection.visible);
            assert!(surface(&selection).all(|range| range.keep == KeptRange::KEEP_ALL));
            let mut slots: Vec<usize> = kept_slots(&set, &selection).iter().map(|k| k.0).collect();
            slots.sort_unstable();
            slots.dedup();
            assert_eq!(slots.len() as u64, selection.visible, "a particle is drawn twice");
        }
    }
}

/// The volume that counts in the thickness is that of the particles in view, whatever their sizes.
#[test]
fn particles_of_many_sizes_keep_their_volume() {
    let set = chunked(&of_many_sizes(pool([48, 48, 24], 40)));
    let volume = |particle: &PackedParticle| f64::from(size(particle)).powi(3);
    for policy in POLICIES {
        // From so far that stand-ins take their places, and all is in view.
        for camera in cameras(Vec3::new(-300.0, -200.0, 400.0), Vec3::new(24.0, 24.0, 12.0)) {
            let camera = Camera {
                projection: match camera.projection {
                    Projection::Orthographic { .. } => Projection::Orthographic { height_world: 300.0 },
                    perspective => perspective,
                },
                ..camera
            };
            let selection = choose(&set, &camera, &LodParams { policy, ..at(0.7) });
            assert_eq!(selection.visible, set.particles.len() as u64);
            assert!(!selection.is_uniform_mass && !selection.is_uniform_surface && selection.has_sizes);
            let [mut found, mut variance] = [0.0; 2];
            for range in selection.pages.iter().flat_map(|page| &page.mass) {
                for particle in &set.particles[range.first as usize..][..range.count as usize] {
                    let kept = kept(particle.packed, range.keep, 1.0).expect("a kept prefix");
                    found += volume(particle) * f64::from(kept.weight);
                    variance += (volume(particle) * f64::from(kept.weight)).powi(2);
                }
            }
            let stand_ins = selection.pages.iter().flat_map(|page| &page.stand_ins);
            let spheres = stand_ins.flat_map(|r| &set.stand_ins[0][r.first as usize..][..r.count as usize]);
            found += spheres
                .map(|sphere| f64::from(half::f16::from_bits((sphere.packed & 0xffff) as u16)))
                .sum::<f64>();
            let all: f64 = set.particles.iter().map(volume).sum();
            // Half a unit in the last place of the stand-ins' volumes, and four deviations of what was left to chance.
            let tolerance = all / 2048.0 + if policy == Policy::Thesis { 4.0 * variance.sqrt() } else { 0.0 };
            assert!((found - all).abs() < tolerance, "{policy:?}: {found} of {all} +- {tolerance}");
        }
    }
}

/// Chunks are culled, and tested, with the spheres of their largest particles.
#[test]
fn large_particles_show_from_outside_of_the_picture_and_in_front_of_what_hides_others() {
    let [camera, _] = cameras(Vec3::new(0.0, -20.0, 0.0), Vec3::ZERO);
    // Twenty away the picture is 17.2 wide to either side.
    let beside = |size| {
        let (positions, sizes) = (vec![[22.0, 0.0, 0.0]], vec![size]);
        let set = chunked(&ParticleFrame { positions, sizes, ..Default::default() });
        choose(&set, &camera, &at(1.0)).counts.kept
    };
    assert_eq!((beside(1.0), beside(16.0)), (0, 1));

    let set = chunked(&of_many_sizes(pool([40, 40, 20], 0)));
    let mut tested = 0;
    for camera in views() {
        let view = camera.view_from_world();
        let selection = choose(&set, &camera, &at(1.0));
        for occludee in selection.pages.iter().flat_map(|page| &page.occludees) {
            let range = occludee.range;
            for particle in &set.particles[range.first as usize..][..range.count as usize] {
                let front = -view.transform_point3(center(particle)).z - RADIUS * size(particle);
                assert!(front >= occludee.front, "{front} in front of {}", occludee.front);
                tested += 1;
            }
        }
    }
    assert!(tested > 1000, "{tested}");
}

#[test]
fn a_kept_prefix_is_the_predicate() {
    let set = chunked(&pool([48, 48, 24], 40));
    // So many that some hashes fall right on their chunk's border.
    for (camera, step) in views().into_iter().flat_map(|camera| (1..20).map(move |step| (camera, step))) {
        let selection = choose(&set, &camera, &at(step as f32 / 20.0));
        let keep_of: HashMap<usize, u32> = kept_slots(&set, &selection).into_iter().collect();
        for chunk in &set.chunks {
            let first = set.page_slots(chunk.page as usize).start + chunk.first as usize;
            let (isolated, all) = (chunk.isolated as usize, chunk.count as usize);
            let buried = isolated + chunk.shell as usize;
            for part in [0..isolated, isolated..buried, buried..all] {
                let part = first + part.start..first + part.end;
                let Some(&keep) = part.clone().find_map(|slot| keep_of.get(&slot)) else { continue };
                for slot in part {
                    let inside = u32::from(set.particles[slot].hash()) < keep;
                    assert_eq!(keep_of.get(&slot), inside.then_some(&keep));
                    assert_eq!(kept(set.particles[slot].packed, keep, 1.0).is_some(), inside);
                }
            }
        }
    }
}

/// Volume that counts in the thickness, in particles.
fn volume(set: &ChunkedSet, selection: &Selection) -> f64 {
    let mut volume = 0.0;
    for (page, of_page) in selection.pages.iter().enumerate() {
        let particles = &set.particles[set.page_slots(page)];
        for range in &of_page.mass {
            let slots = range.first as usize..(range.first + range.count) as usize;
            let kept = particles[slots].iter().filter_map(|p| kept(p.packed, range.keep, 1.0));
            volume += kept.map(|kept| f64::from(kept.weight)).sum::<f64>();
        }
        for range in &of_page.stand_ins {
            let spheres = &set.stand_ins[page][range.first as usize..(range.first + range.count) as usize];
            volume += spheres.iter().map(|s| half::f16::from_bits(s.packed as u16).to_f64()).sum::<f64>();
        }
    }
    volume
}

#[test]
fn the_volume_is_that_of_all_whatever_is_kept() {
    let set = chunked(&pool([64, 64, 32], 0));
    assert!(set.chunks.iter().all(|chunk| chunk.isolated == 0), "those would count by their weights");
    let mut stand_ins = 0;
    for camera in views() {
        for threshold in [1e-6, 0.1, 0.3, 0.6, 0.95, 1.0] {
            let selection = choose(&set, &camera, &at(threshold));
            assert_eq!(volume(&set, &selection), selection.visible as f64, "{threshold}");
            assert!(threshold < 1.0 || selection.counts.stand_ins == 0, "full detail has none");
            stand_ins += selection.counts.stand_ins;
        }
        for (error_px, error_color) in [(0.0, 0.0), (0.5, 0.004), (4.0, 0.1), (1e6, 1.0)] {
            let bound = LodParams { mode: Mode::ErrorBound, error_px, error_color, ..at(1.0) };
            let selection = choose(&set, &camera, &bound);
            assert_eq!(volume(&set, &selection), selection.visible as f64, "{bound:?}");
        }
    }
    assert!(stand_ins > 1000, "{stand_ins} say little");
}

/// All particles in view piled up in one pixel are no thicker than the selection says, and not much less.
#[test]
fn a_pile_of_all_is_as_thick_as_was_said() {
    let set = chunked(&pool([64, 64, 64], 40));
    for (nth, camera) in views().iter().enumerate() {
        let half_extent = camera.half_extent(SIZE);
        let px_at_one = SIZE[1] as f32 / (2.0 * half_extent.y);
        let right = camera.forward().cross(camera.up).normalize();
        let thickness = |particle: &PackedParticle| {
            let away = Vec3::from(particle.position_world) - camera.eye;
            let distance = away.dot(camera.forward());
            // Length along the ray per distance.
            let (depth, slant) =
                if camera.is_orthographic() { (1.0, 1.0) } else { (distance, away.length() / distance) };
            let x = away.dot(right).abs() / depth;
            let y = away.dot(right.cross(camera.forward())).abs() / depth;
            let is_seen = distance > camera.near && x <= half_extent.x && y <= half_extent.y;
            if is_seen { f64::from((px_at_one / depth).powi(2) * slant) } else { 0.0 }
        };
        let pile: f64 = set.particles.iter().map(thickness).sum();
        for threshold in [0.3, 1.0] {
            let said = choose(&set, camera, &at(threshold)).most_thickness;
            assert!(pile <= said, "{nth}, {threshold}: {pile} of {said}");
            // Chunks reach nearer than their particles, and all is taken to lie in a corner: here by a factor of two. Near the
            // eye by more.
            assert!(nth > 1 || said < 3.0 * pile, "{nth}, {threshold}: {pile} of {said}");
        }
        // What is kept for others may weigh anything.
        let thinned = choose(&set, camera, &LodParams { policy: Policy::Thesis, ..at(0.3) });
        assert_eq!(thinned.most_thickness.is_infinite(), !thinned.is_uniform_mass, "{nth}");
    }
}

#[test]
fn the_size_of_what_is_drawn_first_is_told() {
    let set = chunked(&pool([64, 64, 64], 40));
    for (camera, threshold) in views().into_iter().flat_map(|camera| [(camera, 0.3), (camera, 1.0)]) {
        let selection = choose(&set, &camera, &at(threshold));
        let [page] = &selection.pages[..] else { panic!("one page") };
        let slots = page.front.iter().flat_map(|range| range.first..range.first + range.count);
        let squares: Vec<f64> = slots
            .map(|slot| Vec3::from(set.particles[slot as usize].position_world))
            .map(|at| (at - camera.eye).dot(camera.forward()).max(camera.near))
            .map(|distance| f64::from(RADIUS * camera.px_per_world(SIZE, distance)).powi(2))
            .collect();
        let exact = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        let told = f64::from(selection.front_half_px());
        // All particles of a chunk count as the one in its middle: beside the eye that is off by more, which shows what is before it.
        assert!((told / exact - 1.0).abs() < 0.1, "{told} {exact} at {threshold}, {camera:?}");
    }
    assert_eq!(choose(&chunked(&ParticleFrame::default()), &views()[0], &at(1.0)).front_half_px(), 0.0);
}

#[test]
fn no_sphere_is_larger_than_is_told() {
    let set = chunked(&pool([64, 64, 64], 40));
    for (camera, threshold) in
        views().into_iter().flat_map(|camera| [(camera, 0.1), (camera, 0.6), (camera, 1.0)])
    {
        let selection = choose(&set, &camera, &at(threshold));
        let radii_px = kept_slots(&set, &selection).into_iter().filter_map(|(slot, keep)| {
            let particle = &set.particles[slot];
            let radius = RADIUS * kept(particle.packed, keep, 1.0)?.radius;
            let front = (center(particle) - camera.eye).dot(camera.forward()) - radius;
            (front >= camera.near).then(|| radius * camera.px_per_world(SIZE, front))
        });
        let most = radii_px.fold(0.0, f32::max);
        let told = selection.most_radius_px;
        // From outside and at full detail, what is nearest shows: elsewhere it may reach before the near distance, or be of those that
        // did not grow.
        let is_exact = camera.eye.z > 70.0 && threshold == 1.0;
        assert!(
            told >= most && (!is_exact || told < 1.02 * most),
            "{told} {most} at {threshold}, {camera:?}"
        );
    }
    assert_eq!(choose(&chunked(&ParticleFrame::default()), &views()[0], &at(1.0)).most_radius_px, 0.0);
}

#[test]
fn larger_errors_give_fewer_and_coarser() {
    let set = chunked(&pool([64, 64, 32], 0));
    let camera = views()[0];
    let mut before = [u64::MAX; 2];
    for error_px in [0.0, 0.2, 0.5, 2.0, 8.0, 64.0] {
        let bound = LodParams { mode: Mode::ErrorBound, error_px, error_color: 0.0, ..at(1.0) };
        let selection = choose(&set, &camera, &bound);
        let drawn = selection.pages.iter().flat_map(|page| page.mass.iter().chain(&page.stand_ins));
        let now = [selection.counts.kept, drawn.map(|range| u64::from(range.count)).sum()];
        assert!(now[0] <= before[0] && now[1] <= before[1], "{error_px}: {now:?} after {before:?}");
        before = now;
    }
    let visible = choose(&set, &camera, &at(1.0)).visible;
    assert!(before[0] < visible / 100 && before[1] < visible / 100, "{before:?} of {visible}");
}

#[test]
fn a_tolerated_error_thins_what_does_not_show_faster() {
    let set = chunked(&pool([64, 64, 32], 0));
    let camera = views()[0];
    // Particles are two to four pixels apart.
    let bound = LodParams { mode: Mode::ErrorBound, error_px: 4.0, error_color: 0.0, ..at(1.0) };
    let selection = choose(&set, &camera, &bound);
    let keep_of: HashMap<usize, u32> = kept_slots(&set, &selection).into_iter().collect();
    let mean = |part: fn(&meniscus_lod::Chunk) -> std::ops::Range<u32>| {
        let slots = set.chunks.iter().flat_map(|chunk| {
            let first = set.page_slots(chunk.page as usize).start + chunk.first as usize;
            part(chunk).map(move |local| first + local as usize)
        });
        let (kept, all) = slots
            .fold((0, 0), |(kept, all), slot| (kept + usize::from(keep_of.contains_key(&slot)), all + 1));
        kept as f64 / all as f64
    };
    let shell = mean(|chunk| chunk.isolated..chunk.isolated + chunk.shell);
    let buried = mean(|chunk| chunk.isolated + chunk.shell..chunk.count);
    assert!(
        shell < 0.9 && buried > 0.0 && buried < 0.5 * shell,
        "{shell} of the shell, {buried} of what is buried"
    );
}

#[test]
fn few_stand_ins_of_many_chunks_lie_side_by_side() {
    let set = chunked(&pool([64, 64, 64], 0));
    let bound = LodParams { mode: Mode::ErrorBound, error_px: 64.0, error_color: 0.0, ..at(1.0) };
    let selection = choose(&set, &views()[0], &bound);
    let runs: usize = selection.pages.iter().map(|page| page.stand_ins.len()).sum();
    // One or two a chunk; fewer than a workgroup has lanes leave most of them idle.
    assert!(
        selection.counts.stand_ins as usize >= 64 * runs,
        "{runs} runs of {}",
        selection.counts.stand_ins
    );
}

#[test]
fn the_thesis_weighs_what_it_keeps() {
    let frame = pool([64, 64, 32], 0);
    for seed in 0..4u64 {
        let ids = (0..frame.len() as u64).map(|i| i + (seed << 40)).collect();
        let set = chunked(&ParticleFrame { ids, ..frame.clone() });
        for camera in views() {
            for threshold in [0.7, 0.95] {
                let selection = choose(&set, &camera, &LodParams { policy: Policy::Thesis, ..at(threshold) });
                let slots = kept_slots(&set, &selection);
                // What it leaves out in whole has no weight: the kept stand for the chunks that keep any.
                let n: f64 = slots.iter().map(|&(_, keep)| 65536.0 / f64::from(keep)).sum();
                // A weight is 1/p on p of the hashes but for the ramp, which makes its mean square 1.07/p
                // ((1 - 2/3 0.2) / (1 - 0.2/2)^2). The variance of the sum, estimated from the kept, each of which
                // stands for 1/p; five deviations.
                let variance: f64 = slots
                    .iter()
                    .map(|&(_, keep)| f64::from(keep) / 65536.0)
                    .map(|p| (1.07 / p - 1.0) / p)
                    .sum();
                let bound = 5.0 * variance.sqrt();
                let sum = volume(&set, &selection);
                assert!((sum - n).abs() < bound, "{threshold}: {sum} for {n} +- {bound}");
                assert!(bound < 0.2 * n, "the bound must be worth something: {bound} of {n}");
            }
        }
    }
}

#[test]
fn nothing_beyond_the_far_distance_is_drawn() {
    let set = chunked(&pool([64, 64, 32], 0));
    let camera = views()[0];
    let all = choose(&set, &camera, &at(1.0));
    let half = choose(&set, &camera, &LodParams { far: Some(110.0), ..at(1.0) });
    assert!(half.visible > 0 && half.visible < all.visible, "{} of {}", half.visible, all.visible);
    let beyond =
        |&(slot, _): &(usize, u32)| (center(&set.particles[slot]) - camera.eye).dot(camera.forward());
    // A chunk of 512 at spacing 1 is at most twenty across.
    assert!(kept_slots(&set, &half).iter().map(beyond).all(|distance| distance < 130.0));
    assert_eq!(choose(&set, &camera, &LodParams { far: Some(1e-3), ..at(1.0) }).visible, 0);
}

#[test]
fn spray_is_spared_while_larger_than_a_pixel_and_starves_nobody() {
    let set = chunked(&pool([20, 20, 20], 160));
    let near = cameras(Vec3::new(-30.0, -100.0, 60.0), Vec3::new(60.0, 40.0, 30.0))[0];
    for threshold in [0.0, 0.02, 0.05, 0.5] {
        let selection = choose(&set, &near, &at(threshold));
        let spray = |slot: usize| set.particles[slot].position_world[2] > 30.0;
        let slots = kept_slots(&set, &selection);
        let in_chunks =
            set.chunks.iter().filter(|c| c.isolated > 0).map(|c| u64::from(c.isolated)).sum::<u64>();
        assert_eq!(in_chunks, 160);
        let (spray, water): (Vec<_>, Vec<_>) = slots.into_iter().partition(|&(slot, _)| spray(slot));
        assert_eq!(spray.len(), 160, "at {threshold}");
        assert!(spray.iter().all(|&(_, keep)| keep == KeptRange::KEEP_ALL));
        // The spray is paid for out of the threshold, here to 0.02, but the water keeps at least half of its own.
        let expected = (threshold * 8160.0 - 160.0).max(threshold * 0.5 * 8160.0);
        // Five deviations of a count.
        assert!(
            (water.len() as f32 - expected).abs() <= 5.0 * expected.sqrt(),
            "{}: {expected}",
            water.len()
        );
    }
    // From so far away that they are a tenth of a pixel, isolated particles are thinned like all others.
    let far = Camera { eye: Vec3::new(-4000.0, 0.0, 0.0), target: Vec3::ZERO, ..near };
    let selection = choose(&set, &far, &at(0.05));
    assert_eq!(selection.counts.chunks_culled, 0);
    assert!(surface(&selection).all(|range| range.keep < 8000));
    assert_eq!(choose(&set, &far, &at(0.0)).counts.kept, 0);
}

#[test]
fn near_and_central_chunks_keep_more() {
    let set = chunked(&pool([128, 32, 16], 0));
    for policy in POLICIES {
        let camera = cameras(Vec3::new(-20.0, 16.0, 20.0), Vec3::new(60.0, 16.0, 8.0))[0];
        let selection = choose(&set, &camera, &LodParams { policy, ..at(0.4) });
        let ranges = &selection.pages[0].front;
        let depth = |r: &KeptRange| {
            let slots = r.first as usize..(r.first + r.count) as usize;
            let sum: Vec3 = set.particles[slots].iter().map(center).sum();
            (sum / r.count as f32 - camera.eye).dot(camera.forward())
        };
        let (near, far) = (ranges.first().unwrap(), ranges.last().unwrap());
        assert!(near.keep > far.keep && depth(near) < depth(far), "{policy:?}: {near:?} {far:?}");
        let slots = kept_slots(&set, &selection);
        let chunk_of = |slot: usize| {
            set.chunks.iter().position(|c| (c.first..c.first + c.count).contains(&(slot as u32))).unwrap()
        };
        let mut order: Vec<usize> = ranges.iter().map(|r| chunk_of(r.first as usize)).collect();
        order.dedup();
        let nearest = |&chunk: &usize| {
            let corners = set.chunks[chunk].bounds.corners();
            corners.map(|c| (c - camera.eye).dot(camera.forward())).into_iter().fold(f32::INFINITY, f32::min)
        };
        // 1e-4: f32 rounding of coordinates of size 100 in a sum of three.
        assert!(order.windows(2).all(|pair| nearest(&pair[0]) <= nearest(&pair[1]) + 1e-4), "{policy:?}");
        assert!(slots.len() > 1000 && order.len() > 5, "{policy:?}: {} in {}", slots.len(), order.len());
    }
}

#[test]
fn the_thesis_policy_keeps_levels_above_one_minus_the_threshold() {
    let frame = pool([64, 32, 16], 0);
    let identity = Policy::Thesis.identity();
    assert_eq!(identity, Identity::Position);
    let set = chunks::build(&frame, &ChunkOptions { identity, ..ChunkOptions::new(1 << 20, 1.0) });
    let camera = cameras(Vec3::new(-30.0, 16.0, 40.0), Vec3::new(32.0, 16.0, 8.0))[0];
    let full = choose(&set, &camera, &LodParams { policy: Policy::Thesis, ..at(1.0) });
    assert_eq!(full.counts.chunks_culled, 0, "the mean below is over all chunks");
    let importance = |center: Vec3| {
        let v = camera.view_from_world().transform_point3(center);
        let half = camera.half_extent(SIZE);
        let d = -v.z;
        let d_c_by_d_max = (v.x / d).hypot(v.y / d) / half.length();
        f64::from(1000.0 * (1.0 - 0.7 * d_c_by_d_max).max(0.3) / d)
    };
    let clod = set.chunks.iter().map(|c| importance(c.bounds.center()) * f64::from(c.count)).sum::<f64>()
        / frame.len() as f64;
    let threshold = 0.6f32;
    let selection = choose(&set, &camera, &LodParams { policy: Policy::Thesis, ..at(threshold) });
    let keep_of: HashMap<usize, u32> = kept_slots(&set, &selection).into_iter().collect();
    let mut compared = 0;
    for chunk in &set.chunks {
        let w = importance(chunk.bounds.center());
        // l / (1 + l) = 1 - t at the least random number kept.
        let level = f64::from(1.0 - threshold) / f64::from(threshold);
        let expected = (1.0 - level * clod / w).max(0.0) * 65536.0;
        let mut slots = chunk.first as usize..(chunk.first + chunk.count) as usize;
        let Some(keep) = slots.find_map(|slot| keep_of.get(&slot).copied()) else {
            // The smallest of its hashes is not below the probability.
            let least = set.particles_of(chunk).iter().map(|p| p.hash()).min().unwrap();
            assert!(expected <= f64::from(least) + 1.6, "{expected} {least}");
            continue;
        };
        compared += 1;
        // One step for rounding to an integer, and f32 rounding of w in the product, 65536 * 1e-6.
        assert!((f64::from(keep) - expected).abs() < 1.6, "{keep} {expected}");
    }
    assert!(compared > set.chunks.len() / 2);
}

#[test]
fn ranges_are_short_and_even() {
    let set = chunked(&pool([40, 40, 20], 0));
    for threshold in [0.3, 1.0] {
        let selection = choose(&set, &views()[0], &at(threshold));
        let total: u64 = surface(&selection).map(|r| u64::from(r.count)).sum();
        assert_eq!(total, selection.counts.kept);
        for range in surface(&selection) {
            assert!((1..=RANGE_PARTICLES).contains(&range.count));
            assert!((1..=KeptRange::KEEP_ALL).contains(&range.keep));
        }
    }
}

/// Ranges of shells, also in pieces, say where the shapes of their particles are; the others have none.
#[test]
fn ranges_of_shells_know_their_shapes() {
    let set = chunks::build(&pool([40, 40, 20], 30), &ChunkOptions::new(5000, 1.0));
    let selection = choose(&set, &views()[0], &at(0.7));
    let mut shaped = 0;
    for (page, of_page) in selection.pages.iter().enumerate() {
        let chunks: Vec<_> = set.chunks.iter().filter(|chunk| chunk.page as usize == page).collect();
        let places: u32 = chunks.iter().map(|chunk| chunk.shell).sum();
        assert_eq!(set.shapes_in(page), places as usize);
        for range in of_page.surface() {
            let chunk = chunks.iter().rfind(|chunk| chunk.first <= range.first).unwrap();
            let shell = chunk.first + chunk.isolated..chunk.first + chunk.isolated + chunk.shell;
            let expected =
                shell.contains(&range.first).then(|| 1 + chunk.first_shape + range.first - shell.start);
            assert_eq!(range.shape, expected.unwrap_or(0), "{range:?} of {chunk:?}");
            shaped += u32::from(range.shape > 1);
        }
        assert!(of_page.mass.iter().all(|range| range.shape == 0));
    }
    assert!(shaped > 10, "{shaped}");
}

/// What reaches farther is left out later: outside of the picture, and behind others.
#[test]
fn shells_that_reach_farther_are_seen_earlier() {
    let set = chunked(&pool([40, 40, 20], 0));
    let camera = Camera { target: views()[0].target + Vec3::new(0.0, 0.0, 40.0), ..views()[0] };
    let of = |shell_reach: f32| {
        let viewpoint = Viewpoint { shell_reach, ..seen_by(&camera) };
        select(&set, &viewpoint, &at(1.0)).unwrap()
    };
    let (spheres, ellipsoids) = (of(1.0), of(4.0));
    assert!(ellipsoids.counts.chunks_culled < spheres.counts.chunks_culled);
    let front = |selection: &Selection, range: u32| {
        let tested = selection.pages.iter().flat_map(|page| &page.occludees);
        tested.filter(|o| o.range.first == range).map(|o| o.front).next()
    };
    let mut nearer = 0;
    for tested in spheres.pages.iter().flat_map(|page| &page.occludees) {
        let found = front(&ellipsoids, tested.range.first).unwrap();
        // Buried ones are spheres in any case.
        let expected =
            if tested.range.shape > 0 { tested.front - found > 0.1 } else { tested.front == found };
        assert!(expected, "{tested:?} {found}");
        nearer += u32::from(tested.range.shape > 0);
    }
    assert!(nearer > 10, "{nearer}");
}

#[test]
fn pages_get_their_own_ranges_and_threads_change_nothing() {
    let frame = pool([40, 40, 20], 30);
    let one_page = chunked(&frame);
    let set = chunks::build(&frame, &ChunkOptions::new(5000, 1.0));
    assert!(set.pages().len() > 6);
    for camera in views() {
        let positions = |set: &ChunkedSet| {
            let slots = kept_slots(set, &choose(set, &camera, &at(1.0)));
            let mut bits: Vec<_> =
                slots.iter().map(|k| set.particles[k.0].position_world.map(f32::to_bits)).collect();
            bits.sort_unstable();
            bits
        };
        assert_eq!(positions(&set), positions(&one_page));
        let on = |threads| {
            let threads = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            threads.install(|| choose(&set, &camera, &at(0.3)))
        };
        assert_eq!(on(1), on(4));
    }
}

#[test]
fn degenerate_sets_and_views_give_what_is_there() {
    let behind = |camera: &Camera| Camera { target: camera.eye * 2.0 - camera.target, ..*camera };
    for frame in [
        ParticleFrame::default(),
        ParticleFrame { positions: vec![[32.0, 32.0, 20.0]], ..Default::default() },
        ParticleFrame { positions: vec![[32.0, 32.0, 20.0]; 1_000_000], ..Default::default() },
    ] {
        let set = chunked(&frame);
        for policy in POLICIES {
            for camera in &views()[..2] {
                for threshold in [0.0, f32::MIN_POSITIVE, 0.3, 1.0] {
                    let params = LodParams { policy, ..at(threshold) };
                    let selection = choose(&set, camera, &params);
                    assert_eq!(selection.visible, frame.len() as u64);
                    let hidden = choose(&set, &behind(camera), &params);
                    assert_eq!((hidden.visible, hidden.counts.kept), (0, 0));
                    assert_eq!(hidden.counts.chunks_culled, set.chunks.len() as u64);
                    if frame.len() > 1 && policy == Policy::Default {
                        // Equal points have equal importance: p is the threshold. 0.5 % is five deviations at 0.3.
                        let off = selection.counts.kept as f32 / 1e6 - threshold;
                        assert!(off.abs() < 0.005, "{threshold}: {off}");
                    }
                }
            }
        }
    }
}

#[test]
fn nonsense_is_refused_in_words() {
    let set = chunked(&pool([4, 4, 4], 0));
    let camera = views()[0];
    for threshold in [f32::NAN, -0.1, 1.1, f32::INFINITY] {
        assert!(matches!(at(threshold).validate(), Err(LodError::Threshold(_))), "{threshold}");
        assert!(select(&set, &seen_by(&camera), &at(threshold)).is_err());
    }
    for bound in [
        LodParams { error_px: f32::NAN, ..at(1.0) },
        LodParams { error_px: -1.0, ..at(1.0) },
        LodParams { error_color: 1.5, ..at(1.0) },
        LodParams { far: Some(f32::NAN), ..at(1.0) },
        LodParams { far: Some(0.0), ..at(1.0) },
    ] {
        assert!(matches!(bound.validate(), Err(LodError::Parameter { .. })), "{bound:?}");
        assert!(select(&set, &seen_by(&camera), &bound).is_err());
    }
    let lost = Camera { eye: Vec3::NAN, ..camera };
    assert_eq!(select(&set, &seen_by(&lost), &at(0.5)), Err(LodError::Camera(CameraError::NotFinite("eye"))));
    let empty = Viewpoint { size_px: [640, 0], ..seen_by(&camera) };
    assert_eq!(select(&set, &empty, &at(0.5)), Err(LodError::EmptyPicture([640, 0])));
    for radius in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let viewpoint = Viewpoint { radius_world: radius, ..seen_by(&camera) };
        assert!(matches!(select(&set, &viewpoint, &at(0.5)), Err(LodError::Radius(_))));
        let viewpoint = Viewpoint { spacing_world: radius, ..seen_by(&camera) };
        assert!(matches!(select(&set, &viewpoint, &at(0.5)), Err(LodError::Spacing(_))));
    }
}

#[test]
fn a_selection_is_made_again_only_when_something_has_changed() {
    let frame = pool([20, 20, 20], 4);
    let (set, same_again) = (chunked(&frame), chunked(&frame));
    let view = seen_by(&views()[0]);
    let mut selector = Selector::default();
    assert!(selector.update(&set, &view, &at(0.5)).unwrap());
    let first = selector.selection().clone();
    assert_eq!(first, select(&set, &view, &at(0.5)).unwrap());
    assert!(!selector.update(&set, &view, &at(0.5)).unwrap());
    assert_eq!(*selector.selection(), first);

    let turned = seen_by(&Camera { eye: view.camera.eye + 1.0, ..view.camera });
    let smaller = Viewpoint { size_px: [320, 200], ..turned };
    let fatter = Viewpoint { radius_world: 0.7, ..smaller };
    let wider = Viewpoint { spacing_world: 1.1, ..fatter };
    let thesis = LodParams { policy: Policy::Thesis, ..at(0.4) };
    assert!(selector.update(&set, &turned, &at(0.5)).unwrap(), "camera");
    assert!(selector.update(&set, &smaller, &at(0.5)).unwrap(), "size");
    assert!(selector.update(&set, &fatter, &at(0.5)).unwrap(), "radius");
    assert!(selector.update(&set, &wider, &at(0.5)).unwrap(), "spacing");
    assert!(selector.update(&set, &wider, &at(0.4)).unwrap(), "threshold");
    assert!(selector.update(&set, &wider, &thesis).unwrap(), "policy");
    assert!(selector.update(&same_again, &wider, &thesis).unwrap(), "data");
    assert!(!selector.update(&same_again, &wider, &thesis).unwrap());

    let before = selector.selection().clone();
    assert!(selector.update(&set, &Viewpoint { size_px: [0, 0], ..wider }, &thesis).is_err());
    assert_eq!(*selector.selection(), before);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    /// A point of a drawn sphere that projects into the picture, at or beyond the near plane, belongs to a chunk in view.
    #[test]
    fn culling_never_drops_what_shows(
        seed in any::<u64>(),
        eye in prop::array::uniform3(-30.0f32..30.0),
        target in prop::array::uniform3(-10.0f32..10.0),
        offset in prop::array::uniform3(-1e4f32..1e4),
        fovy_rad in 0.05f32..2.8,
        parallel in any::<bool>(),
        near in 0.01f32..20.0,
        width in 1u32..2000,
        height in 1u32..2000,
        threshold in 0.001f32..=1.0,
    ) {
        let mut random = random(seed);
        let mut unit = || Vec3::new(random(), random(), random()) - 0.5;
        let offset = Vec3::from(offset);
        let positions: Vec<[f32; 3]> = (0..400).map(|_| (unit() * 40.0 + offset).to_array()).collect();
        let frame = ParticleFrame { positions, ..Default::default() };
        let options = ChunkOptions { chunk_particles: 5, ..ChunkOptions::new(100, 1.0) };
        let set = chunks::build(&frame, &options);
        let projection = if parallel {
            Projection::Orthographic { height_world: fovy_rad * 10.0 }
        } else {
            Projection::Perspective { fovy_rad }
        };
        let (eye, target) = (Vec3::from(eye) + offset, Vec3::from(target) + offset);
        let camera = Camera { eye, target, up: Vec3::new(0.1, 0.2, 1.0), projection, near };
        prop_assume!(camera.validate().is_ok());
        let size = [width, height];
        // All of the chunks in view are kept at 1, and the same chunks are in view below.
        let view = viewpoint(&camera, size, RADIUS);
        let full = select(&set, &view, &at(1.0)).unwrap();
        let thinned = select(&set, &view, &at(threshold)).unwrap();
        prop_assert_eq!(thinned.visible, full.visible);
        let mut drawn = vec![false; set.particles.len()];
        kept_slots(&set, &full).iter().for_each(|k| drawn[k.0] = true);

        // In f64 from the definition, not from the planes.
        let forward = (target.as_dvec3() - eye.as_dvec3()).normalize();
        let right = forward.cross(camera.up.as_dvec3()).normalize();
        let up = right.cross(forward);
        let half = camera.half_extent(size).as_dvec2();
        for (particle, drawn) in set.particles.iter().zip(drawn) {
            for _ in 0..8 {
                let surface = center(particle).as_dvec3() + (unit().normalize_or_zero() * RADIUS).as_dvec3();
                let v = surface - eye.as_dvec3();
                let distance = v.dot(forward);
                let scale = if parallel { 1.0 } else { distance };
                let shows = distance >= f64::from(near)
                    && v.dot(right).abs() <= half.x * scale
                    && v.dot(up).abs() <= half.y * scale;
                prop_assert!(drawn || !shows, "{:?} at distance {distance}", particle);
            }
        }
    }
}
