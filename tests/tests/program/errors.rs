//! Errors: the documented exit code, one paragraph for people, and with `--json` the same for machines.

use std::os::unix::net::UnixListener;

use meniscus_tests::Outcome;
use serde_json::Value;

use crate::{program, program_with_dam};

/// One paragraph: no blank line, no trace, and it begins with who speaks.
fn paragraph(outcome: &Outcome) -> &str {
    let text = outcome.stderr.trim_end();
    assert!(text.starts_with("meniscus: ") && !text.contains('\n') && text.len() > 20, "{outcome:#?}");
    text
}

#[test]
fn an_unreadable_input_is_code_3_with_json_and_its_file() {
    let program = program();
    program.write("empty.vtu", "");
    program.write("text.vtk", "once upon a time");
    program.write("folder/readme.txt", "no particles here");
    program.write("cut.vtu", "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\"><Unstruct");
    let _socket = UnixListener::bind(program.path("socket.vtu")).expect("a socket");
    let fifo = std::process::Command::new("mkfifo").arg(program.path("fifo.vtu")).status();
    assert!(fifo.expect("mkfifo").success());
    for (input, kind) in [
        ("missing.vtu", "not_found"),
        ("empty.vtu", "malformed"),
        ("text.vtk", "unsupported"),
        ("folder", "empty"),
        ("cut.vtu", "malformed"),
        ("socket.vtu", "io"),
        ("fifo.vtu", "io"),
        ("'nothing_*.vtu'", "empty"),
    ] {
        let info = program.run(&format!("info {input} --json")).expect(3);
        let name = input.trim_matches('\'');
        assert!(paragraph(&info).contains(name), "{info:#?}");
        let error = &info.json()["error"];
        assert_eq!(error["kind"], kind, "{info:#?}");
        assert_eq!(error["file"], name, "{info:#?}");
        let message = error["message"].as_str().expect("a message");
        assert_eq!(info.stderr.trim_end(), format!("meniscus: {message}"));

        // The other readers of input say the same.
        let render = program.run(&format!("render {input} -o out.png")).expect(3);
        assert_eq!(paragraph(&render), paragraph(&info));
        assert!(!program.path("out.png").exists());
        let bench = program.run(&format!("bench {input} --json")).expect(3);
        assert_eq!(bench.json()["error"]["kind"], kind);
    }
}

#[test]
fn a_wrong_command_line_is_code_2() {
    let program = program_with_dam(300, 2);
    let info = program.run("info dam/dam_break.pvd --frame 2 --json").expect(2);
    assert!(paragraph(&info).contains("0 to 1"), "{info:#?}");
    assert_eq!(info.json()["error"]["kind"], "usage");
    assert_eq!(info.json()["error"]["file"], Value::Null);
    for arguments in
        ["dance", "info", "render dam", "make puddle -o x", "info dam --frame x", "bench dam --frames 0"]
    {
        let outcome = program.run(arguments).expect(2);
        assert!(outcome.stderr.contains("--help") && outcome.stdout.is_empty(), "{outcome:#?}");
    }
    let unknown = program.run("info dam/dam_break.pvd --where 'colour == 1' --json").expect(2);
    let message = paragraph(&unknown);
    assert!(message.contains("colour") && message.contains("pressure"), "{message}");
}

#[test]
fn an_output_that_cannot_be_written_is_code_5_and_leaves_nothing() {
    let program = program_with_dam(300, 2);
    program.write("file", "x");
    program.write("taken.png/inside", "a folder where the picture should go");
    let one = "render dam/dam_break_0000.vtu --size 16x9";
    for output in ["file/out.png", "taken.png", "/proc/out.png", "out.gif", "out"] {
        let outcome = program.run(&format!("{one} -q -o {output}")).expect(5);
        assert!(paragraph(&outcome).contains(output), "{outcome:#?}");
    }
    let several = program.run("render dam/dam_break.pvd --size 16x9 -o out.png").expect(5);
    assert!(paragraph(&several).contains("out_%04d.png"), "{several:#?}");
    let report = program.run(&format!("{one} -q -o out.png --report file/report.json")).expect(5);
    assert!(paragraph(&report).contains("file/report.json"));
    let make = program.run("make dam-break -o file --particles 10 -q").expect(5);
    assert!(paragraph(&make).contains("file"));
    assert_eq!(program.list(""), ["dam", "file", "taken.png"]);
}

#[test]
fn a_damaged_frame_of_a_sequence_is_left_out_and_said() {
    let program = program_with_dam(300, 3);
    program.write("dam/dam_break_0001.vtu", "not a particle file");
    let outcome = program.run("render dam/dam_break.pvd -o o_%d.png --size 16x9 --report r.json").expect(3);
    assert!(outcome.stderr.contains("1 of 3 frames could not be read"), "{outcome:#?}");
    assert_eq!(
        program.list("").iter().filter(|n| n.ends_with(".png")).collect::<Vec<_>>(),
        ["o_0.png", "o_2.png"]
    );
    let report = meniscus_tests::read_json(&program.path("r.json"));
    assert_eq!(report["flaws"][0]["kind"], "frame_missing");
    assert_eq!(report["flaws"][0]["frame"], 1);
}
