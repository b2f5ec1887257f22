//! Which particles of the input are taken, and when they are.

use crate::{program, program_with_dam};

/// Points of the water of a frame, as `info` counts them.
fn water(program: &meniscus_tests::Program, flags: &str) -> u64 {
    let json = program.run(&format!("info dam/dam_break.pvd --json {flags}")).ok().json();
    json["frame"]["sets"][0]["points"].as_u64().unwrap_or_else(|| panic!("{json}"))
}

#[test]
fn every_nth_and_a_box_take_their_share() {
    let program = program_with_dam(4000, 1);
    assert_eq!(water(&program, ""), 4000);
    assert_eq!(water(&program, "--every 1"), 4000);
    assert_eq!(water(&program, "--every 4"), 1000);
    assert_eq!(water(&program, "--box=,,,,,"), 4000);
    // Two halves at a plane that no jittered particle lies on make the whole.
    let halves = ["--box=,0.3000001,,,,", "--box=0.3000001,,,,,"].map(|flags| water(&program, flags));
    assert_eq!(halves[0] + halves[1], 4000);
    assert!(halves.iter().all(|&half| half > 0), "{halves:?}");
    assert!(water(&program, "--box=,0.3000001,,,, --every 2") < halves[0]);
}

#[test]
fn the_selection_is_what_is_drawn() {
    let program = program_with_dam(4000, 1);
    let kept = |flags: &str| {
        let bench = format!("bench dam/dam_break.pvd --size 32x18 --frames 1 --warmup 0 --json {flags}");
        program.run(&bench).ok().json()["particles"].as_u64()
    };
    assert_eq!((kept(""), kept("--every 4")), (Some(4000), Some(1000)));
}

#[test]
fn times_follow_the_step() {
    let program = program_with_dam(300, 3);
    program.run("render dam/dam_break.pvd -o o_%d.png --size 8x8 --dt 0.25 --report r.json").ok();
    let report = meniscus_tests::read_json(&program.path("r.json"));
    let times: Vec<_> =
        report["frames"].as_array().expect("frames").iter().map(|frame| frame["time"].as_f64()).collect();
    assert_eq!(times, [Some(0.0), Some(0.25), Some(0.5)]);
}

#[test]
fn selections_that_make_no_sense_are_refused() {
    let program = program();
    for (flags, words) in [
        ("--every 0", "--every"),
        ("--every half", "--every"),
        ("--box 0,1,0,1", "six numbers"),
        ("--box=1,0,0,1,0,1", "lower limit above"),
        ("--dt -1", "positive"),
        ("--io mmap", "auto, map or read"),
    ] {
        let message = program.run(&format!("info none.vtu {flags}")).expect(2).stderr;
        assert!(message.contains(words), "{flags}: {message}");
    }
}

/// However files come into memory, they hold the same, and the choice is printed.
#[test]
fn every_way_of_reading_gives_the_same_picture() {
    let program = program_with_dam(2000, 1);
    let draw = |flags: &str| {
        let outcome =
            program.run(&format!("render dam -o o.png --frame 0 --size 64x36 --report r.json {flags}"));
        let picture = std::fs::read(program.path("o.png")).expect("a picture");
        (picture, outcome.ok().stderr, meniscus_tests::read_json(&program.path("r.json")))
    };
    // Made a moment ago: not at rest.
    let (auto, said, report) = draw("");
    assert!(said.contains("read in blocks") && said.contains("--io"), "{said}");
    assert!(report["choices"].to_string().contains("--io"), "{report}");
    for flags in ["--io map", "--io read"] {
        let (picture, said, _) = draw(flags);
        assert!(picture == auto, "{flags}");
        assert!(!said.contains("--io"), "{flags} was asked for: {said}");
    }
}

/// A parallel file of more pieces than the shell allows open files, each of them longer than what is looked at to open it.
#[cfg(unix)]
#[test]
fn more_pieces_than_the_shell_allows_open_files() {
    let program = program_with_dam(4000, 1);
    let piece = "<Piece Source='dam/dam_break_0000.vtu'/>";
    let file = format!(
        "<VTKFile type='PUnstructuredGrid'><PUnstructuredGrid>{}</PUnstructuredGrid></VTKFile>",
        piece.repeat(200)
    );
    program.write("many.pvtu", file);
    let outcome = std::process::Command::new("sh")
        .args(["-c", "ulimit -Sn 64; exec \"$0\" info many.pvtu --io read --json"])
        .arg(env!("CARGO_BIN_EXE_meniscus-under-test"))
        .current_dir(program.path(""))
        .output()
        .expect("a shell");
    let said = String::from_utf8_lossy(&outcome.stderr).into_owned();
    let info: serde_json::Value =
        serde_json::from_slice(&outcome.stdout).unwrap_or_else(|_| panic!("{said}"));
    let pieces = info["frame"]["points"].as_u64().expect("a number") / water(&program, "");
    assert_eq!(pieces, 200, "{said}");
}
