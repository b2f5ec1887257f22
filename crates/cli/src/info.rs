//! `meniscus info`.

use meniscus_core::{Cancel, FrameSource};
use meniscus_io::FrameInfo;
use serde_json::json;

use crate::args::InfoArgs;
use crate::failure::Failure;
use crate::input;
use crate::terminal::{Terminal, print};

pub fn run(args: &InfoArgs, terminal: &Terminal) -> Result<(), Failure> {
    // Nothing is written: Ctrl-C may end the process as it is.
    let series = input::open(&args.input, false, &Cancel::default())?;
    let frames = series.frame_count();
    if args.frame >= frames {
        return Err(Failure::Usage(format!(
            "--frame {}: the series has frames 0 to {}",
            args.frame,
            frames - 1
        )));
    }
    let info = series.frame_info(args.frame, args.stats)?;
    let times = series.times();
    if args.json {
        print(json!({ "frames": frames, "times": times, "frame": info }));
        return Ok(());
    }
    print_series(frames, &times);
    print_frame(&info);
    terminal.choices(series.choices());
    terminal.flaws(series.flaws());
    Ok(())
}

fn print_series(frames: usize, times: &[Option<f64>]) {
    let known: Vec<f64> = times.iter().copied().flatten().collect();
    match (known.first(), known.last()) {
        (Some(first), Some(last)) if frames > 1 => {
            print(format_args!("{frames} frames, time {first} to {last}"))
        }
        (Some(time), _) => print(format_args!("1 frame, time {time}")),
        _ => print(format_args!("{frames} frame{}, no times", if frames == 1 { "" } else { "s" })),
    }
}

fn print_frame(info: &FrameInfo) {
    // The JSON and the text come from the same struct, so they cannot disagree.
    let value = serde_json::to_value(info).unwrap_or_default();
    for key in [
        "index",
        "file",
        "points",
        "finite_points",
        "dropped",
        "point_type",
        "bounds",
        "centroid",
        "origin",
        "spacing",
        "spacing_source",
        "radius",
        "up",
    ] {
        if let Some(v) = value.get(key).filter(|v| !v.is_null()) {
            print(format_args!("  {key:15} {}", text(v)));
        }
    }
    for (title, key) in [("attributes", "attributes"), ("sets", "sets")] {
        let Some(items) = value.get(key).and_then(|v| v.as_array()).filter(|items| !items.is_empty()) else {
            continue;
        };
        print(format_args!("  {title}"));
        for item in items {
            let fields = item.as_object().into_iter().flatten();
            let shown: Vec<String> = fields
                .filter(|(k, v)| *k != "name" && !v.is_null())
                .map(|(k, v)| format!("{k} {}", text(v)))
                .collect();
            print(format_args!(
                "    {:13} {}",
                item.get("name").map(text).unwrap_or_default(),
                shown.join(", ")
            ));
        }
    }
}

fn text(value: &serde_json::Value) -> String {
    match value {
        // A name is one line, whatever it holds.
        serde_json::Value::String(s) => s.replace('\n', "\\n"),
        other => other.to_string(),
    }
}
