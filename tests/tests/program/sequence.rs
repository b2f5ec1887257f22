//! Sequences: which frames, under which names.

use crate::program_with_dam;

#[test]
fn frames_are_numbered_as_in_the_series() {
    let program = program_with_dam(200, 12);
    let pictures = |flags: &str| {
        program.run(&format!("render dam/dam_break.pvd --size 8x8 -q {flags}")).ok();
        let made: Vec<String> = program.list("").into_iter().filter(|name| name != "dam").collect();
        made.iter().for_each(|name| std::fs::remove_file(program.path(name)).expect("a picture"));
        made.join(" ")
    };
    assert_eq!(pictures("-o o_%04d.png --frames 9..10"), "o_0009.png o_0010.png");
    assert_eq!(pictures("-o o_%d.png --frames 10.."), "o_10.png o_11.png");
    assert_eq!(pictures("-o %02dx.PNG --frames ..1"), "00x.PNG 01x.PNG");
    assert_eq!(pictures("-o 100%%_%d.png --frames 3..3"), "100%_3.png");
    assert_eq!(pictures("-o o_%03d.png --frame 7"), "o_007.png");
    assert_eq!(pictures("-o o.png --frame 11"), "o.png");
    assert_eq!(pictures("-o o%d.png").split(' ').count(), 12);
    for wrong in ["-o %s.png", "-o %04x.png", "-o %d_%d.png"] {
        let _ = program.run(&format!("render dam/dam_break.pvd --size 8x8 {wrong}")).expect(5);
    }
    assert_eq!(program.list(""), ["dam"]);
}

#[test]
fn missing_folders_are_made_and_old_pictures_replaced() {
    let program = program_with_dam(200, 2);
    program.write("new/deep/o_0.png", "an older picture");
    program.run("render dam/dam_break.pvd --size 8x8 -o new/deep/o_%d.png").ok();
    program.run("render dam/dam_break.pvd --size 8x8 -o other/o_%d.png").ok();
    assert_eq!(program.list("new/deep"), ["o_0.png", "o_1.png"]);
    assert_eq!(
        std::fs::read(program.path("new/deep/o_0.png")).expect("a picture"),
        std::fs::read(program.path("other/o_0.png")).expect("a picture")
    );
}

/// What is kept from one frame to the next (buffers, selections, images) never shows.
#[test]
fn a_frame_of_a_sequence_is_the_frame_drawn_alone() {
    let program = program_with_dam(3000, 4);
    program.run("render dam/dam_break.pvd --size 64x36 -o s_%d.png").ok();
    let bytes = |name: String| std::fs::read(program.path(&name)).expect("a picture");
    for frame in 0..4 {
        program.run(&format!("render dam/dam_break.pvd --size 64x36 -o alone.png --frame {frame}")).ok();
        assert!(bytes(format!("s_{frame}.png")) == bytes("alone.png".into()), "frame {frame}");
    }
    assert!(bytes("s_0.png".into()) != bytes("s_3.png".into()), "the water moves");
}

/// Everything that a series can be given as gives the same pictures.
#[test]
fn a_series_is_a_series_by_any_name() {
    let program = program_with_dam(200, 3);
    let bytes = |input: &str| {
        program.run(&format!("render {input} --size 16x9 -o o.png --frame 2")).ok();
        std::fs::read(program.path("o.png")).expect("a picture")
    };
    let expected = bytes("dam/dam_break.pvd");
    for input in ["dam", "'dam/dam_break_*.vtu'", "dam/dam_break_%04d.vtu"] {
        assert!(bytes(input) == expected, "{input}");
    }
}

#[test]
fn quiet_is_quiet() {
    let program = program_with_dam(200, 1);
    let quiet = program.run("render dam -o a.png --frame 0 --size 8x8 --quiet").ok();
    assert_eq!((quiet.stdout.as_str(), quiet.stderr.as_str()), ("", ""));
    let loud = program.run("render dam -o a.png --frame 0 --size 8x8").ok();
    assert!(loud.stderr.contains("a.png") && loud.stdout.is_empty(), "{loud:#?}");
}
