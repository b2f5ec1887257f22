//! Every built-in filter through the suite that all filters run through, and what only some of them promise.

mod common;

use common::{Scene, gpu, parallel, params};
use meniscus_cases::lattice;
use meniscus_ssfr::conformance::{self, Check};
use meniscus_ssfr::{FilterChoice, FilterRegistry, SsfrParams};

/// Stable with any number of steps, however long one is.
#[test]
fn curvature_flow_of_any_length_is_stable() {
    let gpu = gpu();
    for parameters in [
        r#"{"sigma": 10.0, "iterations": 1}"#,
        r#"{"sigma": 10.0, "iterations": 7, "threshold": 1000.0}"#,
        r#"{"sigma": 10.0, "iterations": 256}"#,
    ] {
        let choice = FilterChoice {
            name: "curvature-flow".into(),
            parameters: serde_json::from_str(parameters).unwrap(),
        };
        let filter = FilterRegistry::builtin().create(&gpu, &choice).unwrap();
        for check in [Check::NoiseDoesNotGrow, Check::ConstantPlanes, Check::Range] {
            assert_eq!(check.run(&gpu, &*filter), Ok(()), "{parameters}");
        }
    }
}

fn conforms(name: &str, parameters: &[&str]) {
    conformance::assert_conforms(&gpu(), &FilterRegistry::builtin(), name, parameters);
}

#[test]
fn narrow_range() {
    conforms(
        "narrow-range",
        &[
            r#"{"sigma": 2.0, "iterations": 1}"#,
            r#"{"sigma": 1.5, "iterations": 3, "clamp": 0.5, "threshold": 3.0}"#,
            r#"{"sigma": 0.3, "iterations": 16, "clamp": 10.0, "threshold": 1000.0}"#,
        ],
    );
}

#[test]
fn narrow_range_paper() {
    conforms(
        "narrow-range-paper",
        &[
            r#"{"sigma": 2.0, "iterations": 1, "clamp": 0.0}"#,
            r#"{"sigma": 1.5, "iterations": 4, "threshold": 20.0}"#,
        ],
    );
}

#[test]
fn bilateral() {
    conforms(
        "bilateral",
        &[
            r#"{"sigma": 2.0, "iterations": 1}"#,
            r#"{"sigma": 1.5, "iterations": 4, "threshold": 3.0}"#,
            r#"{"sigma": 0.0, "iterations": 16, "threshold": 1000.0}"#,
        ],
    );
}

#[test]
fn curvature_flow() {
    conforms(
        "curvature-flow",
        &[r#"{"sigma": 0.5, "iterations": 1}"#, r#"{"sigma": 2.0, "iterations": 40, "threshold": 2.0}"#],
    );
}

#[test]
fn adaptive() {
    conforms(
        "adaptive",
        &[
            r#"{"sigma": 2.0, "iterations": 1, "edges": 1.0}"#,
            r#"{"sigma": 1.5, "iterations": 3, "bend": 0.01}"#,
        ],
    );
}

#[test]
fn gaussian() {
    conforms("gaussian", &[r#"{"sigma": 0.0}"#, r#"{"sigma": 3.0}"#]);
}

#[test]
fn none() {
    conforms("none", &[]);
}

/// No filter is left out: each entry has a test of its name above.
#[test]
fn every_filter_is_tested() {
    let here = include_str!("filters.rs");
    for entry in FilterRegistry::builtin().entries() {
        let test = format!("conforms({:?}", entry.name());
        let multiline = format!("        {:?},\n        &[", entry.name());
        assert!(here.contains(&test) || here.contains(&multiline), "{} runs through no suite", entry.name());
    }
}

/// What the taps of the filter for ellipsoids leave between them where they are eight pixels apart and sixteen: waves of them, and all
/// that has as many in them.
#[test]
fn extreme_close_ups_have_no_mesh() {
    let gpu = gpu();
    let spacing = 0.1;
    let body = lattice::cuboid([-1.2, -1.2, -0.7], [24, 24, 2], spacing, 0.3, 1);
    for (spacing_px, side) in [(100.0, 480_u32), (180.0, 700)] {
        let height = side as f32 / spacing_px * spacing;
        let scene = Scene::new(parallel(0.0, height), [side, side], &body.positions, 0.08, spacing);
        let parameters = serde_json::from_str(r#"{"sigma": 0.8, "iterations": 1}"#).unwrap();
        let filter = FilterChoice { name: "narrow-range".into(), parameters };
        let frame = scene.render(&gpu, &SsfrParams { filter, ..params("none", 2, 1.0) });
        let cell = || {
            let places = (side as usize - spacing_px as usize) / 2..(side as usize + spacing_px as usize) / 2;
            places.clone().flat_map(move |y| places.clone().map(move |x| (y * side as usize, x)))
        };
        // Fourth differences over one pixel and over two: waves of two and of four are in them sixteen times, bumps hardly.
        let off = cell().flat_map(|(row, x)| {
            let at = |x: usize| f64::from(frame.distance[row + x]);
            [1, 2].map(|d| {
                let [near, far] = [d, 2 * d].map(|d| at(x - d) + at(x + d));
                ((far - 4.0 * near + 6.0 * at(x)) / 16.0).powi(2)
            })
        });
        let rms = (off.sum::<f64>() / cell().count() as f64).sqrt();
        // Distances of half a unit are rounded to 6e-8; a mesh has ten times what is left of the bumps themselves.
        assert!(rms < 5e-7 * f64::from(spacing), "{spacing_px} px apart: {rms}");
    }
}
