//! What every picture has in common: the right way up, framed, closed, drawn everywhere.

use meniscus_tests::{Mask, Pixels, Program, data_dir};

use crate::program_with_dam;

const SIZE: &str = "--size 320x180";

/// The pictures of frames of a series and, drawn again without surroundings, where they show water.
fn pictures(program: &Program, input: &str, frames: &[usize]) -> Vec<(Pixels, Mask)> {
    let draw = |frame: usize, flags: &str| {
        program.run(&format!("render {input} --frame {frame} {SIZE} -o p.png {flags}")).ok();
        Pixels::read(&program.path("p.png"))
    };
    let alone = "--param post.transparent=true --param scene.floor=false";
    frames.iter().map(|&frame| (draw(frame, ""), Mask::of_alpha(&draw(frame, alone)))).collect()
}

/// For first, middle and last frame of a series, in one fixed view.
fn check_framed_and_drawn(pictures: &[(Pixels, Mask)]) {
    for (index, (picture, mask)) in pictures.iter().enumerate() {
        assert_eq!(picture.black_share(), 0.0, "{index}");
        assert!(picture.colours() > 500, "{index}: {} colours", picture.colours());
        assert!(picture.rgba.iter().all(|p| p[3] == 255), "opaque");
        let bounds = mask.bounds().expect("water");
        // The automatic camera leaves a margin around the particles of 8 % of the picture; splats reach into it.
        let [left, right, top, bottom] = bounds;
        assert!(left > 0.01 && right < 0.99 && top > 0.01 && bottom < 0.99, "{index}: {bounds:?}");
        // Water that the picture is about, with something around it.
        assert!(mask.share() > 0.05 && mask.share() < 0.8, "{index}: {}", mask.share());
    }
    // Together the frames use the picture: nobody should have to zoom in.
    let reach = |axis: usize| {
        let sides = pictures.iter().filter_map(|(_, mask)| mask.bounds());
        sides.fold(0.0, |reach: f64, b| reach.max(b[2 * axis + 1] - b[2 * axis]))
    };
    assert!(reach(0) > 0.6 || reach(1) > 0.6, "{} x {}", reach(0), reach(1));
}

#[test]
fn a_made_dam_break() {
    let program = program_with_dam(20_000, 3);
    let pictures = pictures(&program, "dam/dam_break.pvd", &[0, 1, 2]);
    check_framed_and_drawn(&pictures);
    // The column before it collapses is a solid body: a single pixel that shows what is behind it is a hole.
    assert_eq!(pictures[0].1.hole_share(), 0.0);
    // The water falls, so in a still camera its picture sinks; upside down, it would rise.
    let rows = [0, 2].map(|frame: usize| pictures[frame].1.mean_row());
    assert!(rows[1] > rows[0] + 0.02, "{rows:?}");
}

/// From the front the horizon is in the picture: smooth sky above it, tiles below.
#[test]
fn the_sky_is_above_and_the_floor_below() {
    let program = program_with_dam(500, 1);
    program.run(&format!("render dam/dam_break.pvd --view front {SIZE} -o p.png")).ok();
    let picture = Pixels::read(&program.path("p.png"));
    let [width, height] = picture.size.map(|side| side as usize);
    // Difference of the darkest and the brightest green in a row.
    let pattern = |row: usize| {
        let greens = || picture.rgba[row * width..(row + 1) * width].iter().map(|p| p[1]);
        greens().max().unwrap_or(0) - greens().min().unwrap_or(0)
    };
    assert!(pattern(0) <= 10 && pattern(height - 1) >= 20, "{} {}", pattern(0), pattern(height - 1));
}

/// Pure water absorbs per metre: what `--unit` says a metre is decides how clear it is.
#[test]
fn a_metre_of_pure_water_is_clear_and_a_kilometre_is_not() {
    let program = program_with_dam(2000, 1);
    let red = |unit: &str| {
        let alone =
            "--param post.transparent=true --param scene.floor=false --param lighting.pure_water=true";
        program.run(&format!("render dam/dam_break.pvd {SIZE} -o p_%d.png --unit {unit} {alone}")).ok();
        let picture = Pixels::read(&program.path("p_0.png"));
        let water = || picture.rgba.iter().filter(|p| p[3] == 255);
        water().map(|p| f64::from(p[0])).sum::<f64>() / water().count() as f64
    };
    let [metres, kilometres] = ["m", "1000"].map(red);
    // 133 and 8 of 255: a metre and a half takes half of the red, as many kilometres all but what is mirrored.
    assert!(metres > 4.0 * kilometres, "{metres} and {kilometres}");
}

/// Who gives no flags gets smooth edges.
#[test]
fn edges_are_smoothed_unasked() {
    let program = program_with_dam(500, 1);
    let bytes = |flags: &str| {
        program.run(&format!("render dam/dam_break.pvd --frame 0 {SIZE} -o p.png {flags}")).ok();
        std::fs::read(program.path("p.png")).expect("a picture")
    };
    let unasked = bytes("");
    assert!(unasked == bytes("--param post.anti_aliasing=true"));
    assert!(unasked != bytes("--param post.anti_aliasing=false"));
}

/// Single spheres show as such: where the smoothed surface of the same particles is even, they are bumpy.
#[test]
fn spheres_stay_spheres() {
    let program = program_with_dam(3000, 1);
    let roughness = |look: &str| {
        let alone =
            "--param post.transparent=true --param post.anti_aliasing=false --param scene.floor=false";
        let set = format!("--set 'grains=x > -1000:{look}'");
        program.run(&format!("render dam/dam_break.pvd --view top {SIZE} -o p.png {set} {alone}")).ok();
        let picture = Pixels::read(&program.path("p.png"));
        // Between neighbours that both show particles, as a share of their brightness: the materials differ.
        let pairs = || picture.rgba.windows(2).filter(|pair| pair.iter().all(|p| p[3] == 255));
        let sum = |of: fn(u8, u8) -> u8| pairs().map(|p| f64::from(of(p[0][1], p[1][1]))).sum::<f64>();
        assert!(pairs().count() > 5000, "{}", pairs().count());
        sum(u8::abs_diff) / sum(u8::max)
    };
    let [spheres, solid] = ["spheres", "solid"].map(roughness);
    // 16 times as rough as measured; without a difference in smoothing, once.
    assert!(spheres > 3.0 * solid, "{spheres} and {solid}");
}

/// y points up in this one.
#[test]
fn a_simulated_sphere_entry() {
    let Some(data) = data_dir() else { return };
    let program = crate::program();
    let input = format!("'{}'", data.join("sphere_entry/fluid.pvd").display());
    let pictures = pictures(&program, &input, &[0, 10, 19]);
    check_framed_and_drawn(&pictures);
    // The tank at rest is a solid body; later a cavity opens and spray flies.
    assert_eq!(pictures[0].1.hole_share(), 0.0);
    assert!(pictures[2].1.hole_share() < 0.005, "{}", pictures[2].1.hole_share());
    // What splashes goes up: the water's upper edge rises while its lower edge, on the floor, stays.
    let edges = [0, 2].map(|frame: usize| pictures[frame].1.bounds().expect("water"));
    assert!(edges[1][2] < edges[0][2] - 0.01, "{edges:?}");
    assert!((edges[1][3] - edges[0][3]).abs() < 0.02, "{edges:?}");
}

#[test]
fn a_still_scene_does_not_flicker() {
    let program = program_with_dam(3000, 1);
    for index in 1..4 {
        let copy = program.path(&format!("dam/dam_break_{index:04}.vtu"));
        std::fs::copy(program.path("dam/dam_break_0000.vtu"), copy).expect("a copy");
    }
    program.run(&format!("render 'dam/dam_break_*.vtu' -o o_%d.png {SIZE}")).ok();
    let first = Pixels::read(&program.path("o_0.png"));
    for index in 1..4 {
        let other = Pixels::read(&program.path(&format!("o_{index}.png")));
        assert!(other == first, "{index}: differs by {}", other.mean_difference(&first));
    }
}
