//! `--exposure auto`: found once for all pictures of a series.

use meniscus_tests::{Pixels, Program, read_json};

use crate::program_with_dam;

const RENDER: &str = "render dam/dam_break.pvd --size 64x36";

/// The exposure that was chosen, in stops.
fn chosen(program: &Program, flags: &str) -> f64 {
    program.run(&format!("{RENDER} {flags} --report r.json")).ok();
    let report = read_json(&program.path("r.json"));
    let choices = report["choices"].as_array().expect("choices").iter();
    let exposure = choices.filter(|choice| choice["what"] == "exposure").collect::<Vec<_>>();
    let [exposure] = exposure[..] else { panic!("one choice of exposure: {exposure:?}") };
    assert!(exposure["flag"].as_str().is_some_and(|flag| flag.contains("--exposure")), "{exposure}");
    let value = exposure["value"].as_str().expect("a text");
    value.strip_suffix(" stops").and_then(|stops| stops.parse().ok()).expect("a number of stops")
}

fn bytes(program: &Program, folder: &str, number: u32) -> Vec<u8> {
    std::fs::read(program.path(&format!("{folder}/{number}.png"))).expect("a picture")
}

/// No picture depends on who draws it, when, and after which others.
#[test]
fn a_metered_series_is_the_same_in_shards_and_resumed_and_with_the_number() {
    let program = program_with_dam(300, 4);
    let stops = chosen(&program, "--exposure auto -o all/%d.png");
    assert!(stops != 0.0 && stops.abs() < 6.0, "{stops} stops in the automatic scene");
    for shard in [1, 2] {
        program.run(&format!("{RENDER} --exposure auto -o shards/%d.png --shard {shard}/2")).ok();
    }
    program.run(&format!("{RENDER} --param post.exposure={stops} -o number/%d.png")).ok();
    program.run(&format!("{RENDER} --exposure={stops} -o flag/%d.png")).ok();
    let all = [0, 1, 2, 3].map(|number| bytes(&program, "all", number));
    for folder in ["shards", "number", "flag"] {
        for (number, picture) in (0..).zip(&all) {
            let pixels = |folder| Pixels::read(&program.path(&format!("{folder}/{number}.png"))).rgba;
            assert!(pixels(folder) == pixels("all"), "{folder}/{number}.png");
            assert!(!picture.is_empty());
        }
    }
    std::fs::remove_file(program.path("all/2.png")).expect("a picture");
    program.run(&format!("{RENDER} --param post.exposure=auto -o all/%d.png --resume --report r.json")).ok();
    let drawn = read_json(&program.path("r.json"))["frames"].as_array().map(Vec::len);
    assert_eq!(drawn, Some(1), "what is there was metered alike");
    assert!(bytes(&program, "all", 2) == all[2]);
    // What is asked for holds.
    program.run(&format!("{RENDER} --frame 0 -o plain.png")).ok();
    program.run(&format!("{RENDER} --frame 0 --exposure 0 -o zero.png")).ok();
    assert!(Pixels::read(&program.path("plain.png")).rgba == Pixels::read(&program.path("zero.png")).rgba);
}
