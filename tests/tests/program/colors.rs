//! Colours by attribute of sets that are drawn opaque.

use meniscus_tests::{Pixels, Program, read_json};

use crate::program_with_dam;

fn picture(program: &Program, flags: &str) -> Pixels {
    program
        .run(&format!("render dam/dam_break.pvd --frame 1 --size 160x90 --report r.json -o p.png {flags}"))
        .ok();
    Pixels::read(&program.path("p.png"))
}

/// Pixels that differ by more than anti-aliasing and rounding make of neighbours.
fn changed(a: &Pixels, b: &Pixels) -> Vec<usize> {
    let differs = |i: &usize| (0..3).any(|c| a.rgba[*i][c].abs_diff(b.rgba[*i][c]) > 12);
    (0..a.rgba.len()).filter(differs).collect()
}

#[test]
fn opaque_sets_show_the_colours() {
    let program = program_with_dam(4000, 2);
    for look in ["solid", "spheres"] {
        let set = format!("--set 'all=id >= 0:{look}'");
        let (own, by) = (picture(&program, &set), picture(&program, &format!("{set} --color-by velocity")));
        // A twelfth of the picture; the body takes up more.
        let pixels = changed(&own, &by).len();
        assert!(pixels > 1200, "{look}: {pixels}");
        let choices = read_json(&program.path("r.json"))["choices"].to_string();
        assert!(choices.contains("velocity from"), "{choices}");
    }
}

/// A wall in front of the water, in a file of its own that has no velocities.
#[test]
fn a_set_without_the_attribute_keeps_its_colour_and_that_is_said() {
    let program = program_with_dam(4000, 2);
    let point = |i: i32| format!("{} -0.2 {}\n", 0.05 * f64::from(i % 10), 0.05 * f64::from(i / 10));
    let points: String = (0..100).map(point).collect();
    let head = "# vtk DataFile Version 3.0\nwall\nASCII\nDATASET POLYDATA\nPOINTS 100 float\n";
    program.write("wall.vtk", format!("{head}{points}"));
    let camera = "--camera 0.6,-3,0.4/0.6,0,0.4/0,0,1/30";
    let wall = format!("{camera} --set 'wall=wall.vtk:spheres'");
    let own = picture(&program, &wall);
    let by = picture(&program, &format!("{wall} --color-by velocity"));
    let choices = read_json(&program.path("r.json"))["choices"].to_string();
    assert!(choices.contains("colours of set wall"), "{choices}");
    let without = picture(&program, &format!("{camera} --color-by velocity"));
    let is_wall: Vec<usize> = changed(&by, &without);
    let water = changed(&own, &by);
    let in_both = is_wall.iter().filter(|i| water.contains(i)).count();
    // Of the wall, only its edge may change, which anti-aliasing smooths into the water: a tenth of its pixels.
    assert!(is_wall.len() > 500 && in_both * 5 < is_wall.len(), "{in_both} of {}", is_wall.len());
    assert!(water.len() > 500, "{}", water.len());
}
