//! Every built-in filter through the suite that all filters run through, and what only some of them promise.

mod common;

use common::gpu;
use meniscus_ssfr::conformance::{self, Check};
use meniscus_ssfr::{FilterChoice, FilterRegistry};

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
