//! What is written over pictures.

use meniscus_tests::{Pixels, Program};

use crate::program_with_dam;

fn picture(program: &Program, flags: &str) -> Pixels {
    program.run(&format!("render dam/dam_break.pvd --size 320x180 --lod 0.5 {flags} -o p.png")).ok();
    Pixels::read(&program.path("p.png"))
}

/// First and last column, first and last row in which two pictures differ.
fn difference(a: &Pixels, b: &Pixels) -> Option<[u32; 4]> {
    let differs = |i: &u32| a.rgba[*i as usize] != b.rgba[*i as usize];
    let pixels = || (0..a.rgba.len() as u32).filter(differs);
    let (columns, rows) = (|| pixels().map(|i| i % a.size[0]), || pixels().map(|i| i / a.size[0]));
    Some([columns().min()?, columns().max()?, rows().min()?, rows().max()?])
}

#[test]
fn overlays_are_written_in_their_corners_and_nowhere_else() {
    let program = program_with_dam(2000, 3);
    let plain = picture(&program, "--frame 1 --color-by velocity");
    let drawn = |flags: &str| {
        let with = picture(&program, &format!("--frame 1 --color-by velocity {flags}"));
        difference(&plain, &with).unwrap_or_else(|| panic!("{flags} draws nothing"))
    };
    let [left, right, top, bottom] = drawn("--overlay time");
    assert!(left < 20 && right < 160 && top < 20 && bottom < 40);
    assert!(drawn("--overlay time --text Dam")[3] > bottom, "the time is under the text");
    let [left, right, ..] = drawn("--overlay legend");
    assert!(left > 160 && right < 320);
    let [left, right, top, bottom] = drawn("--overlay scale");
    assert!(left < 20 && right < 160 && top > 120 && bottom < 180);
    // Another picture, another time.
    let times = [0, 2].map(|frame| picture(&program, &format!("--frame {frame} --overlay time")));
    let plain = [0, 2].map(|frame| picture(&program, &format!("--frame {frame}")));
    assert_ne!(times[0].rgba[..320 * 40], times[1].rgba[..320 * 40]);
    assert!(difference(&plain[0], &times[0]).is_some());
}

#[test]
fn a_scale_bar_is_as_long_as_it_says() {
    let program = program_with_dam(2000, 1);
    let flags = "--view front --ortho 4 --unit m";
    let (plain, with) = (picture(&program, flags), picture(&program, &format!("{flags} --overlay scale")));
    // 180 pixels for 4 m: the largest round length in a quarter of the width, 80 pixels, is 1 m, 45 pixels. The label is
    // shorter, the halo is two pixels wide at either end.
    let [left, right, ..] = difference(&plain, &with).expect("a bar");
    assert_eq!(right - left + 1, 45 + 4);
}

#[test]
fn what_cannot_be_written_is_said() {
    let program = program_with_dam(300, 2);
    for (flags, code, words) in [
        ("-o p.png --overlay legend", 2, "--color-by"),
        ("-o p.png --overlay text", 2, "--text"),
        ("-o p.png --overlay time,date", 2, "date"),
        ("-o p.exr --overlay time", 5, "linear radiance is not written on"),
    ] {
        let outcome = program.run(&format!("render dam --frame 0 --size 64x36 {flags}")).expect(code);
        assert!(outcome.stderr.contains(words), "{flags}: {outcome:#?}");
    }
}

#[test]
fn pictures_with_other_words_are_not_taken_for_done() {
    let program = program_with_dam(300, 2);
    let render = |flags: &str| {
        program.run(&format!("render dam -o r_%d.png --size 64x36 --resume {flags}")).ok();
        Pixels::read(&program.path("r_1.png"))
    };
    let first = render("--text one");
    assert!(difference(&first, &render("--text two")).is_some());
}
