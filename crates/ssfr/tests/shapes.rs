//! Shapes of particles against closed forms and their CPU twin, and how they are drawn.

mod common;

use common::{Scene, gpu, is_fluid, parallel, params, perspective, shapes_on_gpu};
use glam::{DMat3, DQuat, DVec2, DVec3, Vec3};
use meniscus_cases::lattice;
use meniscus_core::{Aabb, Camera};
use meniscus_gpu::role::{KeptRange, Occludee, PackedParticle, Particles, Shapes};
use meniscus_gpu::{Buffer, Gpu, Page, RangeList, Recorder, Timing};
use meniscus_ssfr::twin::{self, HostSet, HostShape, ShapeRule};
use meniscus_ssfr::{Anisotropy, AnisotropyParams, Radii, ShapePage, ShapePasses, ShapeWork, SsfrParams};

const FORMS: [Anisotropy; 2] = [Anisotropy::YuTurk, Anisotropy::Zju];
/// Radius drawn of particles 1 apart.
const RADIUS: f32 = 0.625;

fn of_form(form: Anisotropy) -> AnisotropyParams {
    AnisotropyParams { form: Some(form), ..Default::default() }
}

fn rule(form: Anisotropy) -> ShapeRule {
    ShapeRule { params: of_form(form), spacing_world: 1.0, radius_world: RADIUS.into() }
}

fn packed(positions: &[[f32; 3]]) -> Vec<PackedParticle> {
    positions.iter().map(|&p| PackedParticle::new(p, 0)).collect()
}

/// The largest and the smallest half-axis, and the smallest one's direction.
fn half_axes(shape: &HostShape) -> (f64, f64, DVec3) {
    // Powers of the matrix and of its inverse; no Jacobi rotations here.
    let longest = |matrix: DMat3| {
        let mut v = DVec3::new(0.5, 0.6, 0.7);
        (0..200).for_each(|_| v = (matrix * v).normalize());
        ((matrix * v).length(), v)
    };
    let (inverse, direction) = longest(shape.axes.inverse());
    (longest(shape.axes).0, inverse.recip(), direction)
}

fn largest_difference(a: &HostShape, b: &HostShape) -> f64 {
    let axes = (a.axes - b.axes).to_cols_array().map(f64::abs).into_iter().fold(0.0, f64::max);
    axes.max((a.center_world - b.center_world).abs().max_element())
}

/// Piles of every kind: the bulk with its sides, edges and corners, jittered; a sheet; a thread; a drop; a pair; many in one place.
fn mixture() -> Vec<PackedParticle> {
    let mut positions = lattice::cuboid([0.0; 3], [9, 8, 7], 1.0, 0.6, 3).positions;
    positions.extend(lattice::cuboid([20.0, 0.0, 0.0], [12, 12, 1], 1.0, 0.3, 4).positions);
    positions.extend((0..20).map(|i| [40.0 + 0.8 * i as f32, 0.0, 0.0]));
    positions.extend(lattice::ball([0.0, 30.0, 0.0], 2.0, 1.0).positions);
    positions.extend([[0.0, -30.0, 0.0], [0.9, -30.0, 0.0], [60.0, 0.0, 0.0]]);
    positions.extend([[0.0, 0.0, 40.0]; 50]);
    let size = |i: usize| [1.0, 1.0, 1.0, 0.6, 1.4][i % 5];
    positions.iter().enumerate().map(|(i, &p)| PackedParticle::sized(p, i as u16, size(i))).collect()
}

#[test]
fn shapes_agree_with_their_twin() {
    let gpu = gpu();
    for form in FORMS {
        for support in [2.0, 3.0] {
            let params = AnisotropyParams { support, ..of_form(form) };
            let rule = ShapeRule { params, ..rule(form) };
            let scene =
                Scene { particles: mixture(), ..Scene::new(parallel(0.0, 1.0), [1, 1], &[], RADIUS, 1.0) };
            let found = shapes_on_gpu(&gpu, &scene, &params).read(&gpu).unwrap();
            let expected = twin::shapes(&scene.particles, &rule);
            for ((bits, particle), exact) in found.iter().zip(&scene.particles).zip(&expected) {
                let shape = HostShape::unpack(*bits, particle, &rule);
                // Axes are stored in steps of 1.2e-4, shifts in steps of 1e-3, of which half is off; sums in steps of 1e-6 of
                // neighbours of which there are a hundred, which variances of 0.04 and the ratio of axes magnify to about 1e-3.
                let difference = largest_difference(&shape, exact);
                assert!(difference < 3e-3, "{form:?} {support}: {difference} {shape:?} {exact:?}");
            }
            assert_eq!(
                found,
                shapes_on_gpu(&gpu, &scene, &params).read(&gpu).unwrap(),
                "the same bytes every time"
            );
        }
    }
}

/// Whatever the jitter of the rest, one inside a regular lattice sees all directions alike (`algorithms.md` 9.1).
#[test]
fn the_bulk_is_made_of_spheres_that_stay_in_place() {
    let body = lattice::cuboid([-4.5; 3], [9, 9, 9], 1.0, 0.0, 0).positions;
    let middle = body.iter().position(|p| Vec3::from(*p).length() < 1e-3).unwrap();
    let shape = twin::shapes(&packed(&body), &rule(Anisotropy::YuTurk))[middle];
    let sphere = HostShape { center_world: DVec3::ZERO, axes: DMat3::IDENTITY };
    assert!(largest_difference(&shape, &sphere) < 1e-6, "{shape:?}");
    // The other form is as large in all directions, too, but as large as its paper says: c sqrt(0.15) supports in a continuum, of which
    // a lattice is within a tenth.
    let (longest, shortest, _) = half_axes(&twin::shapes(&packed(&body), &rule(Anisotropy::Zju))[middle]);
    assert!(longest - shortest < 1e-6);
    let expected = 1.2 * 0.15f64.sqrt() * 2.5 / f64::from(RADIUS);
    assert!((longest / expected - 1.0).abs() < 0.1, "{longest} of {expected}");
}

/// Height over a square lattice's top layer, averaged over a cell, of the highest of the splats; between spheres, where all of them end,
/// that of the layer.
fn mean_height(shapes: &[HostShape], around: DVec3) -> f64 {
    let near: Vec<&HostShape> =
        shapes.iter().filter(|shape| shape.center_world.distance(around) < 4.0).collect();
    let steps = 20;
    let at = |i: usize| (i as f64 + 0.5) / steps as f64;
    let height = |x: f64, y: f64| {
        let top = |shape: &&HostShape| {
            // Points c + M u: for x and y given, the highest z, by the quadric's matrix.
            let axes = shape.axes * f64::from(RADIUS);
            let quadric = (axes * axes.transpose()).inverse();
            let (c, o) = (shape.center_world, DVec3::new(x, y, 0.0) - shape.center_world);
            let o = DVec3::new(o.x, o.y, 0.0);
            let (a, b, e) = (quadric.z_axis.z, quadric.z_axis.dot(o), o.dot(quadric * o) - 1.0);
            let root = b * b - a * e;
            (root >= 0.0).then(|| c.z + (root.sqrt() - b) / a)
        };
        near.iter().filter_map(top).fold(around.z, f64::max)
    };
    let cell = (0..steps * steps).map(|i| height(around.x + at(i % steps), around.y + at(i / steps)));
    cell.sum::<f64>() / (steps * steps) as f64
}

/// A flat surface is flat, and stays where the fluid ends.
#[test]
fn a_flat_surface_gets_flat_and_does_not_sink() {
    let body = lattice::cuboid([-7.5, -7.5, -8.0], [15, 15, 8], 1.0, 0.0, 0).positions;
    let top = body.iter().position(|p| Vec3::from(*p).distance(Vec3::new(0.0, 0.0, -0.5)) < 1e-3).unwrap();
    let shapes = twin::shapes(&packed(&body), &rule(Anisotropy::YuTurk));
    let (longest, shortest, direction) = half_axes(&shapes[top]);
    // Variances of a continuum that ends half a spacing above are as 2.2 to 1, of a surface through the particle as 3.2 to 1
    // (`algorithms.md` 9.1); blended with a sphere, where a lattice has fewer than 30 neighbours.
    assert!(direction.z.abs() > 0.9999, "{direction}");
    let ratio = longest / shortest;
    assert!((1.6..2.6).contains(&ratio), "{longest} {shortest}");
    // The fluid ends half a spacing above the centres of its top layer. Within a tenth of the radius of a particle: a mesh depends as much on
    // its parameters.
    let height = mean_height(&shapes, DVec3::new(0.0, 0.0, -0.5));
    assert!(height.abs() < 0.05, "{height}");
}

/// The corner of a block does not stick out of its faces.
#[test]
fn corners_are_no_knobs() {
    let body = lattice::cuboid([0.0; 3], [9, 9, 9], 1.0, 0.0, 0).positions;
    let shapes = twin::shapes(&packed(&body), &rule(Anisotropy::YuTurk));
    let corner = body.iter().position(|p| Vec3::from(*p).distance(Vec3::splat(0.5)) < 1e-3).unwrap();
    let reach = |shape: &HostShape| {
        let rows = [0, 1, 2].map(|i| shape.axes.row(i).length() * f64::from(RADIUS));
        [0, 1, 2].map(|i| shape.center_world[i] - rows[i])
    };
    // Half-way along an edge.
    let edge = body.iter().position(|p| Vec3::from(*p).distance(Vec3::new(0.5, 0.5, 4.5)) < 1e-3).unwrap();
    let (corner, edge) = (reach(&shapes[corner]), reach(&shapes[edge]));
    assert!(corner.iter().all(|&x| x > edge[0]), "{corner:?} {edge:?}");
}

#[test]
fn isolated_particles_are_their_own_spheres() {
    for form in FORMS {
        let few = [[0.0; 3], [0.9, 0.0, 0.0], [0.0, 1.2, 0.0], [50.0, 0.0, 0.0]];
        for (shape, position) in twin::shapes(&packed(&few), &rule(form)).iter().zip(few) {
            let sphere = HostShape { center_world: Vec3::from(position).as_dvec3(), axes: DMat3::IDENTITY };
            assert!(largest_difference(shape, &sphere) < 1e-12, "{form:?}");
        }
    }
}

/// Nothing pops: neighbours that come nearer by a little change the shape by a little, also where they enter the support, and where they
/// are as many as make an ellipsoid.
#[test]
fn shapes_change_no_faster_than_their_neighbours_move() {
    let sheet = lattice::sheet([-3.6, -3.6], 0.0, [6, 6], 1.2).positions;
    let middle = sheet.iter().position(|p| Vec3::from(*p).distance(Vec3::new(0.6, 0.6, 0.0)) < 0.1).unwrap();
    let patch = lattice::sheet([-1.5, -1.5], 0.0, [3, 3], 1.0).positions;
    let step = 0.01;
    for form in FORMS {
        let shape = |i: usize| {
            let mut moved = sheet.clone();
            // Down on it from outside of the support, and through it.
            moved.extend(patch.iter().map(|p| [p[0], p[1], 3.0 - step * i as f32]));
            twin::shapes(&packed(&moved), &rule(form))[middle]
        };
        let mut before = shape(0);
        let (first, mut most) = (before, 0.0f64);
        for i in 1..450 {
            let next = shape(i);
            most = most.max(largest_difference(&before, &next));
            before = next;
        }
        // Nine neighbours, each of whose weights changes by at most 3 / 2.5 per spacing, count for up to 0.2 of the 22 that lie between
        // spheres and ellipsoids of 2.5 radii, and for as much of their moments.
        assert!(most < 0.04, "{form:?} {most}");
        let last = shape(300);
        assert!(largest_difference(&first, &last) > 0.1, "it must matter");
    }
}

#[test]
fn turned_particles_have_turned_shapes() {
    let body = lattice::cuboid([-3.0; 3], [6, 6, 4], 1.0, 0.8, 7).positions;
    let turn = DQuat::from_axis_angle(DVec3::new(0.6, -0.3, 0.7).normalize(), 1.1);
    let turned: Vec<[f32; 3]> =
        body.iter().map(|&p| (turn * Vec3::from(p).as_dvec3()).as_vec3().to_array()).collect();
    let turn = DMat3::from_quat(turn);
    for form in FORMS {
        let shapes = twin::shapes(&packed(&body), &rule(form));
        for (shape, found) in shapes.iter().zip(twin::shapes(&packed(&turned), &rule(form))) {
            let expected = HostShape {
                center_world: turn * shape.center_world,
                axes: turn * shape.axes * turn.transpose(),
            };
            // Positions are rounded to 2e-7, which the shape does not magnify by more than a hundred.
            assert!(largest_difference(&found, &expected) < 2e-5, "{form:?}");
        }
    }
}

/// Of what has no volume, no ratio of axes is more than allowed, and nothing is NaN.
#[test]
fn degenerate_neighbourhoods_have_shapes() {
    let plane = lattice::sheet([-5.0, -5.0], 0.0, [20, 20], 0.5).positions;
    let line: Vec<[f32; 3]> = (0..60).map(|i| [0.08 * i as f32, 0.0, 0.0]).collect();
    let point = vec![[3.0f32, 4.0, 5.0]; 500];
    for (name, positions) in [("plane", plane), ("line", line), ("point", point)] {
        for form in FORMS {
            for shape in twin::shapes(&packed(&positions), &rule(form)) {
                let (longest, shortest, _) = half_axes(&shape);
                assert!(shape.center_world.is_finite() && longest.is_finite(), "{name} {form:?}");
                // Ratio 4 of variances.
                assert!(
                    longest / shortest < 4.0 + 1e-6 && longest < 2.6,
                    "{name} {form:?} {longest} {shortest}"
                );
            }
        }
    }
    let shape = twin::shapes(&packed(&vec![[3.0, 4.0, 5.0]; 500]), &rule(Anisotropy::YuTurk))[7];
    assert!(
        largest_difference(
            &shape,
            &HostShape { center_world: DVec3::new(3.0, 4.0, 5.0), axes: DMat3::IDENTITY }
        ) < 1e-9
    );
}

/// The nearest hit of the ray with the ellipsoid by the quadric's equation, from the closest approach of the ray outwards by bisection:
/// no formula that the splat is made by.
fn nearest_hit((origin, step): (DVec3, DVec3), center: DVec3, axes: DMat3) -> Option<f64> {
    // No half-axis is as long as three radii.
    if (center - origin).reject_from(step).length() > 3.0 * f64::from(RADIUS * 0.2) {
        return None;
    }
    let quadric = (axes * axes.transpose()).inverse();
    let level = |d: f64| {
        let p = origin + d * step - center;
        p.dot(quadric * p) - 1.0
    };
    let (mut low, mut high) = (0.0, 20.0);
    for _ in 0..200 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if level(a) < level(b) { high = b } else { low = a }
    }
    let (mut outside, mut inside) = (0.0, low);
    if level(inside) > 0.0 {
        return None;
    }
    for _ in 0..100 {
        let middle = 0.5 * (outside + inside);
        if level(middle) > 0.0 { outside = middle } else { inside = middle }
    }
    Some(inside)
}

/// A scene in which every particle has the shape that its neighbours give it, and those shapes as drawn.
fn shaped_scene(
    gpu: &Gpu,
    camera: Camera,
    size: [u32; 2],
    positions: &[[f32; 3]],
    form: Anisotropy,
) -> (Scene, Vec<HostShape>) {
    let mut scene = Scene::new(camera, size, positions, RADIUS * 0.2, 0.2);
    scene.shapes = Some(of_form(form));
    for range in &mut scene.ranges {
        range.shape = 1 + range.first;
    }
    let rule = ShapeRule { params: of_form(form), spacing_world: 0.2, radius_world: (RADIUS * 0.2).into() };
    let bits = shapes_on_gpu(gpu, &scene, &of_form(form)).read(gpu).unwrap();
    let shapes = bits.iter().zip(&scene.particles).map(|(b, p)| HostShape::unpack(*b, p, &rule)).collect();
    (scene, shapes)
}

fn shaped_params(filter: &str, form: Anisotropy) -> SsfrParams {
    SsfrParams { anisotropy: of_form(form), ..params(filter, 1, 0.0) }
}

/// `algorithms.md` 14.1 for ellipsoids: one patch of fluid far off the axis.
#[test]
fn ellipsoids_have_the_distance_and_outline_of_the_quadric() {
    let gpu = gpu();
    let positions = lattice::cuboid([1.6, -1.6, -3.2], [5, 5, 1], 0.2, 0.5, 1).positions;
    for camera in [perspective(0.0, 1.6), parallel(0.0, 5.0)] {
        for form in FORMS {
            let (scene, shapes) = shaped_scene(&gpu, camera, [320, 240], &positions, form);
            let longest = shapes.iter().map(|s| half_axes(s).0 / half_axes(s).1).fold(0.0, f64::max);
            assert!(longest > 1.3, "{longest}");
            let frame = scene.render(&gpu, &shaped_params("none", form));
            let view = scene.view();
            let (mut drawn, mut wrong) = (0, 0);
            for (i, &found) in frame.unfiltered.iter().enumerate() {
                let ray = view.ray(DVec2::new((i % 320) as f64 + 0.5, (i / 320) as f64 + 0.5));
                // The camera looks along -z from the origin: world is view.
                let hits = shapes
                    .iter()
                    .filter_map(|s| nearest_hit(ray, s.center_world, s.axes * f64::from(RADIUS * 0.2)));
                let exact = hits.fold(f64::INFINITY, f64::min);
                drawn += u32::from(exact.is_finite());
                // 1e-5 of the distance, as of spheres; at the very edge rounding decides.
                let agrees = if exact.is_finite() {
                    (f64::from(found) - exact).abs() < 1e-5 * exact
                } else {
                    !is_fluid(found)
                };
                wrong += u32::from(!agrees);
            }
            assert!(drawn > 1000 && wrong * 200 < drawn, "{form:?} {camera:?}: {wrong} of {drawn}");
        }
    }
}

#[test]
fn depth_and_radius_of_ellipsoids_agree_with_their_twin() {
    let gpu = gpu();
    let positions = lattice::cuboid([-1.4, -1.0, -5.0], [14, 10, 6], 0.2, 0.5, 2).positions;
    // Near, and so far that splats are points.
    for camera in [perspective(0.5, 0.6), parallel(0.5, 3.0), perspective(90.0, 0.6)] {
        let (mut scene, shapes) = shaped_scene(&gpu, camera, [160, 120], &positions, Anisotropy::YuTurk);
        let half = scene.ranges[0].count / 2;
        let rest =
            KeptRange { first: half, count: scene.ranges[0].count - half, shape: 0, ..scene.ranges[0] };
        scene.ranges[0].count = half;
        // The second half are spheres, all fade and grow.
        scene.ranges.push(rest);
        scene.radii = Radii::Different;
        scene.ranges.iter_mut().for_each(|range| range.keep = 30_000);
        for particle in &mut scene.particles {
            *particle = PackedParticle::new(particle.position_world, particle.hash() % 30_000);
        }
        let frame = scene.render(&gpu, &shaped_params("none", Anisotropy::YuTurk));
        let set = HostSet { shapes: &shapes, ..scene.host_set() };
        let expected = twin::depth(&scene.view(), &[set], &scene.scene_distance);
        let differs = |i: &usize| {
            let (found, exact) = (frame.unfiltered[*i], expected.distance[*i]);
            is_fluid(found) != is_fluid(exact)
                || (found - exact).abs() > 1e-3 * scene.radius
                || (frame.radius[*i] - expected.radius[*i]).abs() > 1e-5 * scene.radius
        };
        // Few pixels, in which rounding decides between two splats.
        let count = (0..frame.unfiltered.len()).filter(differs).count();
        assert!(count * 500 <= frame.unfiltered.len(), "{count} pixels differ, {camera:?}");
        assert!(expected.distance.iter().any(|&d| is_fluid(d)));
    }
}

/// Without neighbours, an ellipsoid is the sphere, pixel by pixel.
#[test]
fn ellipsoids_of_equal_axes_are_spheres() {
    let gpu = gpu();
    let positions: Vec<[f32; 3]> = (0..40)
        .map(|i| [0.6 * (i % 8) as f32 - 2.1, 0.6 * (i / 8) as f32 - 1.2, -3.0 - 0.7 * (i % 5) as f32])
        .collect();
    for camera in [perspective(0.0, 1.2), parallel(0.0, 4.0)] {
        let (scene, shapes) = shaped_scene(&gpu, camera, [200, 150], &positions, Anisotropy::YuTurk);
        assert!(
            shapes
                .iter()
                .all(|shape| (shape.axes - DMat3::IDENTITY).to_cols_array().iter().all(|c| c.abs() < 1e-4))
        );
        let ellipsoids = scene.render(&gpu, &shaped_params("none", Anisotropy::YuTurk));
        let spheres = scene.render(&gpu, &params("none", 1, 0.0));
        // 1 is stored as 8192 of 32767 steps of 4: off by 3e-5. A pixel's ray that passes within as little is one's or the other's.
        let differs =
            |(a, b): &(&f32, &f32)| is_fluid(**a) != is_fluid(**b) || (*a - *b).abs() > 1e-3 * scene.radius;
        let count = ellipsoids.unfiltered.iter().zip(&spheres.unfiltered).filter(differs).count();
        assert!(count <= 40, "{count} pixels");
        assert!(spheres.unfiltered.iter().filter(|d| is_fluid(**d)).count() > 1000);
    }
}

/// A sheet one particle thick, whose particles are 1.05 spacings apart: spheres leave holes, ellipsoids do not.
#[test]
fn thin_sheets_stay_closed() {
    let gpu = gpu();
    let positions = lattice::sheet([-2.1, -2.1], -3.0, [20, 20], 0.21).positions;
    let camera = parallel(0.0, 3.0);
    let (scene, _) = shaped_scene(&gpu, camera, [150, 150], &positions, Anisotropy::YuTurk);
    let holes = |params| scene.render(&gpu, &params).unfiltered.iter().filter(|d| !is_fluid(**d)).count();
    assert!(holes(params("none", 1, 0.0)) > 500);
    assert_eq!(holes(shaped_params("none", Anisotropy::YuTurk)), 0);
}

/// Cut into pages, and into batches of which each sees only what is near, the particles have the same shapes to the bit.
#[test]
fn pages_and_batches_change_no_shape() {
    let gpu = gpu();
    let params = of_form(Anisotropy::YuTurk);
    let positions = lattice::cuboid([0.0; 3], [12, 8, 6], 1.0, 0.6, 3).positions;
    let scene = Scene::new(parallel(0.0, 1.0), [1, 1], &positions, RADIUS, 1.0);
    let whole = shapes_on_gpu(&gpu, &scene, &params).read(&gpu).unwrap();

    let cut = 250;
    let halves = [&scene.particles[..cut], &scene.particles[cut..]];
    let particles = halves.map(|half| Page::<Particles>::from_slice(&gpu, half).unwrap());
    let shapes = halves.map(|half| Buffer::<Shapes>::from_slice(&gpu, &vec![[0; 4]; half.len()]).unwrap());
    let pages = [0, 1].map(|i| ShapePage { particles: &particles[i], shapes: &shapes[i] });
    let all = |half: &[PackedParticle]| KeptRange {
        first: 0,
        count: half.len() as u32,
        keep: KeptRange::KEEP_ALL,
        shape: 1,
    };
    let list = |ranges: &[KeptRange]| RangeList::from_slice(&gpu, ranges).unwrap();
    let sources = halves.map(|half| list(&[all(half)]));
    let mut recorder = Recorder::new(&gpu, Timing::Stamps);
    let mut passes = ShapePasses::new(&gpu).unwrap();
    // Three batches: of the first page, and of the second in two pieces.
    let second = halves[1].len() as u32;
    let piece = |first: u32, count: u32| KeptRange { first, count, shape: 1 + first, ..all(halves[1]) };
    let targets = [
        [list(&[all(halves[0])]), list(&[])],
        [list(&[]), list(&[piece(0, 100)])],
        [list(&[]), list(&[piece(100, second - 100)])],
    ];
    for targets in &targets {
        let work = ShapeWork {
            // Not all of it: what lies outside of the grid is found all the same.
            bounds: Aabb { min: Vec3::new(2.0, 1.0, 0.0), max: Vec3::new(9.0, 3.0, 4.0) },
            targets,
            sources: &sources,
            source_particles: positions.len(),
        };
        passes.record(&mut recorder, &gpu, &pages, &work, &params, (RADIUS, 1.0)).unwrap();
    }
    let _ = recorder.submit(&gpu).unwrap();
    gpu.wait().unwrap();
    let found = shapes.map(|shapes| shapes.read(&gpu).unwrap()).concat();
    assert_eq!(found, whole);
}

/// What is left out because it cannot be seen counts on it.
#[test]
fn no_shape_reaches_farther_than_announced() {
    let particles = mixture();
    for form in FORMS {
        for ratio in [1.0, 4.0, 8.0] {
            let params = AnisotropyParams { ratio, ..of_form(form) };
            let shapes = twin::shapes(&particles, &ShapeRule { params, ..rule(form) });
            let reach = f64::from(params.reach_radii(1.0 / RADIUS));
            for (shape, particle) in shapes.iter().zip(&particles) {
                let shift = shape.center_world.distance(Vec3::from(particle.position_world).as_dvec3());
                assert!(
                    half_axes(shape).0 + shift / f64::from(RADIUS) <= reach,
                    "{form:?} {ratio} {shape:?}"
                );
            }
        }
    }
    assert_eq!(of_form(Anisotropy::None).reach_radii(1.6), 1.0);
}

/// A thread that points at the eye, whose particles reach out of what the scene hides, but their spheres do not.
#[test]
fn what_only_an_ellipsoid_shows_is_not_taken_for_hidden() {
    let gpu = gpu();
    let positions: Vec<[f32; 3]> = (0..40).map(|i| [0.0, 0.0, -4.0 - 0.04 * i as f32]).collect();
    for camera in [perspective(0.0, 0.2), parallel(0.0, 0.8)] {
        let (mut scene, shapes) = shaped_scene(&gpu, camera, [64, 48], &positions, Anisotropy::YuTurk);
        let radius = f64::from(scene.radius);
        let front = |reach: &dyn Fn(&HostShape) -> f64| {
            shapes.iter().map(|s| -s.center_world.z - radius * reach(s)).fold(f64::INFINITY, f64::min)
        };
        let (of_spheres, of_ellipsoids) = (front(&|_| 1.0), front(&|s| s.axes.z_axis.length()));
        assert!(of_spheres - of_ellipsoids > 0.1 * radius, "{of_spheres} {of_ellipsoids}");
        scene.scene_distance.fill((0.5 * (of_spheres + of_ellipsoids)) as f32);
        let range = scene.ranges[0];
        let tested = Occludee { range, front: 0.0, first_tile: 0, last_tile: 7 | 5 << 16, pad: 0 };
        let in_two_waves = Scene { ranges: Vec::new(), occludees: vec![tested], ..scene.clone() };
        let params = shaped_params("none", Anisotropy::YuTurk);
        let [expected, found] = [&scene, &in_two_waves].map(|scene| scene.render(&gpu, &params).unfiltered);
        assert!(expected.iter().any(|d| is_fluid(*d)));
        assert_eq!(found, expected, "{camera:?}");
    }
}

/// As of spheres: those that are tested against what is drawn already show where they bulge out of it.
#[test]
fn tested_ellipsoids_show_as_if_drawn_at_once() {
    let gpu = gpu();
    let positions = lattice::cuboid([-1.4, -1.0, -4.0], [14, 10, 3], 0.2, 0.9, 2).positions;
    for camera in [perspective(0.0, 0.5), parallel(0.0, 1.8)] {
        let (at_once, _) = shaped_scene(&gpu, camera, [160, 120], &positions, Anisotropy::YuTurk);
        let all = at_once.ranges[0];
        let count = all.count / 2;
        let rest = KeptRange { first: count, count: all.count - count, shape: all.shape + count, ..all };
        let tested = Occludee { range: rest, front: 0.0, first_tile: 0, last_tile: 19 | 14 << 16, pad: 0 };
        let first = Scene { ranges: vec![KeptRange { count, ..all }], ..at_once.clone() };
        let in_two_waves = Scene { occludees: vec![tested], ..first.clone() };
        let params = shaped_params("none", Anisotropy::YuTurk);
        let [expected, half, found] =
            [&at_once, &first, &in_two_waves].map(|scene| scene.render(&gpu, &params).unfiltered);
        assert_ne!(half, expected, "the others must show");
        assert_eq!(found, expected, "{camera:?}");
    }
}
