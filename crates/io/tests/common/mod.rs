//! The shared test data and its index.
#![allow(dead_code, reason = "every test file uses its part")]

pub mod legacy;
pub mod records;
pub mod xml;

use std::path::{Path, PathBuf};

use meniscus_io::FrameInfo;
use serde_json::Value;

/// The data folder: `MENISCUS_DATA`, else `../shared/data` beside the workspace. Without it the test says so and passes.
#[allow(clippy::print_stderr, reason = "a skipped test must not look like a passed one")]
pub fn data_dir() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let dir = std::env::var_os("MENISCUS_DATA").map_or(beside, PathBuf::from);
    if dir.join("index.json").is_file() {
        return Some(dir);
    }
    eprintln!("SKIPPED: no test data at {}; set MENISCUS_DATA", dir.display());
    None
}

/// An entry of the index.
pub struct Entry(Value);

pub fn entries(dir: &Path) -> Vec<Entry> {
    let text = std::fs::read_to_string(dir.join("index.json")).expect("the index");
    let mut index: Value = serde_json::from_str(&text).expect("valid JSON");
    let Value::Array(list) = index["entries"].take() else { panic!("no entries") };
    list.into_iter().map(Entry).collect()
}

impl Entry {
    pub fn file(&self) -> &str {
        self.0["file"].as_str().expect("a file")
    }

    pub fn expect(&self) -> &str {
        self.0["expect"].as_str().expect("an expectation")
    }

    pub fn points(&self) -> Option<u64> {
        self.0["points"].as_u64()
    }

    pub fn bounds(&self) -> Option<Vec<f64>> {
        numbers(&self.0["bounds"])
    }

    /// Time and file names of every step.
    pub fn time_steps(&self) -> Option<Vec<(f64, Vec<String>)>> {
        let steps = self.0["timesteps"].as_array()?;
        let names = |files: &Value| {
            files.as_array().expect("files").iter().map(|f| f.as_str().expect("a name").to_owned()).collect()
        };
        Some(steps.iter().map(|s| (s[0].as_f64().expect("a time"), names(&s[1]))).collect())
    }

    /// What differs in number and place of the points.
    pub fn geometry_differences(&self, info: &FrameInfo) -> Vec<String> {
        let mut list = Vec::new();
        let mut compare = |what: &str, found: String, expected: String| {
            if found != expected {
                list.push(format!("{}: {what} {found}, expected {expected}", self.file()));
            }
        };
        let count = |key: &str| self.0[key].as_u64();
        compare("points", info.points.to_string(), count("points").unwrap_or(0).to_string());
        if let Some(finite) = count("finite_points") {
            compare("finite points", info.finite_points.to_string(), finite.to_string());
        }
        if let Some(ty) = self.0["point_type"].as_str() {
            compare("type", info.point_type.unwrap_or("none").to_lowercase(), ty.to_lowercase());
        }
        if let Some(bounds) = self.bounds() {
            let found = info.bounds.expect("bounds");
            for (found, expected) in found.iter().zip(bounds) {
                if !same(*found, expected) {
                    list.push(format!("{}: bound {found}, expected {expected}", self.file()));
                }
            }
        }
        if let Some(sums) = numbers(&self.0["sum"]).filter(|_| info.finite_points > 0) {
            let bounds = info.bounds.expect("bounds");
            for (axis, (mean, sum)) in info.centroid.expect("a centroid").into_iter().zip(sums).enumerate() {
                let size = bounds[2 * axis].abs().max(bounds[2 * axis + 1].abs());
                // Both sums round once per point, in another order.
                let tolerance = info.finite_points as f64 * size * 1e-13;
                if (mean * info.finite_points as f64 - sum).abs() > tolerance {
                    list.push(format!("{}: centroid {mean} does not give the sum {sum}", self.file()));
                }
            }
        }
        list
    }

    /// What differs in points and attributes.
    pub fn differences(&self, info: &FrameInfo) -> Vec<String> {
        let mut list = self.geometry_differences(info);
        for expected in self.0["point_arrays"].as_array().into_iter().flatten() {
            let name = expected["name"].as_str().expect("a name");
            // The reference reader cuts lines at 256 bytes and then reports arrays that are not in the file.
            let cut = name.len() > 20 && name.bytes().all(|b| b == b'x');
            if expected["tuples"].as_u64() != self.points() || cut {
                continue;
            }
            let Some(found) = info.attributes.iter().find(|a| a.name == name) else {
                let names: Vec<&str> = info.attributes.iter().map(|a| a.name.as_str()).collect();
                list.push(format!("{}: no attribute {name:?} in {names:?}", self.file()));
                continue;
            };
            let what = format!("{}: attribute {name:?}", self.file());
            if Some(found.components as u64) != expected["components"].as_u64() {
                list.push(format!(
                    "{what}: {} components, expected {}",
                    found.components, expected["components"]
                ));
            }
            if Some(found.ty) != expected["type"].as_str() {
                list.push(format!("{what}: type {}, expected {}", found.ty, expected["type"]));
            }
            let fold = |values: &Option<Vec<Option<f64>>>, pick: fn(f64, f64) -> f64| {
                values.iter().flatten().flatten().copied().reduce(pick)
            };
            for (key, found) in [("min", fold(&found.min, f64::min)), ("max", fold(&found.max, f64::max))] {
                let Some(expected) = expected[key].as_f64() else { continue };
                if !found.is_some_and(|found| same(found, expected)) {
                    list.push(format!("{what}: {key} {found:?}, expected {expected}"));
                }
            }
        }
        list
    }
}

/// Both are the doubles of the file; the JSON reader may be off by the last bit (2e-16).
fn same(found: f64, expected: f64) -> bool {
    (found - expected).abs() <= 4e-16 * expected.abs()
}

fn numbers(value: &Value) -> Option<Vec<f64>> {
    value.as_array()?.iter().map(Value::as_f64).collect()
}
