//! Which particles are foam, against cases whose answer is known.

#[allow(dead_code, reason = "shared with the other tests")]
mod common;

use common::{chunked, random};
use glam::Vec3;
use meniscus_core::{Aabb, Attribute, ParticleFrame, UpAxis};
use meniscus_gpu::role::FoamDrop;
use meniscus_lod::foam::{DROPS, foaminess, prefix, widening};
use meniscus_lod::{ChunkOptions, FoamOptions, Foaminess, LodParams, chunks, select};

const SPEED: f32 = 8.0;
/// Around [`pool`].
const WALLS: Aabb = Aabb { min: Vec3::ZERO, max: Vec3::new(30.0, 30.0, 40.0) };

fn options() -> FoamOptions {
    FoamOptions {
        velocity: Some("v".into()),
        speed: SPEED,
        closing: FoamOptions::CLOSING,
        up: UpAxis::Z,
        walls: WALLS,
    }
}

fn with_velocities(positions: Vec<Vec3>, velocity: impl Fn(Vec3) -> Vec3) -> ParticleFrame {
    let values = positions.iter().flat_map(|&p| velocity(p).to_array()).collect();
    ParticleFrame {
        positions: positions.into_iter().map(Into::into).collect(),
        attributes: vec![Attribute { name: "v".into(), components: 3, values }],
        ..Default::default()
    }
}

/// Jittered points of a lattice of spacing 1 in [low, high), up to a tenth off.
fn block(low: Vec3, high: Vec3) -> Vec<Vec3> {
    let mut random = random(5);
    let size = (high - low).as_uvec3();
    (0..size.x * size.y * size.z)
        .map(|i| {
            let at = [i % size.x, i / size.x % size.y, i / size.x / size.y];
            low + Vec3::from(at.map(|c| c as f32 + 0.2 * (random() - 0.5)))
        })
        .collect()
}

fn pool() -> Vec<Vec3> {
    block(Vec3::ZERO, Vec3::new(30.0, 30.0, 16.0))
}

/// A pool, and a jet of 8 x 8 that falls into its middle at `SPEED`.
fn jet() -> ParticleFrame {
    let mut positions = pool();
    positions.extend(block(Vec3::new(11.0, 11.0, 16.0), Vec3::new(19.0, 19.0, 34.0)));
    with_velocities(positions, |p| if p.z > 15.5 { -SPEED * Vec3::Z } else { Vec3::ZERO })
}

fn amount(found: &[Foaminess]) -> f32 {
    found.iter().map(|foam| foam.total()).sum()
}

#[test]
fn a_particle_on_its_own_is_spray_and_calm_water_is_not() {
    let mut positions = pool();
    let bulk = positions.len();
    positions.extend([Vec3::new(5.0, 5.0, 30.0), Vec3::new(20.0, 20.0, 25.0), Vec3::new(20.7, 20.0, 25.0)]);
    // Moving along with the water, all of it, or not read at all.
    for velocity in [Vec3::ZERO, Vec3::new(3.0, -40.0, 7.0)] {
        let frame = with_velocities(positions.clone(), |_| velocity);
        for options in [options(), FoamOptions { velocity: None, ..options() }] {
            let found = foaminess(&frame, 1.0, &options);
            assert!(found[..bulk].iter().all(|foam| foam.total() == 0.0), "edges and corners, too");
            assert!(found[bulk..].iter().all(|foam| foam.spray == 1.0 && foam.trapped == 0.0));
        }
    }
}

#[test]
fn a_jet_traps_air_where_it_hits_and_nowhere_else() {
    let frame = jet();
    let found = foaminess(&frame, 1.0, &options());
    let mut all = 0.0;
    for (position, foam) in frame.positions.iter().zip(&found) {
        let position = Vec3::from(*position);
        if foam.trapped > 0.0 {
            // Neighbours within two spacings of the plane between jet and pool, and of its edge.
            assert!((position.z - 15.5).abs() < 2.5, "{position}");
            assert!(
                position.x > 8.5 && position.x < 20.5 && position.y > 8.5 && position.y < 20.5,
                "{position}"
            );
            all += foam.trapped;
        }
    }
    // 28 of the 64 of each layer are at the rim; half of one layer's is less than what is half way into foam of both.
    assert!(all > 14.0, "{all}");
    // What falls apart traps nothing that it would not also by friction: less than when it closes in.
    let apart = with_velocities(frame.positions.iter().map(|p| Vec3::from(*p)).collect(), |p| {
        if p.z > 15.5 { SPEED * Vec3::Z } else { Vec3::ZERO }
    });
    assert!(amount(&foaminess(&apart, 1.0, &options())) < 0.5 * all);
}

#[test]
fn a_smooth_flow_and_walls_are_free_of_foam() {
    // From rest at the floor to `SPEED` at the top, over 16 spacings.
    let shear = with_velocities(pool(), |p| SPEED * p.z / 16.0 * Vec3::X);
    assert_eq!(amount(&foaminess(&shear, 1.0, &options())), 0.0);
    // Halves of a pool that rub against each other below the surface, up to its sides.
    let rubbing = with_velocities(pool(), |p| if p.z < 7.5 { SPEED * Vec3::X } else { Vec3::ZERO });
    assert_eq!(amount(&foaminess(&rubbing, 1.0, &options())), 0.0);
}

#[test]
fn a_constant_velocity_and_scales_change_nothing() {
    let frame = jet();
    let found = foaminess(&frame, 1.0, &options());
    // Powers of two, and sums of them that floats hold: no rounding.
    let velocity = &frame.attributes[0].values;
    let moved: Vec<f32> =
        velocity.chunks_exact(3).flat_map(|v| [v[0] + 64.0, v[1] - 32.0, v[2] + 16.0]).collect();
    let attribute = |values| vec![Attribute { name: "v".into(), components: 3, values }];
    let moving = ParticleFrame { attributes: attribute(moved), ..frame.clone() };
    assert_eq!(foaminess(&moving, 1.0, &options()), found);
    // Another unit of length and another of time.
    let scaled = ParticleFrame {
        positions: frame.positions.iter().map(|p| p.map(|c| c / 256.0)).collect(),
        attributes: attribute(velocity.iter().map(|v| v * 4.0).collect()),
        ..Default::default()
    };
    let walls = Aabb { min: WALLS.min, max: WALLS.max / 256.0 };
    let faster = FoamOptions { speed: 4.0 * SPEED, walls, ..options() };
    assert_eq!(foaminess(&scaled, 1.0 / 256.0, &faster), found);
    // Elsewhere the cells lie differently, which only decides how far from air it is looked for.
    let by = Vec3::new(1.25, -0.75, 1.5);
    let walls = Aabb { min: WALLS.min + by, max: WALLS.max + by };
    let shifted = ParticleFrame {
        positions: frame.positions.iter().map(|p| (Vec3::from(*p) + by).to_array()).collect(),
        ..frame.clone()
    };
    let shifted = foaminess(&shifted, 1.0, &FoamOptions { walls, ..options() });
    // A layer in the midst of the jet may be a cell farther from air.
    let ratio = amount(&shifted) / amount(&found);
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
}

#[test]
fn velocities_that_are_no_numbers_do_not_spread() {
    let mut frame = jet();
    let sound = foaminess(&frame, 1.0, &options());
    // One in the middle of the surface, one in the jet.
    let spoilt: Vec<usize> = [Vec3::new(3.0, 3.0, 15.0), Vec3::new(15.0, 15.0, 30.0)]
        .map(|at| {
            let distance = |i: &usize| Vec3::from(frame.positions[*i]).distance(at);
            (0..frame.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
        })
        .to_vec();
    for (&particle, value) in spoilt.iter().zip([f32::NAN, f32::INFINITY]) {
        frame.attributes[0].values[3 * particle] = value;
    }
    let found = foaminess(&frame, 1.0, &options());
    assert!(found.iter().all(|foam| foam.total().is_finite()));
    // Neither is where the jet hits: nothing changes at all.
    assert_eq!(found, sound);
    // Nothing but such, or attributes that do not fit: the company of a particle is left.
    for attributes in [
        vec![Attribute { name: "v".into(), components: 3, values: vec![f32::NAN; 3 * frame.len()] }],
        vec![Attribute { name: "v".into(), components: 2, values: vec![1.0; 2 * frame.len()] }],
        Vec::new(),
    ] {
        let frame = ParticleFrame { attributes, ..frame.clone() };
        assert!(foaminess(&frame, 1.0, &options()).iter().all(|foam| foam.trapped == 0.0));
    }
}

#[test]
fn absurd_input_is_survived() {
    let crowd = with_velocities(vec![Vec3::ONE; 100_000], |_| Vec3::X);
    assert_eq!(amount(&foaminess(&crowd, 1.0, &options())), 0.0);
    assert!(foaminess(&ParticleFrame::default(), 1.0, &options()).is_empty());
    for spacing in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-30, 1e30] {
        assert_eq!(foaminess(&jet(), spacing, &options()).len(), jet().len());
    }
    for speed in [0.0, f32::NAN, f32::INFINITY] {
        let found = foaminess(&jet(), 1.0, &FoamOptions { speed, ..options() });
        assert!(found.iter().all(|foam| foam.trapped == 0.0));
    }
    let far = with_velocities(vec![Vec3::ZERO, Vec3::splat(1e30), Vec3::splat(-1e30)], |_| Vec3::X);
    assert!(foaminess(&far, 1.0, &options()).iter().all(|foam| foam.spray == 1.0));
}

fn drops(frame: &ParticleFrame) -> Vec<FoamDrop> {
    chunks::build_with_foam(frame, &ChunkOptions::new(1 << 20, 1.0), Some(&options())).foam.unwrap()
}

#[test]
fn drops_are_the_same_for_any_number_of_threads_and_stay_with_their_particle() {
    let mut frame = jet();
    frame.ids = (0..frame.len() as u64).map(|i| 1000 + i).collect();
    let with_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| drops(&frame))
    };
    let found = with_threads(1);
    assert!(found.len() > 500 && found.len().is_multiple_of(DROPS));
    assert_eq!(with_threads(3), found);
    // In another order of the file.
    let reversed = ParticleFrame {
        positions: frame.positions.iter().rev().copied().collect(),
        ids: frame.ids.iter().rev().copied().collect(),
        attributes: vec![Attribute {
            values: frame.attributes[0].values.rchunks_exact(3).flatten().copied().collect(),
            ..frame.attributes[0].clone()
        }],
        ..Default::default()
    };
    let sorted = |mut drops: Vec<FoamDrop>| {
        drops.sort_by_key(|drop| (drop.center_world.map(f32::to_bits), drop.packed));
        drops
    };
    // Sums over neighbours come in another order: a last bit of an optical depth in half precision may differ.
    for (a, b) in sorted(found).iter().zip(&sorted(drops(&reversed))) {
        assert_eq!(a.center_world, b.center_world);
        assert!((a.optical_depth() - b.optical_depth()).abs() <= 2e-3, "{a:?} {b:?}");
    }
}

/// What a drop takes of light, relative to others: its optical depth over its area.
fn taken(drops: &[FoamDrop], widening: f32) -> f64 {
    let of = |drop: &FoamDrop| drop.optical_depth() * (widening * drop.radius_spacings()).powi(2);
    drops.iter().map(|drop| f64::from(of(drop))).sum()
}

#[test]
fn less_detail_is_as_much_foam() {
    let drops = drops(&jet());
    let all = taken(&drops, 1.0);
    assert_eq!((prefix(drops.len(), 1.0), widening(1.0)), (drops.len(), 1.0));
    for share in [0.0, 0.01, 0.1, 0.3, 0.5, 0.9] {
        let prefix = prefix(drops.len(), share);
        assert!(prefix > 0 && (prefix as f32) < (share + 1.0 / DROPS as f32) * drops.len() as f32 + 1.0);
        let ratio = taken(&drops[..prefix], widening(share)) / all;
        // Areas of drops vary with a relative standard deviation of 0.45; of some 150 foamy particles one drop each is left.
        assert!((ratio - 1.0).abs() < 0.15, "{share}: {ratio}");
    }
}

#[test]
fn spray_that_is_foam_is_no_sphere_as_well() {
    let mut positions = pool();
    positions.push(Vec3::new(5.0, 5.0, 30.0));
    let frame = with_velocities(positions, |_| Vec3::ZERO);
    let foamy = chunks::build_with_foam(&frame, &ChunkOptions::new(1 << 20, 1.0), Some(&options()));
    let plain = chunked(&frame);
    let [camera, _] = common::cameras(Vec3::new(15.0, -60.0, 40.0), Vec3::new(15.0, 15.0, 8.0));
    let viewpoint = common::viewpoint(&camera, [640, 360], 0.625);
    let kept = |set| select(set, &viewpoint, &LodParams::default()).unwrap().counts.kept;
    assert_eq!(kept(&plain), frame.len() as u64);
    assert_eq!(kept(&foamy), frame.len() as u64 - 1);
    assert_eq!(foamy.foam.as_ref().unwrap().len(), DROPS);
    assert_eq!(plain.foam, None);
    assert_eq!(foamy.bytes() - plain.bytes(), (DROPS * size_of::<FoamDrop>()) as u64);
}
