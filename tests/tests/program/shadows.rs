//! What the sun sees is drawn where somebody asks for it, and only when it changes.

use meniscus_tests::{Program, read_json};

use crate::program_with_dam;

const SMALL: &str = "--size 64x36 -q";

/// Names of the passes of the first picture.
fn passes(program: &Program, flags: &str) -> Vec<String> {
    program.run(&format!("render dam -o a.png --frame 0 {SMALL} --report r.json {flags}")).ok();
    let report = read_json(&program.path("r.json"));
    let stages = report["frames"][0]["stages"].as_array().expect("stages").clone();
    stages.iter().filter_map(|stage| stage["name"].as_str().map(str::to_owned)).collect()
}

#[test]
fn the_sun_looks_once_while_the_camera_moves() {
    let program = program_with_dam(3000, 1);
    let looks = |names: &[String], pass: &str| names.iter().filter(|name| *name == pass).count();
    let first = passes(&program, "");
    for pass in ["sun/ssfr.depth", "sun/ssfr.thickness", "sun/shading.caustics", "shading.sunlight"] {
        assert_eq!(looks(&first, pass), 1, "{pass} in {first:?}");
    }
    let bench = program.run("bench dam --frames 2 --size 64x36 --json").ok().json();
    let later = bench["stages"].as_array().expect("stages");
    let later: Vec<String> = later.iter().filter_map(|s| s["name"].as_str().map(str::to_owned)).collect();
    assert!(later.iter().all(|name| !name.starts_with("sun/")), "{later:?}");
    assert_eq!(looks(&later, "shading.sunlight"), 1);
}

#[test]
fn what_nobody_asks_for_is_not_drawn() {
    let program = program_with_dam(3000, 1);
    let is_of_sun = |name: &String| name.starts_with("sun/") || name == "shading.sunlight";
    for flags in ["--param scene.shadows=false", "--lighting vtk", "--sun 90,1"] {
        let names = passes(&program, flags);
        assert!(!names.iter().any(is_of_sun), "{flags}: {names:?}");
    }
    let names = passes(&program, "--param scene.caustics=0");
    assert!(names.iter().any(is_of_sun) && !names.iter().any(|name| name.contains("caustics")), "{names:?}");
    // Objects throw shadows whatever the water is lit by.
    program.write("box.toml", "[[box]]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n");
    let names = passes(&program, "--lighting vtk --scene box.toml");
    assert!(names.iter().any(|name| name == "sun/shading.objects"), "{names:?}");
    assert!(!names.iter().any(|name| name == "sun/ssfr.depth"), "{names:?}");
    let bad =
        program.run(&format!("render dam -o a.png --frame 0 {SMALL} --param scene.caustics=2")).expect(2);
    assert!(bad.stderr.contains("scene.caustics is 2, expected 0 to 1"), "{}", bad.stderr);
}
