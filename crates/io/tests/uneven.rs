//! Particles that lie unevenly are drawn with larger spheres, by the frame of a series that shows how they lie.

use std::path::Path;

use meniscus_io::writer::{WriteParticles, write_vtu_raw};
use meniscus_io::{Series, SeriesOptions};

/// Cells along each axis of a box with one particle in each.
const CELLS: usize = 24;

/// A particle in the middle of each cell, moved by up to half of `jitter` cells; or, if that is `None`, anywhere in the box.
fn particles(jitter: Option<f64>) -> Vec<[f64; 3]> {
    let mut seed = 3_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 40) as f64 / f64::from(1 << 24)
    };
    let cells = (0..CELLS.pow(3)).map(|i| [i % CELLS, i / CELLS % CELLS, i / CELLS / CELLS]);
    cells
        .map(|cell| match jitter {
            Some(jitter) => cell.map(|c| c as f64 + 0.5 + jitter * (random() - 0.5)),
            None => cell.map(|_| CELLS as f64 * random()),
        })
        .collect()
}

/// Radius per spacing of a series with these frames, and the line about it.
fn radius_of(folder: &Path, frames: &[Option<f64>]) -> (f64, String) {
    for (index, jitter) in frames.iter().enumerate() {
        let (path, positions) = (folder.join(format!("water_{index}.vtu")), particles(*jitter));
        let particles = WriteParticles { positions: &positions, attributes: &[], time: None };
        write_vtu_raw(&path, &particles).expect("written");
    }
    let series = Series::open(folder, &SeriesOptions::default()).expect("opens");
    let space = series.space();
    // How they lie does not depend on who says how far apart they are.
    let said = SeriesOptions { spacing: Some(2.0), ..Default::default() };
    let of_said = Series::open(folder, &said).expect("opens").space().radius / 2.0;
    assert_eq!(of_said, space.radius / space.spacing, "{frames:?}");
    // 5 %: the promise of the specification; a cell is one unit wide.
    assert!((space.spacing - 1.0).abs() < 0.05, "{frames:?}: {}", space.spacing);
    let line = series.choices().iter().find(|choice| choice.flag == "--radius").expect("a line");
    (space.radius / space.spacing, line.reason.clone())
}

#[test]
fn random_particles_are_drawn_larger() {
    let folder = tempfile::tempdir().expect("a folder");
    for even in [Some(0.0), Some(0.3)] {
        assert_eq!(radius_of(folder.path(), &[even]), (0.625, "0.625 of the spacing".to_owned()));
    }
    let (radius, line) = radius_of(folder.path(), &[Some(1.0)]);
    assert!((0.63..0.9).contains(&radius) && line.ends_with("particles lie unevenly"), "{radius} {line}");
    let random = (1.0, "1 of the spacing: particles lie unevenly".to_owned());
    assert_eq!(radius_of(folder.path(), &[None]), random);
    // A solver seeds a lattice, and particles leave it; what has been even for long is not looked at again.
    assert_eq!(radius_of(folder.path(), &[Some(0.0), Some(0.5), None]), random);
    assert_eq!(radius_of(folder.path(), &[Some(0.0), None, Some(0.3)]).0, 0.625);
}
