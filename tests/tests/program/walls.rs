//! Walls in the same file as the water are not drawn as water, and that is said.

use meniscus_tests::{data_dir, read_json};

use crate::program;

#[test]
fn walls_are_left_out_with_a_flag_that_shows_them() {
    let Some(data) = data_dir() else { return };
    let program = program();
    let render = format!(
        "render '{}' --frame 3 --size 64x36 --report r.json -o a.png",
        data.join("pysph_dam_break/dam.pvd").display()
    );
    let bare = program.run(&render).ok();
    let report = read_json(&program.path("r.json"));
    assert_eq!(report["flaws"], serde_json::json!([]));
    assert_eq!(report["frames"][0]["counters"]["particles_kept"], 7128, "the fluid particles of the example");
    let choices = report["choices"].as_array().expect("choices");
    let walls = choices.iter().find(|choice| choice["what"] == "walls").expect("a choice");
    let flag = walls["flag"].as_str().expect("a flag");
    assert!(bare.stderr.contains(flag), "printed as well: {}", bare.stderr);

    // Pasted as it was printed.
    program.run(&format!("{render} {flag}")).ok();
    let report = read_json(&program.path("r.json"));
    assert_eq!(report["frames"][0]["counters"]["particles"], 7128 + 10_432);
}

#[test]
fn hidden_sets_are_not_drawn() {
    let Some(data) = data_dir() else { return };
    let program = program();
    let input = data.join("pysph_dam_break/dam.pvd");
    let sets = "--set 'water=type == 0' --set 'walls=type in (1, 2):hidden'";
    program
        .run(&format!("render '{}' --frame 3 --size 64x36 --report r.json -o a.png {sets}", input.display()))
        .ok();
    assert_eq!(read_json(&program.path("r.json"))["frames"][0]["counters"]["particles"], 7128);
}
