//! A run as `bench --json` or `render --report` wrote it.

use std::path::{Path, PathBuf};

use meniscus_core::{FrameError, FrameErrorKind, StageCost};
use serde_json::Value;

use super::CLOCKS;
use crate::bench::spread::Spread;
use crate::bench::stages::StageSamples;
use crate::failure::Failure;

/// GPU, wall and CPU milliseconds; `None` for a clock that the run does not have.
pub type Clocks = [Option<Spread>; 3];

/// What is compared of a run.
#[derive(Debug)]
pub struct Run {
    pub path: PathBuf,
    /// `bench` or `report`.
    pub kind: &'static str,
    /// What decides the cost, as path and value of every leaf.
    pub setup: Vec<(String, Value)>,
    pub frame: Clocks,
    /// In the order in which stages ran.
    pub stages: Vec<(String, Clocks)>,
}

/// What of a file says how the run was set up; the rest is its results.
const SETUP: [&str; 14] = [
    "version",
    "input",
    "series_frame",
    "pictures",
    "threads",
    "adapter",
    "driver",
    "device",
    "size",
    "particles",
    "kept",
    "camera",
    "space",
    "settings",
];

/// Where both kinds of file come from.
const ADVICE: &str = "give what `meniscus bench --json` prints or `meniscus render --report` writes";

impl Run {
    /// Reads `path`.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let fail = |kind, message| FrameError { kind, file: Some(path.to_owned()), message };
        let text = std::fs::read_to_string(path).map_err(|error| {
            let kind = match error.kind() {
                std::io::ErrorKind::NotFound => FrameErrorKind::NotFound,
                std::io::ErrorKind::InvalidData => FrameErrorKind::Malformed,
                _ => FrameErrorKind::Io,
            };
            fail(kind, format!("cannot be read: {error}; {ADVICE}"))
        })?;
        let malformed = |message| fail(FrameErrorKind::Malformed, message);
        let value: Value =
            serde_json::from_str(&text).map_err(|e| malformed(format!("expected JSON: {e}; {ADVICE}")))?;
        Self::of(path, &value).map_err(|message| Failure::Input(malformed(message)))
    }

    fn of(path: &Path, value: &Value) -> Result<Self, String> {
        if let Some(message) = value.pointer("/error/message").and_then(Value::as_str) {
            return Err(format!("this run failed: {message}"));
        }
        let (kind, frame, stages) = if value["stages"].is_array() {
            let (frame, stages) = of_bench(value)?;
            ("bench", frame, stages)
        } else if value["frames"].is_array() {
            let (frame, stages) = of_report(value)?;
            ("report", frame, stages)
        } else {
            return Err(format!(
                "expected an array `stages` (of bench) or `frames` (of render), found {}; {ADVICE}",
                words(value)
            ));
        };
        if frame.iter().all(Option::is_none) && stages.is_empty() {
            return Err("it has no measured picture; nothing can be compared".into());
        }
        let mut setup = Vec::new();
        for key in SETUP {
            leaves(key, &value[key], &mut setup);
        }
        // A report has the whole adapter where a bench has its name.
        setup
            .iter_mut()
            .filter(|(key, _)| key == "adapter.name")
            .for_each(|(key, _)| *key = "adapter".into());
        setup
            .iter_mut()
            .filter(|(key, _)| key == "adapter.driver")
            .for_each(|(key, _)| *key = "driver".into());
        Ok(Self { path: path.to_owned(), kind, setup, frame, stages })
    }

    /// The clocks of the stage `name`.
    pub fn stage(&self, name: &str) -> Option<&Clocks> {
        self.stages.iter().find(|(n, _)| n == name).map(|(_, clocks)| clocks)
    }
}

type Measured = (Clocks, Vec<(String, Clocks)>);

fn of_bench(value: &Value) -> Result<Measured, String> {
    let clocks = |at: &str, value: &Value| -> Result<Clocks, String> {
        let mut clocks = [None; 3];
        for (clock, name) in clocks.iter_mut().zip(CLOCKS) {
            *clock = spread(&format!("{at}.{name}"), &value[name])?;
        }
        Ok(clocks)
    };
    let stages = elements(&value["stages"])
        .map(|(index, stage)| {
            let at = format!("stages[{index}]");
            Ok((name(&at, stage)?, clocks(&at, stage)?))
        })
        .collect::<Result<_, String>>()?;
    Ok((clocks("frame", &value["frame"])?, stages))
}

/// A report has every frame; a whole frame's clock is there only where the passes were timed without running them apart.
fn of_report(value: &Value) -> Result<Measured, String> {
    let mut samples = StageSamples::default();
    let mut gpu = Vec::new();
    for (index, frame) in elements(&value["frames"]) {
        let mut costs = Vec::new();
        for (number, stage) in elements(&frame["stages"]) {
            let at = format!("frames[{index}].stages[{number}]");
            let [gpu_ms, wall_ms, cpu_ms] =
                CLOCKS.map(|clock| number_at(&format!("{at}.{clock}"), &stage[clock]));
            costs.push(StageCost {
                name: name(&at, stage)?,
                gpu_ms: gpu_ms?,
                wall_ms: wall_ms?,
                cpu_ms: cpu_ms?,
            });
        }
        let stamps: Vec<f64> = costs.iter().filter_map(|cost| cost.gpu_ms).collect();
        if !stamps.is_empty() {
            gpu.push(stamps.iter().sum());
        }
        samples.add(costs);
    }
    let stages = samples.spreads().map(|(name, clocks)| (name.to_owned(), clocks)).collect();
    Ok(([Spread::of(&gpu), None, None], stages))
}

fn elements(value: &Value) -> impl Iterator<Item = (usize, &Value)> {
    value.as_array().into_iter().flatten().enumerate()
}

fn name(at: &str, stage: &Value) -> Result<String, String> {
    let name = stage["name"].as_str();
    name.map(ToOwned::to_owned).ok_or_else(|| wrong(&format!("{at}.name"), "a stage's name", &stage["name"]))
}

/// `None` for null or nothing.
fn number_at(at: &str, value: &Value) -> Result<Option<f64>, String> {
    match value {
        Value::Null => Ok(None),
        Value::Number(number) if number.as_f64().is_some_and(|ms| ms >= 0.0) => Ok(number.as_f64()),
        _ => Err(wrong(at, "milliseconds, 0 or more", value)),
    }
}

fn spread(at: &str, value: &Value) -> Result<Option<Spread>, String> {
    if value.is_null() {
        return Ok(None);
    }
    let ordered = |s: &Spread| 0.0 <= s.min && s.min <= s.median && s.median <= s.max;
    let spread = serde_json::from_value(value.clone()).ok().filter(ordered);
    spread.map(Some).ok_or_else(|| wrong(at, "min <= median <= max in milliseconds", value))
}

fn wrong(at: &str, expected: &str, found: &Value) -> String {
    format!("{at}: expected {expected}, found {}; {ADVICE}", words(found))
}

/// A value in a few words.
fn words(value: &Value) -> String {
    match value {
        Value::Null => "nothing".into(),
        Value::Array(items) => format!("an array of {}", items.len()),
        Value::Object(map) => {
            format!("an object with {}", map.keys().take(5).cloned().collect::<Vec<_>>().join(", "))
        }
        other => other.to_string().chars().take(60).collect(),
    }
}

/// Path and value of every leaf below `value`; nothing for null.
fn leaves(path: &str, value: &Value, out: &mut Vec<(String, Value)>) {
    match value {
        Value::Null => {}
        Value::Object(map) => {
            map.iter().for_each(|(key, value)| leaves(&format!("{path}.{key}"), value, out))
        }
        // Sizes, points and lists of features read best whole.
        other => out.push((path.to_owned(), other.clone())),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn of(value: Value) -> Result<Run, String> {
        Run::of(Path::new("x.json"), &value)
    }

    #[test]
    fn the_frames_of_a_report_become_spreads() {
        let frame = |ms: f64| json!({"stages": [{"name": "ssfr.depth", "gpu_ms": ms, "wall_ms": null}]});
        let run =
            of(json!({"adapter": {"name": "g"}, "frames": [frame(1.0), frame(3.0), frame(2.0)]})).unwrap();
        let expected = Some(Spread { median: 2.0, min: 1.0, max: 3.0 });
        assert_eq!((run.kind, run.stage("ssfr.depth")), ("report", Some(&[expected, None, None])));
        assert_eq!(run.frame[0], expected);
        assert_eq!(run.setup, [("adapter".to_owned(), json!("g"))]);
    }

    #[test]
    fn errors_name_the_element() {
        let stage = |stage: Value| of(json!({"stages": [stage]})).unwrap_err();
        assert!(stage(json!({"name": 3})).contains("stages[0].name: expected a stage's name, found 3"));
        let upside_down = json!({"name": "a", "gpu_ms": {"min": 2.0, "median": 1.0, "max": 3.0}});
        assert!(stage(upside_down).contains("stages[0].gpu_ms"));
        assert!(stage(json!({"name": "a", "wall_ms": 3.0})).contains("stages[0].wall_ms"));
        assert!(
            of(json!({"frames": [{"stages": [{"name": "a", "gpu_ms": -1}]}]}))
                .unwrap_err()
                .contains("found -1")
        );
        assert!(of(json!({"hello": 1})).unwrap_err().contains("an object with hello"));
        assert!(of(json!({"error": {"message": "no adapter"}})).unwrap_err().contains("failed: no adapter"));
        assert!(of(json!({"frames": []})).unwrap_err().contains("no measured picture"));
    }
}
