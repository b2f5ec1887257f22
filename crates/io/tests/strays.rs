//! A few particles that are far from the others decide nothing about a series.

use std::path::Path;

use meniscus_core::{Cancel, Flaw, FrameRequest, FrameSource, UpAxis};
use meniscus_io::writer::{WriteParticles, write_vtu_raw};
use meniscus_io::{Series, SeriesOptions};

const SPACING: f64 = 0.1;

/// Water with a flat bottom and waves on top: columns of 5 to 13 particles.
fn water() -> Vec<[f64; 3]> {
    let mut points = Vec::new();
    for (x, y) in (0..40 * 20).map(|i| (i % 40, i / 40)) {
        let height = (9.0 + 4.0 * (0.3 * f64::from(x)).sin() * (0.2 * f64::from(y)).cos()) as i32;
        points.extend((0..height).map(|z| [x, y, z].map(|c| SPACING * (f64::from(c) + 0.5))));
    }
    points
}

fn open(folder: &Path, positions: &[[f64; 3]]) -> Series {
    let path = folder.join("water.vtu");
    write_vtu_raw(&path, &WriteParticles { positions, attributes: &[], time: None }).expect("written");
    Series::open(&path, &SeriesOptions::default()).expect("opens")
}

/// Numbers in -1..1, deterministic.
fn noise(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 40) as f64 / (1 << 23) as f64 - 1.0
}

fn cloud(count: usize, half_width: f64) -> Vec<[f64; 3]> {
    let mut seed = 5;
    (0..count).map(|_| std::array::from_fn(|_| half_width * noise(&mut seed))).collect()
}

#[test]
fn strays_change_nothing_and_those_too_far_for_f32_are_left_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let water = water();
    let plain = open(folder.path(), &water);
    assert_eq!(plain.space().up, UpAxis::Z);
    // 1.9 % of the particles.
    let few = water.len() * 19 / 1000;
    for (strays, dropped) in [
        (vec![[1e308, 0.0, 0.0]], 1),
        (vec![[-1e308, 0.0, 0.0]], 1),
        (vec![[0.0, 3e38, 0.0]], 1),
        (vec![[1e30; 3]; few], few),
        (vec![[1e6, 0.0, 0.0]], 1),
        (vec![[1e4, 0.0, 0.0]], 0),
        (vec![[-1000.0; 3]; few], 0),
        (vec![[-3.0, -5.0, -4.0]; few], 0),
        (cloud(few, 10.0), 0),
        (cloud(50, 5000.0), 0),
        // Leaked through the bottom.
        (vec![[1.0, 1.0, -1.5], [2.0, 1.0, -0.4], [3.0, 0.5, -0.8], [1.0, 0.5, -0.3], [0.5, 1.5, -2.0]], 0),
    ] {
        // In front, and behind.
        for positions in [[strays.clone(), water.clone()].concat(), [water.clone(), strays.clone()].concat()]
        {
            let series = open(folder.path(), &positions);
            let (space, first) = (series.space(), strays[0]);
            // 1 %: the samples are others.
            assert!((space.spacing / SPACING - 1.0).abs() < 0.01, "{first:?}: spacing {}", space.spacing);
            assert_eq!(space.up, UpAxis::Z, "{first:?}: {:?}", series.choices());
            assert!((space.origin - plain.space().origin).length() < 4.0, "{first:?}: {}", space.origin);
            let frame = series.read(0, &FrameRequest::default(), &Cancel::default()).expect("reads");
            assert_eq!(frame.len(), positions.len() - dropped, "{first:?}");
            let said: Vec<&Flaw> = frame.flaws.iter().collect();
            match said[..] {
                [] => assert_eq!(dropped, 0, "{first:?}"),
                [Flaw::FarDropped { count, distance }] => {
                    assert_eq!(*count, dropped as u64, "{first:?}");
                    // Where the steps of f32 are half a spacing.
                    assert!((f64::from(*distance) / (SPACING * f64::from(1 << 23)) - 1.0).abs() < 0.01);
                }
                _ => panic!("{first:?}: {said:?}"),
            }
        }
    }
}

#[test]
fn far_and_broken_coordinates_are_told_apart() {
    let folder = tempfile::tempdir().expect("a folder");
    let broken = [[f64::NAN, 0.0, 0.0], [0.0, f64::INFINITY, 0.0], [1e200, 0.0, 0.0]];
    let positions = [water(), broken.to_vec()].concat();
    let options = [SeriesOptions::default(), SeriesOptions { every: Some(1), ..Default::default() }];
    let path = folder.path().join("water.vtu");
    write_vtu_raw(&path, &WriteParticles { positions: &positions, attributes: &[], time: None })
        .expect("written");
    for options in options {
        let series = Series::open(&path, &options).expect("opens");
        let frame = series.read(0, &FrameRequest::default(), &Cancel::default()).expect("reads");
        assert!(frame.flaws.iter().any(|flaw| *flaw == Flaw::NonFiniteDropped { count: 2 }));
        assert!(frame.flaws.iter().any(|flaw| matches!(flaw, Flaw::FarDropped { count: 1, .. })));
        assert_eq!(frame.len(), positions.len() - 3);
    }
}

#[test]
fn two_pools_far_apart_are_one_series() {
    let folder = tempfile::tempdir().expect("a folder");
    let other = water().into_iter().map(|[x, y, z]| [x + 600.0, y, z]);
    let positions = [water(), other.collect()].concat();
    let series = open(folder.path(), &positions);
    assert!((series.space().spacing / SPACING - 1.0).abs() < 0.01, "{}", series.space().spacing);
    assert!((series.space().origin.x - 300.0).abs() < 10.0, "{}", series.space().origin);
}
