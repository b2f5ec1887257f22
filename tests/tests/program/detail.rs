//! `--lod auto`, rates, and the pictures of what level of detail decided.

use meniscus_tests::{Pixels, read_json};

use crate::program_with_dam;

const CAMERA: &str = "--camera 2.4,-1.6,1.2/0.6,0.5,0.2/0,0,1/40 --size 480x270";

#[test]
fn automatic_detail_draws_the_same_picture_with_less() {
    let program = program_with_dam(60_000, 1);
    let draw = |name: &str, flags: &str| {
        let command = format!("render dam/dam_break.pvd -o {name}.png {CAMERA} {flags} --report {name}.json");
        program.run(&command).ok();
        let report = read_json(&program.path(&format!("{name}.json")));
        (Pixels::read(&program.path(&format!("{name}.png"))), report["frames"][0]["counters"].clone())
    };
    let (full, all) = draw("full", "--lod 1");
    let (auto, less) = draw("auto", "--lod auto");
    // A step of 8 bits here and there.
    assert!(full.mean_difference(&auto) < 0.5, "{}", full.mean_difference(&auto));
    let of = |counters: &serde_json::Value, name: &str| counters[name].as_u64().expect("a counter");
    assert_eq!(of(&all, "stand_ins"), 0);
    assert!(of(&less, "stand_ins") > 100, "{less}");
    assert!(of(&all, "particles_tested") > 10_000, "{all}");
    assert_eq!(of(&all, "splat_pixels_depth"), of(&less, "splat_pixels_depth"), "the same surface");
}

#[test]
fn a_rate_is_held_by_bench_and_refused_by_render() {
    let program = program_with_dam(5000, 1);
    let message = program.run("render dam/dam_break.pvd -o a.png --lod 30fps").expect(2).stderr;
    assert!(message.contains("30fps") && message.contains("auto"), "{message}");
    let bench = |rate: &str| {
        let command = format!("bench dam/dam_break.pvd {CAMERA} --frames 25 --warmup 0 --json --lod {rate}");
        let report: serde_json::Value =
            serde_json::from_str(&program.run(&command).ok().stdout).expect("a report");
        report["kept"].as_u64().expect("a number")
    };
    // No machine draws a million pictures a second, and all draw one in a thousand.
    assert!(bench("1000000fps") < bench("0.001fps"), "detail has to give way");
}

#[test]
fn what_was_decided_can_be_seen() {
    let program = program_with_dam(20_000, 1);
    let show = |view: &str, camera: &str, flags: &str| {
        let command = format!("render dam/dam_break.pvd -o {view}.png {camera} --show {view} {flags}");
        program.run(&command).ok();
        Pixels::read(&program.path(&format!("{view}.png")))
    };
    let count = |picture: &Pixels, colour: [u8; 3]| {
        let near = |p: &&[u8; 4]| p[..3].iter().zip(colour).all(|(a, b)| a.abs_diff(b) < 40);
        picture.rgba.iter().filter(near).count()
    };
    let (yellow, violet) = ([240, 220, 60], [80, 20, 90]);
    let all = show("lod-kept", CAMERA, "--lod 1");
    let few = show("lod-kept", CAMERA, "--lod 0.02");
    assert!(count(&all, yellow) > 1000 && count(&all, violet) == 0);
    assert!(count(&few, yellow) < 100 && count(&few, violet) > 1000);
    assert!(show("lod-chunks", CAMERA, "").colours() > 30);
    // From afar: where particles are many pixels apart nothing stands in for them.
    let far = "--camera 7.8,-5.8,3.2/0.6,0.5,0.2/0,0,1/40 --size 480x270";
    assert!(show("lod-levels", far, "--lod auto") != show("lod-levels", far, "--lod 1"));
    // The camera sees the middle of the water: what is beside it is red in the map, what it sees is green.
    let map = show("lod-culled", "--camera 0.6,-0.5,0.5/0.6,0.5,0.2/0,0,1/20 --size 480x270", "");
    assert!(count(&map, [191, 51, 38]) > 100 && count(&map, [51, 179, 77]) > 100);
}
