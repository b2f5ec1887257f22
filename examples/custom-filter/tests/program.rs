//! The program as its users run it.

use std::path::Path;
use std::process::{Command, Output};

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_custom-filter")).args(arguments).current_dir(folder).output().unwrap()
}

fn ok(output: &Output) {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn picture(folder: &Path, name: &str, filter: &[&str]) -> Vec<u8> {
    let mut arguments = vec!["render", "dam/dam_break.pvd", "-o", name, "--size", "160x90"];
    arguments.extend(filter);
    ok(&run(folder, &arguments));
    image::open(folder.join(name)).unwrap().into_rgb8().into_raw()
}

#[test]
fn the_filter_is_chosen_by_name_and_benched_like_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    ok(&run(folder, &["make", "dam-break", "-o", "dam", "--particles", "4000"]));

    let plane_fit = picture(folder, "plane_fit.png", &["--filter", "plane-fit"]);
    let unfiltered = picture(folder, "none.png", &["--filter", "none"]);
    let barely = picture(folder, "barely.png", &["--filter", "plane-fit", "--param", "filter.sigma=0"]);
    assert_ne!(plane_fit, unfiltered);
    assert_eq!(barely, unfiltered, "without a window the filter is none");

    let bench = ["bench", "dam/dam_break.pvd", "--filter", "plane-fit", "--size", "160x90"];
    let output = run(folder, &[&bench[..], &["--frames", "1", "--warmup", "0", "--json"]].concat());
    ok(&output);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let stages = report["stages"].as_array().unwrap();
    assert!(stages.iter().any(|stage| stage["name"] == "custom.plane_fit"), "{stages:?}");
}

#[test]
fn mistakes_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    ok(&run(folder, &["make", "dam-break", "-o", "dam", "--particles", "500"]));
    for (filter, explained) in [
        (&["--filter", "plane-fits"][..], "plane-fit"),
        (&["--filter", "plane-fit", "--param", "filter.sigma=99"], "filter.sigma is 99"),
        (&["--filter", "plane-fit", "--param", "filter.sigmas=1"], "sigmas"),
    ] {
        let output = run(folder, &[&["render", "dam/dam_break.pvd", "-o", "a.png"], filter].concat());
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && message.contains(explained), "{message}");
    }
}
