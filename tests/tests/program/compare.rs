//! `bench --compare`: ratios, and what makes them worth nothing.

use crate::{program, program_with_dam};

#[test]
fn two_runs_are_compared_and_unlike_ones_marked() {
    let program = program_with_dam(2000, 1);
    let bench = "bench dam/dam_break.pvd --frames 2 --warmup 1 --json";
    program.run(&format!("{bench} --size 64x36 > a.json")).ok();
    program.run(&format!("{bench} --size 32x18 --filter none > b.json")).ok();

    let same = program.run("bench --compare a.json a.json --json").ok().json();
    assert_eq!(same["differences"], serde_json::json!([]));
    let own = meniscus_tests::read_json(&program.path("a.json"));
    let names = |stages: &serde_json::Value| -> Vec<String> {
        let stages = stages.as_array().expect("stages").iter();
        stages.map(|stage| stage["name"].as_str().expect("a name").to_owned()).collect()
    };
    assert_eq!(names(&same["stages"]), names(&own["stages"]), "the report's stages, in its order");
    for pair in same["whole_frame"].as_array().expect("clocks") {
        assert_eq!((&pair["ratio"], &pair["overlap"]), (&1.0.into(), &true.into()), "{pair}");
    }

    let unlike = program.run("bench --compare a.json b.json --json").ok().json();
    let keys: Vec<_> =
        unlike["differences"].as_array().expect("a list").iter().map(|d| d["key"].as_str()).collect();
    for key in ["size", "settings.surface.filter.name"] {
        assert!(keys.contains(&Some(key)), "{key} in {keys:?}");
    }
    assert!(!keys.contains(&Some("adapter")) && !keys.contains(&Some("particles")), "{keys:?}");
    let wall = |side: &str| {
        let clocks = unlike["whole_frame"].as_array().expect("clocks");
        let clock = clocks.iter().find(|clock| clock["clock"] == "wall_ms").expect("wall time");
        clock.pointer(side).and_then(serde_json::Value::as_f64).expect("a number")
    };
    // Numbers read from JSON are right but for their last bits.
    let ratio = wall("/b/median") / wall("/a/median");
    assert!((wall("/ratio") / ratio - 1.0).abs() < 1e-12, "{ratio}");
    let text = program.run("bench --compare a.json b.json").ok().stdout;
    for words in
        ["set up differently", "size: [64,36] in A, [32,18] in B", "whole frame", "ssfr.smooth_along"]
    {
        assert!(text.contains(words), "{words} in\n{text}");
    }
}

#[test]
fn reports_of_render_are_compared_too() {
    let program = program_with_dam(500, 2);
    program.run("render dam -o o_%d.png --size 32x18 --report r.json").ok();
    let same = program.run("bench --compare r.json r.json --json").ok().json();
    assert_eq!(same["differences"], serde_json::json!([]));
    assert!(same["stages"].to_string().contains("ssfr.depth"), "{same}");
    program.run("bench dam --size 32x18 --frames 1 --json > b.json").ok();
    let mixed = program.run("bench --compare r.json b.json --json").ok().json();
    assert!(!mixed["differences"].to_string().contains("adapter"), "{mixed}");
}

#[test]
fn what_is_no_run_is_refused_by_name() {
    let program = program();
    program.write("text.json", "not JSON");
    program.write("other.json", "{\"hello\": 1}");
    program.write("bent.json", "{\"stages\": [{\"name\": \"a\", \"gpu_ms\": \"fast\"}]}");
    for (file, words) in [
        ("none.json", "cannot be read"),
        ("text.json", "expected JSON"),
        ("other.json", "an object with hello"),
        ("bent.json", "stages[0].gpu_ms: expected"),
    ] {
        let outcome = program.run(&format!("bench --compare {file} {file} --json")).expect(3);
        assert!(outcome.stderr.contains(words) && outcome.stderr.contains(file), "{}", outcome.stderr);
        assert!(outcome.json()["error"]["file"].as_str().is_some_and(|f| f.contains(file)));
    }
    for wrong in ["bench", "bench --compare a.json", "bench x.vtu --compare a.json b.json"] {
        let _ = program.run(wrong).expect(2);
    }
}
