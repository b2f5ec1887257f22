//! `convert`: other formats, the same particles.

use serde_json::Value;

use crate::program_with_dam;

/// What `info --stats` says about the data themselves, spelled the same for every format.
fn content(program: &meniscus_tests::Program, input: &str, frame: usize) -> Value {
    let info = program.run(&format!("info {input} --frame {frame} --stats --json")).ok().json();
    let frame = &info["frame"];
    serde_json::json!([
        frame["points"],
        frame["bounds"],
        frame["centroid"],
        frame["attributes"],
        frame["time"]
    ])
}

#[test]
fn every_format_holds_the_same_particles() {
    let program = program_with_dam(600, 1);
    let expected = content(&program, "dam/dam_break_0000.vtu", 0);
    for (name, encodings) in [
        ("o.vtu", "raw zlib lz4 lzma base64 ascii"),
        ("o.vtp", "raw zlib lz4 base64 ascii"),
        ("o.vtk", "raw ascii"),
    ] {
        for encoding in encodings.split(' ') {
            let to = format!("new/{encoding}_{name}");
            program.run(&format!("convert dam/dam_break_0000.vtu -o {to} --encoding {encoding}")).ok();
            assert_eq!(content(&program, &to, 0), expected, "{to}");
        }
    }
}

#[test]
fn a_series_stays_one_with_its_times_and_its_selection() {
    let program = program_with_dam(600, 3);
    program.run("convert dam/dam_break.pvd -o out/w_%03d.vtk --every 4 --frames 1..2").ok();
    assert_eq!(program.list("out"), ["w.pvd", "w_001.vtk", "w_002.vtk"]);
    for (frame, original) in [(0, 1), (1, 2)] {
        let converted = content(&program, "out/w.pvd", frame);
        assert_eq!(converted[0], 150, "every fourth of 600");
        assert_eq!(converted[4], content(&program, "dam/dam_break.pvd", original)[4], "its time");
    }
}

#[test]
fn what_cannot_be_written_is_refused_and_a_bad_frame_is_left_out() {
    let program = program_with_dam(300, 3);
    for (flags, code, words) in [
        ("-o o.xyz", 2, ".vtu, .vtp or .vtk"),
        ("-o o.vtu", 2, "%04d"),
        ("-o o_%s.vtu", 5, "o_%s.vtu"),
        ("-o o_%d.vtk --encoding zlib", 2, "raw or ascii"),
        ("-o dam/dam_break.pvd/o_%d.vtu", 5, "dam_break.pvd"),
        ("-o o_%d.vtu --frames 1..9", 2, "frames 0 to 2"),
    ] {
        let message = program.run(&format!("convert dam/dam_break.pvd {flags}")).expect(code).stderr;
        assert!(message.contains(words), "{flags}: {message}");
    }
    let in_place = "convert 'dam/dam_break_*.vtu' -o dam/dam_break_%04d.vtu --every 2";
    assert!(program.run(in_place).expect(2).stderr.contains("this is the input"));
    let pvd = program.run("convert dam/dam_break.pvd -o dam/dam_break_%d.vtp").expect(2).stderr;
    assert!(pvd.contains("dam_break.pvd: this is the input"), "{pvd}");
    let own = program.run("convert dam/dam_break_0000.vtu -o dam/dam_break_0000.vtu").expect(2).stderr;
    assert!(own.contains("this is the input"), "{own}");
    assert_eq!(program.list(""), ["dam"]);
    program.write("dam/dam_break_0001.vtu", "broken");
    let missing = program.run("convert dam/dam_break.pvd -o o_%d.vtu").expect(3).stderr;
    assert!(missing.contains("1 of 3 frames"), "{missing}");
    assert_eq!(program.list(""), ["dam", "o.pvd", "o_0.vtu", "o_2.vtu"]);
}
