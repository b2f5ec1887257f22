//! A stage's bench builds that stage and what lies below it, nothing else: who works on a filter waits neither for readers
//! nor for windows, and no other stage can move its figures.

use super::windowless::is_window_system;
use crate::{
    error::Result,
    process::{capture, cargo},
};

/// The crates of the product that each bench is made of, without their `meniscus-`.
const BENCHES: &[(&str, &[&str])] = &[
    ("bench-io", &["core", "cases", "io", "map-guard"]),
    // Preparing a frame is cutting it into chunks, on the reader threads.
    ("bench-prefetch", &["core", "cases", "io", "map-guard", "prefetch", "lod", "gpu"]),
    ("bench-lod", &["core", "cases", "gpu", "lod"]),
    ("bench-ssfr-splat", &["core", "cases", "gpu", "ssfr"]),
    ("bench-raster", &["core", "cases", "gpu", "ssfr"]),
    ("bench-ssfr-filter", &["core", "cases", "gpu", "ssfr"]),
    ("bench-anisotropy", &["core", "cases", "gpu", "ssfr"]),
    ("bench-shading", &["core", "cases", "gpu", "scene", "shading"]),
    ("bench-compositor", &["core", "cases", "gpu", "compositor"]),
    ("bench-export", &["core", "cases", "export"]),
];

/// Asks cargo what each bench is made of.
pub fn offences_of_benches() -> Result<Vec<String>> {
    let mut offences = Vec::new();
    for (bench, allowed) in BENCHES {
        let arguments =
            ["tree", "-p", bench, "-e", "normal,build,dev", "--prefix", "none", "--format", "{p}"];
        let listing = capture(&mut cargo(arguments))?;
        let superfluous = superfluous(&String::from_utf8_lossy(&listing), allowed);
        offences.extend(superfluous.iter().map(|package| {
            format!("{bench} builds {package}; why: cargo tree -p {bench} -e normal,build,dev -i {package}")
        }));
    }
    Ok(offences)
}

/// What a listing of `name vVERSION ...` lines has of the product, or of a window system, beyond `allowed`.
fn superfluous(listing: &str, allowed: &[&str]) -> Vec<String> {
    let is_superfluous = |name: &&str| match name.strip_prefix("meniscus") {
        Some(rest) => !allowed.contains(&rest.trim_start_matches('-')),
        None => is_window_system(name),
    };
    let names = listing.lines().filter_map(|line| line.split_whitespace().next());
    let mut found: Vec<String> = names.filter(is_superfluous).map(String::from).collect();
    found.sort();
    found.dedup();
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_stages_and_windows_are_superfluous() {
        let listing = "bench-x v0.1.0 (/somewhere)\nmeniscus-core v0.1.0 (/somewhere)\nmeniscus-io v0.1.0\n\
                       wgpu v30.0.1\nwinit v0.30.12\nmeniscus-io v0.1.0 (*)\nmeniscus v0.1.0\n";
        assert_eq!(superfluous(listing, &["core"]), ["meniscus", "meniscus-io", "winit"]);
        assert_eq!(superfluous("meniscus-core v0.1.0\nserde v1.0.0\n", &["core"]), [""; 0]);
    }
}
