//! What every generated case promises: numbers, bytes, identity, even spacing.

use std::collections::HashMap;

use meniscus_cases::{Case, CaseError, CaseFrame, CaseOptions, CaseSource};
use meniscus_core::{Cancel, FrameErrorKind, FrameRequest, FrameSource};

fn options(particles: u64, frames: usize) -> CaseOptions {
    CaseOptions { particles, frames, seed: 7 }
}

#[test]
fn the_particle_number_is_exact() {
    for case in Case::ALL {
        for particles in [1, 2, 3, 10, 999, 20_011] {
            let frame = case.frame(&options(particles, 3), 1);
            assert_eq!(frame.positions.len() as u64, particles, "{case}");
            assert_eq!(frame.velocities.len() as u64, particles);
            assert_eq!(frame.density.len() as u64, particles);
            assert_eq!(frame.pressure.len() as u64, particles);
            assert!(frame.ids.iter().copied().eq(0..particles as i64));
            assert!(frame.positions.as_flattened().iter().all(|c| c.is_finite()), "{case} {particles}");
        }
    }
}

#[test]
fn the_bytes_do_not_depend_on_threads_and_do_depend_on_the_seed() {
    for case in Case::ALL {
        // More than one parallel task.
        let options = options(100_000, 4);
        let with_threads = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("thread pool");
            pool.install(|| case.frame(&options, 2))
        };
        let frame = with_threads(1);
        assert_eq!(frame, with_threads(3), "{case}");
        assert_ne!(frame.positions, case.frame(&CaseOptions { seed: 8, ..options }, 2).positions);
    }
}

#[test]
fn every_particle_moves_with_its_velocity() {
    for case in Case::ALL {
        // Frames so near to each other that the acceleration between them hardly counts.
        let options = options(5_000, 2001);
        for index in [300, 900, 1500] {
            let (before, frame, after) = (
                case.frame(&options, index - 1),
                case.frame(&options, index),
                case.frame(&options, index + 1),
            );
            let two_steps = after.time - before.time;
            let mut astray = 0;
            for i in 0..frame.positions.len() {
                let error: f64 = (0..3)
                    .map(|k| {
                        (after.positions[i][k] - before.positions[i][k]) / two_steps
                            - f64::from(frame.velocities[i][k])
                    })
                    .map(|difference| difference * difference)
                    .sum::<f64>()
                    .sqrt();
                // Largest speed a particle of the case has, times the relative length of the step.
                astray += usize::from(error > 0.02 * spread(&frame).max(0.1));
            }
            // A droplet that is launched or lands in these two steps changes its velocity at once.
            assert!(astray <= 10, "{case} {index}: {astray} particles");
        }
    }
}

/// Largest speed, m/s.
fn spread(frame: &CaseFrame) -> f64 {
    frame
        .velocities
        .iter()
        .map(|v| f64::from(v.iter().map(|c| c * c).sum::<f32>().sqrt()))
        .fold(0.0, f64::max)
}

#[test]
fn the_spacing_is_even_inside() {
    for case in Case::ALL {
        let options = options(200_000, 5);
        for index in 0..options.frames {
            let frame = case.frame(&options, index);
            let grid = Grid::new(&frame);
            let (mut inside, mut sum, mut close) = (0, 0.0, 0);
            for i in (0..frame.positions.len()).step_by(97) {
                let near = grid.within(&frame, i, 3.0);
                close += usize::from(near.nearest < 0.5);
                // Neighbours in all octants: away from surface, walls and bed.
                if near.octants.iter().all(|&count| count >= 9) {
                    inside += 1;
                    sum += f64::from(near.octants.iter().sum::<u32>() + 1);
                }
            }
            let samples = frame.positions.len().div_ceil(97);
            assert!(inside * 5 > samples, "{case} {index}: only {inside} of {samples} inside");
            // A ball of three spacings holds 36 pi particles; near a border it passes as inside with up to a tenth less.
            let ratio = sum / inside as f64 / (36.0 * std::f64::consts::PI);
            assert!((ratio - 1.0).abs() < 0.05, "{case} {index}: {ratio}");
            // Layers are moved against each other without regard to single particles, and jitter adds its part.
            assert!(close * 20 < samples, "{case} {index}: {close} of {samples} nearer than half a spacing");
        }
    }
}

struct Grid(HashMap<[i64; 3], Vec<usize>>);

struct Near {
    octants: [u32; 8],
    /// Spacings.
    nearest: f64,
}

impl Grid {
    fn new(frame: &CaseFrame) -> Self {
        let mut cells: HashMap<_, Vec<usize>> = HashMap::new();
        for (i, p) in frame.positions.iter().enumerate() {
            cells.entry(p.map(|c| (c / (3.0 * frame.spacing)).floor() as i64)).or_default().push(i);
        }
        Self(cells)
    }

    /// Particles no further than `reach <= 3` spacings from particle `i`.
    fn within(&self, frame: &CaseFrame, i: usize, reach: f64) -> Near {
        let p = frame.positions[i];
        let cell = p.map(|c| (c / (3.0 * frame.spacing)).floor() as i64);
        let mut near = Near { octants: [0; 8], nearest: f64::INFINITY };
        for offset in 0..27 {
            let key = [cell[0] + offset % 3 - 1, cell[1] + offset / 3 % 3 - 1, cell[2] + offset / 9 - 1];
            for &j in self.0.get(&key).into_iter().flatten().filter(|&&j| j != i) {
                let d: [f64; 3] = std::array::from_fn(|k| (frame.positions[j][k] - p[k]) / frame.spacing);
                let distance = d.iter().map(|c| c * c).sum::<f64>().sqrt();
                if distance <= reach {
                    near.nearest = near.nearest.min(distance);
                    let octant = (0..3).map(|k| usize::from(d[k] > 0.0) << k).sum::<usize>();
                    near.octants[octant] += 1;
                }
            }
        }
        near
    }
}

#[test]
fn the_source_gives_world_positions_and_what_is_asked_for() {
    let options = options(2_000, 5);
    let source = CaseSource::new(Case::FjordTsunami, options).expect("valid options");
    assert_eq!(source.frame_count(), 5);
    assert_eq!(source.time(4), Some(200.0));
    assert_eq!(source.time(5), None);
    let request = FrameRequest { attributes: vec!["velocity".into(), "density".into()] };
    let frame = source.read(3, &request, &Cancel::default()).expect("frame 3");
    let file = Case::FjordTsunami.frame(&options, 3);
    let water = &frame.sets[0].particles;
    assert_eq!(water.len(), 2_000);
    assert_eq!(water.ids[1999], 1999);
    for (world, file) in water.positions.iter().zip(&file.positions) {
        for axis in 0..3 {
            let back = f64::from(world[axis]) + source.space().origin[axis];
            // Half a unit in the last place of an f32 below 8192 m.
            assert!((back - file[axis]).abs() <= 2.5e-4);
        }
    }
    assert_eq!((water.attributes[0].name.as_str(), water.attributes[0].components), ("velocity", 3));
    assert_eq!(water.attributes[0].values[3..6], file.velocities[1]);
    assert_eq!(water.attributes[1].values, file.density);
}

#[test]
fn wrong_requests_are_named() {
    let source = CaseSource::new(Case::DamBreak, options(10, 2)).expect("valid options");
    let read = |index, name: &str, cancel: &Cancel| {
        let attributes = if name.is_empty() { vec![] } else { vec![name.to_owned()] };
        source.read(index, &FrameRequest { attributes }, cancel).map_err(|error| error.kind)
    };
    let go = Cancel::default();
    assert_eq!(read(2, "", &go), Err(FrameErrorKind::Usage));
    assert_eq!(read(0, "vorticity", &go), Err(FrameErrorKind::Usage));
    let stop = Cancel::default();
    stop.cancel();
    assert_eq!(read(0, "", &stop), Err(FrameErrorKind::Cancelled));

    assert_eq!("lake".parse::<Case>(), Err(CaseError::UnknownCase("lake".into())));
    for case in Case::ALL {
        assert_eq!(case.to_string().parse(), Ok(case));
    }
    let refused = |particles, frames| CaseSource::new(Case::DamBreak, options(particles, frames)).err();
    assert_eq!(refused(0, 1), Some(CaseError::Particles { found: 0 }));
    assert_eq!(refused(200_000_001, 1), Some(CaseError::Particles { found: 200_000_001 }));
    assert_eq!(refused(1, 0), Some(CaseError::NoFrames));
}
