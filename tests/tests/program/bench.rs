//! `bench`: numbers that scripts read.

use serde_json::Value;

use crate::program_with_dam;

#[test]
fn bench_json_has_the_documented_keys() {
    let program = program_with_dam(2000, 1);
    let bench = "bench dam/dam_break.pvd --size 96x54 --frames 3 --warmup 1";
    let outcome = program.run(&format!("{bench} --json")).ok();
    let json = outcome.json();
    for key in ["adapter", "driver"] {
        assert!(json[key].as_str().is_some_and(|text| !text.is_empty()), "{json}");
    }
    assert_eq!((&json["particles"], &json["kept"]), (&2000.into(), &2000.into()));
    let covered = json["covered_fraction"].as_f64().expect("a number");
    assert!(covered > 0.05 && covered < 0.9, "{covered}");
    assert!(json["peak_bytes"].as_u64().is_some_and(|bytes| bytes > 96 * 54 * 4));
    for key in ["version", "device", "camera", "space", "settings", "threads", "unix_time_s", "input"] {
        assert!(!json[key].is_null(), "{key}");
    }
    assert_eq!((&json["pictures"], &json["series_frame"]), (&3.into(), &0.into()));
    assert!(json["warmup_pictures"].as_u64() >= Some(1) && json["first_picture_ms"].as_f64() > Some(0.0));
    for key in ["read_ms", "prepare_ms"] {
        check_spread(&json[key]);
    }
    for clock in ["wall_ms", "cpu_ms"] {
        check_spread(&json["frame"][clock]);
    }
    // A driver whose time stamps are wrong gives none; a clock is never zero.
    if !json["frame"]["gpu_ms"].is_null() {
        check_spread(&json["frame"]["gpu_ms"]);
    }
    let stages = json["stages"].as_array().expect("stages");
    for stage in stages {
        let [wall, cpu] = ["wall_ms", "cpu_ms"].map(|clock| stage[clock]["min"].as_f64().unwrap_or(-1.0));
        assert!(wall > 0.0 && cpu >= 0.0, "{stage}");
    }
    for name in ["ssfr.depth", "ssfr.thickness", "ssfr.normal", "shading.fluid"] {
        assert_eq!(stages.iter().filter(|stage| stage["name"] == name).count(), 1, "{name} once");
    }
    let text = program.run(bench).ok().stdout;
    for words in ["2000 particles", "ssfr.depth", "reading", "preparing", "first picture", "share"] {
        assert!(text.contains(words), "{words} in\n{text}");
    }
}

fn check_spread(spread: &Value) {
    let [min, median, max] = ["min", "median", "max"].map(|key| spread[key].as_f64().expect("a number"));
    assert!(0.0 < min && min <= median && median <= max, "{spread}");
}

#[test]
fn level_of_detail_shows_in_the_counts() {
    let program = program_with_dam(4000, 1);
    let bench = "bench dam/dam_break.pvd --size 32x18 --frames 1 --warmup 0 --json --lod";
    let json = program.run(&format!("{bench} 0.5")).ok().json();
    let kept = json["kept"].as_f64().expect("a number") / 4000.0;
    // Each of 4000 particles is kept or not: a deviation of 0.008, of which 0.05 is six.
    assert!((kept - 0.5).abs() < 0.05, "{kept}");
}
