//! `render --report`: everything that a picture says about itself.

use meniscus_tests::read_json;

use crate::program_with_dam;

#[test]
fn the_report_is_complete() {
    let program = program_with_dam(3000, 3);
    program.run("render dam/dam_break.pvd -o o_%d.png --size 96x54 --frames 1..2 --report r.json").ok();
    let report = read_json(&program.path("r.json"));
    for key in ["/version", "/adapter/name", "/adapter/driver", "/settings/surface/filter/name"] {
        assert!(report.pointer(key).is_some_and(|v| v.as_str().is_some_and(|s| !s.is_empty())), "{key}");
    }
    assert_eq!(report["size"], serde_json::json!([96, 54]));
    for key in ["eye", "target", "up", "projection"] {
        assert!(!report["camera"][key].is_null(), "{key}");
    }
    for key in ["origin", "spacing", "spacing_source", "radius", "up"] {
        assert!(!report["space"][key].is_null(), "{key}");
    }
    assert_eq!(report["flaws"], serde_json::json!([]), "nothing is wrong with made data");
    let frames = report["frames"].as_array().expect("frames");
    assert_eq!(frames.iter().map(|f| f["frame"].as_u64()).collect::<Vec<_>>(), [Some(1), Some(2)]);
    let times: Vec<f64> = frames.iter().filter_map(|frame| frame["time"].as_f64()).collect();
    assert!(times.len() == 2 && 0.0 < times[0] && times[0] < times[1], "{times:?}");
    for (number, frame) in frames.iter().enumerate() {
        assert_eq!(frame["counters"]["particles"], 3000);
        assert!(frame["counters"]["particles_kept"].as_u64() <= Some(3000));
        let stages = frame["stages"].as_array().expect("stages");
        let names: Vec<&str> = stages.iter().filter_map(|s| s["name"].as_str()).collect();
        let count = |name: &str| names.iter().filter(|n| **n == name).count();
        // The camera stands still: what the first picture shows of the scene is there.
        assert_eq!(count("shading.background"), usize::from(number == 0), "{names:?}");
        for name in [
            "ssfr.depth",
            "ssfr.thickness",
            "ssfr.smooth_along",
            "ssfr.normal",
            "shading.fluid",
            "compositor.tone_map",
        ] {
            assert_eq!(count(name), 1, "{name} once in {names:?}");
        }
        for stage in stages {
            // What is not believed is left out: a zero would be read as fast.
            if report["device"]["time_stamps_believed"] == false {
                assert!(stage["gpu_ms"].is_null(), "{stage}");
            }
            let clocks = ["gpu_ms", "wall_ms"].map(|clock| stage[clock].as_f64());
            assert!(clocks.iter().flatten().any(|ms| *ms > 0.0), "a time for {stage}");
        }
    }
}

/// A pass that did not run is absent, not zero.
#[test]
fn passes_that_do_not_run_are_absent() {
    let program = program_with_dam(500, 1);
    program.run("render dam -o a.png --frame 0 --size 32x18 --filter none --report r.json").ok();
    let stages = read_json(&program.path("r.json"))["frames"][0]["stages"].to_string();
    assert!(stages.contains("\"ssfr.depth\"") && !stages.contains("\"ssfr.smooth_along\""), "{stages}");
}

#[test]
fn an_empty_picture_says_why() {
    let program = program_with_dam(500, 1);
    for (flags, reason) in [("--camera 0.6,0.5,3/0.6,0.5,5/0,1,0/40", "--camera"), ("--lod 0", "--lod")] {
        program.run(&format!("render dam -o a.png --frame 0 --size 32x18 {flags} --report r.json")).ok();
        let report = read_json(&program.path("r.json"));
        let flaws = report["frames"][0]["flaws"].as_array().expect("flaws");
        let flaw = flaws
            .iter()
            .find(|f| f["kind"] == "nothing_visible")
            .unwrap_or_else(|| panic!("{flags}: {report}"));
        assert!(flaw["reason"].as_str().expect("words").contains(reason), "{flags}: {flaw}");
    }
}

#[test]
fn level_of_detail_keeps_its_share_of_what_is_visible() {
    let program = program_with_dam(40_000, 1);
    let counts = |flags: &str| {
        program.run(&format!("render dam -o a.png --frame 0 --size 64x36 --report r.json {flags}")).ok();
        let particles = read_json(&program.path("r.json"))["frames"][0]["counters"].clone();
        ["particles", "particles_kept"].map(|key| particles[key].as_f64().expect("a number"))
    };
    assert_eq!(counts(""), [40_000.0; 2]);
    let [input, kept] = counts("--lod 0.3");
    assert_eq!(input, 40_000.0);
    // All of it is visible. 40,000 throws deviate by 0.0023; 2 % of 0.3 is 0.006.
    assert!((kept / input / 0.3 - 1.0).abs() < 0.02, "{kept}");
    // A camera that sees a part of it draws less, at full detail too.
    let [input, kept] = counts("--camera 0.1,-0.5,0.3/0.1,0,0.3/0,0,1/10");
    assert!(kept < input && kept > 0.0, "{kept} of {input}");
}

/// Cameras are said in the file's own coordinates, in the report and in the flag that is printed for them.
#[test]
fn a_camera_is_where_the_file_says_and_can_be_given_back() {
    let program = crate::program();
    program.run("make fjord-tsunami -o fjord --particles 3000 --frames 1").ok();
    let render = "render fjord --frame 0 -o a.png --size 64x36 --report r.json";
    let eye_and_choice = |flags: &str| {
        program.run(&format!("{render} {flags}")).ok();
        let report = read_json(&program.path("r.json"));
        assert_eq!(report["frames"][0]["flaws"], serde_json::json!([]), "{flags}");
        let eye: Vec<f64> =
            report["camera"]["eye"].as_array().expect("an eye").iter().filter_map(|c| c.as_f64()).collect();
        let choices = report["choices"].as_array().expect("choices");
        let choice = choices.iter().find(|choice| choice["what"] == "camera");
        (eye, choice.map(|choice| choice["value"].as_str().expect("a value").to_owned()))
    };
    let (eye, choice) = eye_and_choice("");
    // The fjord lies around (500 km, 3400 km) and is a few kilometres long.
    assert!((eye[0] - 5e5).abs() < 5e4 && (eye[1] - 3.4e6).abs() < 5e4, "{eye:?}");
    let (again, _) = eye_and_choice(&format!("--camera {}", choice.expect("the automatic camera")));
    // Six decimals are printed, and f32 keeps a millimetre or so of some kilometres.
    assert!(eye.iter().zip(&again).all(|(a, b)| (a - b).abs() < 0.01), "{eye:?} {again:?}");
}

#[test]
fn parallel_projection_is_as_high_as_asked() {
    let program = program_with_dam(500, 1);
    program.run("render dam -o a.png --frame 0 --size 32x18 --ortho 2.5 --report r.json").ok();
    let projection = read_json(&program.path("r.json"))["camera"]["projection"].clone();
    assert_eq!(projection, serde_json::json!({"orthographic": {"height_world": 2.5}}));
}
