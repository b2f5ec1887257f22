//! The program as its users run it.

use std::path::Path;
use std::process::{Command, Output};

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_custom-lighting")).args(arguments).current_dir(folder).output().unwrap()
}

fn ok(output: &Output) {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn the_model_is_chosen_by_name_and_benched_like_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    ok(&run(folder, &["make", "dam-break", "-o", "dam", "--particles", "4000"]));
    let picture = |name: &str, lighting: &[&str]| {
        let arguments = ["render", "dam/dam_break.pvd", "-o", name, "--size", "160x90"];
        ok(&run(folder, &[&arguments[..], lighting].concat()));
        image::open(folder.join(name)).unwrap().into_rgb8().into_raw()
    };
    let chart = picture("chart.png", &["--lighting", "chart"]);
    let bare = picture("bare.png", &["--lighting", "chart", "--param", "lighting.contours=0"]);
    let water = picture("water.png", &[]);
    assert!(chart != water && chart != bare);

    let bench = ["bench", "dam/dam_break.pvd", "--lighting", "chart", "--size", "160x90"];
    let output = run(folder, &[&bench[..], &["--frames", "1", "--warmup", "0", "--json"]].concat());
    ok(&output);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let stages = report["stages"].as_array().unwrap();
    assert!(stages.iter().any(|stage| stage["name"] == "custom.chart"), "{stages:?}");
}

#[test]
fn mistakes_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    ok(&run(folder, &["make", "dam-break", "-o", "dam", "--particles", "500"]));
    for (lighting, explained) in [
        (&["--lighting", "charts"][..], "chart"),
        (&["--lighting", "chart", "--param", "lighting.relief=2"], "relief is 2"),
        (&["--lighting", "chart", "--param", "lighting.reliefs=1"], "reliefs"),
    ] {
        let output = run(folder, &[&["render", "dam/dam_break.pvd", "-o", "a.png"], lighting].concat());
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && message.contains(explained), "{message}");
    }
}
