//! The layers of ARCHITECTURE.md, as a check.

use super::graph::{Graph, Place};

/// Each crate's layer; arrows point from a higher to a lower number only.
const LAYERS: &[(&str, u8)] = &[
    ("meniscus-core", 0),
    ("meniscus-huge-pages", 0),
    ("meniscus-map-guard", 0),
    ("meniscus-io", 0),
    ("meniscus-scene", 0),
    ("meniscus-cases", 0),
    ("meniscus-prefetch", 0),
    ("meniscus-timeline", 0),
    ("meniscus-color", 0),
    ("meniscus-gpu", 1),
    ("meniscus-lod", 2),
    ("meniscus-ssfr", 2),
    ("meniscus-shading", 2),
    ("meniscus-compositor", 2),
    ("meniscus-pipeline", 3),
    ("meniscus-overlay", 4),
    ("meniscus-export", 4),
    ("meniscus-viewer", 4),
    ("meniscus", 5),
];

/// Layer 0 runs without a GPU and without the libraries of one.
const NO_GPU_LAYER: u8 = 0;

/// Every broken rule, with the path that breaks it; empty when the layers hold.
///
/// - An arrow between crates of the product points to a lower layer. Only inside layer 0, the shared
///   vocabulary, may it stay level. This holds for dev-dependencies too: a stage that needs another stage for its
///   tests needs a case in `tests/` instead.
/// - No crate of layer 0 reaches wgpu; there dev-dependencies do not count.
/// - Nothing in the product depends on what lies around it (`tests/`, `benches/`, `xtask/`, `examples/`).
pub fn offences(graph: &Graph) -> Vec<String> {
    let mut offences = Vec::new();
    for (index, package) in graph.packages.iter().enumerate() {
        if package.place != Place::Pipeline {
            continue;
        }
        let Some(layer) = layer(&package.name) else {
            offences.push(format!(
                "{} has no layer; add it to LAYERS in xtask/src/check/layers.rs and to ARCHITECTURE.md",
                package.name
            ));
            continue;
        };
        for dependency in &package.dependencies {
            let below = &graph.packages[dependency.to];
            let kind = if dependency.dev_only { " (dev-dependency)" } else { "" };
            let arrow = format!("{} -> {}{kind}", package.name, below.name);
            match below.place {
                Place::External => {}
                Place::Around => {
                    offences.push(format!("{arrow}: the product cannot depend on what lies around it"));
                }
                Place::Pipeline => offences.extend(
                    self::layer(&below.name)
                        .and_then(|below| broken_arrow(layer, below))
                        .map(|why| format!("{arrow}: {why}")),
                ),
            }
        }
        if layer == NO_GPU_LAYER
            && let Some(path) = graph.path_to(index, |name| name.starts_with("wgpu"))
        {
            offences.push(format!("{}: layer {NO_GPU_LAYER} never sees the GPU", path.join(" -> ")));
        }
    }
    offences
}

fn layer(name: &str) -> Option<u8> {
    LAYERS.iter().find(|(listed, _)| *listed == name).map(|(_, layer)| *layer)
}

fn broken_arrow(from: u8, to: u8) -> Option<String> {
    if to < from || (from == NO_GPU_LAYER && to == NO_GPU_LAYER) {
        return None;
    }
    let direction = if to == from { "sideways" } else { "up" };
    Some(format!("points {direction}, from layer {from} to layer {to}"))
}

#[cfg(test)]
mod tests {
    use super::super::graph::fake;
    use super::*;

    const SOUND: &[&str] = &[
        "meniscus: meniscus-pipeline meniscus-export clap",
        "meniscus-pipeline: meniscus-ssfr meniscus-lod meniscus-io",
        "meniscus-ssfr: meniscus-gpu meniscus-core (meniscus-cases)",
        "meniscus-lod: meniscus-gpu",
        "meniscus-gpu: meniscus-core wgpu",
        "meniscus-io: meniscus-core (meniscus-cases)",
        "meniscus-cases: meniscus-core",
        "meniscus-tests: meniscus meniscus-ssfr wgpu",
    ];

    fn offences_with(line: &str) -> Vec<String> {
        let mut lines = SOUND.to_vec();
        lines.push(line);
        offences(&fake::graph(&lines, &["meniscus-tests"]))
    }

    #[test]
    fn the_designed_graph_is_sound() {
        assert_eq!(offences_with("meniscus-export: meniscus-core"), [""; 0]);
    }

    #[test]
    fn a_stage_that_sees_a_stage_is_caught() {
        let found = offences_with("meniscus-ssfr: meniscus-lod");
        assert_eq!(found, ["meniscus-ssfr -> meniscus-lod: points sideways, from layer 2 to layer 2"]);
    }

    #[test]
    fn a_stage_that_tests_itself_with_a_stage_is_caught() {
        let found = offences_with("meniscus-ssfr: (meniscus-lod)");
        assert_eq!(found.len(), 1);
        assert!(found[0].starts_with("meniscus-ssfr -> meniscus-lod (dev-dependency)"), "{}", found[0]);
    }

    #[test]
    fn an_arrow_that_points_up_is_caught() {
        let found = offences_with("meniscus-gpu: meniscus-pipeline");
        assert_eq!(found, ["meniscus-gpu -> meniscus-pipeline: points up, from layer 1 to layer 3"]);
    }

    #[test]
    fn layer_0_that_reaches_wgpu_through_others_is_caught_with_the_path() {
        assert_eq!(offences_with("meniscus-scene: helper"), [""; 0], "helper alone is harmless");

        let mut lines = SOUND.to_vec();
        lines.extend(["meniscus-scene: helper", "helper: wgpu-types"]);
        let found = offences(&fake::graph(&lines, &["meniscus-tests"]));
        assert_eq!(found, ["meniscus-scene -> helper -> wgpu-types: layer 0 never sees the GPU"]);
    }

    #[test]
    fn layer_0_may_test_itself_with_a_library_that_uses_wgpu() {
        assert_eq!(offences_with("meniscus-scene: (wgpu)"), [""; 0]);
    }

    #[test]
    fn the_product_cannot_depend_on_its_tests() {
        assert_eq!(offences_with("meniscus-export: meniscus-tests").len(), 1);
    }

    #[test]
    fn a_crate_without_a_layer_is_caught() {
        let found = offences_with("meniscus-surprise: meniscus-core");
        assert_eq!(found.len(), 1);
        assert!(found[0].starts_with("meniscus-surprise has no layer"), "{}", found[0]);
    }
}
