//! Every lighting model of this crate through the conformance suite.

use meniscus_shading::LightingRegistry;
use meniscus_shading::conformance::assert_conforms;

use crate::support::gpu;

fn conforms(name: &str, parameters: &[&str]) {
    assert_conforms(&gpu(), &LightingRegistry::builtin(), name, parameters);
}

#[test]
fn fluid() {
    conforms(
        "fluid",
        &[
            r#"{"preset": "milk", "roughness": 0.6}"#,
            r#"{"refraction_scale": 0, "additional_reflection": 0.3, "spray": 1}"#,
        ],
    );
}

#[test]
fn vtk() {
    conforms("vtk", &[r#"{"DisplayMode": "FilteredOpaqueSurface", "OpaqueColor": [0.9, 0.5, 0.1]}"#]);
}

#[test]
fn point_light() {
    conforms("point-light", &[r#"{"preset": "river", "light_distance": 0.5, "light_intensity": 20}"#]);
}

#[test]
fn lambert() {
    conforms("lambert", &[r#"{"preset": "mud"}"#]);
}

#[test]
fn blinn_phong() {
    conforms("blinn-phong", &[r#"{"preset": "oil", "specular": 5, "shininess": 2}"#]);
}

#[test]
fn opaque() {
    conforms("opaque", &[r#"{"preset": "clear", "softness": 1, "roughness": 0.9}"#]);
}

#[test]
fn granular() {
    conforms("granular", &[r#"{"roughness": 0, "gaps": 1, "wetness": 1}"#]);
}

/// A model that is added here is tested here.
#[test]
fn every_built_in_model_is_tested() {
    let tested = include_str!("conformance.rs");
    for name in LightingRegistry::builtin().names() {
        assert!(tested.contains(&format!("\"{name}\",")), "{name}");
    }
}
