//! Ctrl-C and its relatives leave no half file.

use meniscus_tests::{Pixels, Program};
use rustix::process::{Pid, Signal, kill_process};

use crate::{program, program_with_dam};

/// Starts a long sequence, waits for a picture and sends the signal; the exit code and the names of what is there then.
fn interrupted(program: &Program, signal: Signal) -> (Option<i32>, Vec<String>) {
    let render = "render dam/dam_break.pvd -o out/o_%04d.png --size 320x180 --report r.json";
    let mut running = program.start(render, &[]);
    running.wait_for(&program.path("out/o_0000.png"));
    kill_process(Pid::from_raw(running.id() as i32).expect("a process"), signal).expect("a signal");
    (running.finish().code, program.list("out"))
}

#[test]
fn an_interrupted_sequence_leaves_whole_pictures_and_nothing_else() {
    for signal in [Signal::INT, Signal::TERM] {
        let program = program_with_dam(2000, 100);
        let (code, names) = interrupted(&program, signal);
        assert_eq!(code, Some(130), "{signal:?}");
        let report = meniscus_tests::read_json(&program.path("r.json"));
        assert_eq!(
            report["frames"].as_array().map(Vec::len),
            Some(names.len()),
            "a report on what was drawn"
        );
        assert!(!names.is_empty() && names.len() < 100, "stopped on the way: {}", names.len());
        for name in &names {
            assert!(name.ends_with(".png"), "{name} was left behind");
            assert_eq!(Pixels::read(&program.path(&format!("out/{name}"))).size, [320, 180]);
        }
    }
}

/// Nobody can clean up after this one, but nothing half done has a final name.
#[test]
fn a_killed_sequence_has_no_half_picture_under_a_final_name() {
    let program = program_with_dam(2000, 100);
    let (code, names) = interrupted(&program, Signal::KILL);
    assert_eq!(code, None);
    for name in names.iter().filter(|name| !name.starts_with('.')) {
        assert_eq!(Pixels::read(&program.path(&format!("out/{name}"))).size, [320, 180]);
    }
}

#[test]
fn interrupted_making_leaves_whole_frames() {
    let program = program();
    let mut running = program.start("make dam-break -o d --particles 100000 --frames 500", &[]);
    running.wait_for(&program.path("d/dam_break_0000.vtu"));
    kill_process(Pid::from_raw(running.id() as i32).expect("a process"), Signal::INT).expect("a signal");
    assert_eq!(running.finish().code, Some(130));
    let names = program.list("d");
    assert!(!names.is_empty() && names.len() < 500);
    let size = |name: &str| std::fs::metadata(program.path(&format!("d/{name}"))).expect("a file").len();
    for name in &names {
        assert!(name.ends_with(".vtu"), "{name} was left behind");
        // Frames differ in nothing that changes their length by more than the digits of the time.
        assert!(size(name).abs_diff(size(&names[0])) < 64, "{name} is cut off");
    }
}
