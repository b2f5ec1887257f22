//! Command lines and data that nobody means. None may panic or hang (the kit checks both on every run) and each ends with
//! the right code: a picture where one is defined, words where none is.

use crate::{program, program_with_dam};

#[test]
fn absurd_command_lines() {
    let program = program_with_dam(500, 1);
    program.write("not-a-scene.toml", "[floor\nvisible = maybe");
    for (code, flags) in [
        (0, "--size 1x1"),
        (0, "--size 17x3"),
        (0, "--size 1x400"),
        (0, "--size 2000x1"),
        (2, "--size 0x9"),
        (2, "--size 99999x9"),
        (2, "--size 9"),
        (0, "--lod 0"),
        (0, "--lod 1e-9"),
        (2, "--lod 2"),
        (2, "--lod=-1"),
        (2, "--lod nan"),
        (0, "--lod auto"),
        (0, "--lod auto --param lod.error_px=1e30 --param lod.error_color=1"),
        (0, "--lod auto --param lod.error_px=0 --param lod.error_color=0"),
        (2, "--lod auto --param lod.error_px=-1"),
        (2, "--lod auto --param lod.error_color=2"),
        (2, "--lod 30fps"),
        (2, "--lod much"),
        (0, "--near 1e-30"),
        (0, "--near 1e30"),
        (2, "--near 0"),
        (0, "--param lod.far=1e-30"),
        (2, "--param lod.far=0"),
        (2, "--show everything"),
        (0, "--show lod-culled --camera 0,-100,0/0,-200,0/0,0,1/40"),
        (2, "--spacing=-1"),
        (2, "--spacing 0"),
        (2, "--spacing inf"),
        (0, "--spacing 1e-12"),
        (0, "--spacing 1e12"),
        (0, "--radius 1e6"),
        (0, "--radius 1e-12"),
        (0, "--radius 100 --spacing 1e-3"),
        (2, "--radius 1e300"),
        (2, "--spacing 1e300"),
        (2, "--spacing 1e-300"),
        (0, "--unit 1e300"),
        (2, "--unit furlong"),
        (0, "--ortho 2"),
        (0, "--ortho 1e30"),
        (0, "--ortho 1e-30"),
        (2, "--ortho 0"),
        (2, "--ortho nan"),
        (2, "--view sideways"),
        (2, "--view top --camera 1,1,1/0,0,0/0,0,1/40"),
        (2, "--camera nan,0,0/0,0,0/0,0,1/40"),
        (2, "--camera 1,2/3"),
        (2, "--camera 1,1,1/0,0,0/0,0,1/180"),
        (2, "--camera 1,1,1/1,1,1/0,0,1/40"),
        (2, "--camera 0,0,9/0,0,0/0,0,1/40"),
        (2, "--camera 1,1,1/0,0,0/0,0,0/40"),
        (2, "--camera 1e300,1,1/0,0,0/0,0,1/40"),
        // Inside the water, behind it, beside it, far away, and with half a world in view.
        (0, "--camera 0.6,0.5,0.3/2,0.5,0.3/0,0,1/60"),
        (0, "--camera 0,-100,0/0,-200,0/0,0,1/40"),
        (0, "--camera=-9,0,0/-9,1,0/0,0,1/40"),
        (0, "--camera 1e15,0,0/0,0,0/0,0,1/40"),
        (0, "--camera 1,-1,1/0,0,0/0,0,1/174"),
        (0, "--camera 1,-1,1/0,0,0/0,0,1/0.2"),
        (0, "--camera 0.6,0.5,-3/0.6,0.5,0/0,1,0/40"),
        (2, "--where 'id < 0'"),
        (0, "--where 'id < 1'"),
        (2, "--where 'id <'"),
        (2, "--where ''"),
        (2, "--set nothing"),
        (2, "--set a=id --set a=id"),
        (2, "--frame 1"),
        (2, "--frame=-1"),
        (2, "--frame 99999999999999999999"),
        (2, "--frames 3..1"),
        (2, "--frames 0..9"),
        (2, "--threads 0"),
        (2, "--threads 99999"),
        (2, "--param ="),
        (2, "--param post=1"),
        (2, "--param post.exposure=99"),
        (2, "--param post.exposure=nan"),
        (2, "--param thickness.scale=3"),
        (2, "--param lighting.nothing=1"),
        (2, "--param filter.sigma=1e30"),
        (2, "--param filter.nothing=1"),
        (3, "--param scene.file=missing.toml"),
        (3, "--param scene.file=not-a-scene.toml"),
    ] {
        let size = if flags.contains("--size") { "" } else { "--size 32x18" };
        let run = program.run(&format!("render dam/dam_break_0000.vtu -q -o out.png {size} {flags}"));
        assert_eq!(run.code, Some(code), "{run:#?}");
        assert_eq!(program.path("out.png").exists(), code == 0, "{flags}");
        if code == 0 {
            let picture = meniscus_tests::Pixels::read(&program.path("out.png"));
            assert_eq!(picture.black_share(), 0.0, "{flags}");
            std::fs::remove_file(program.path("out.png")).expect("the picture");
        } else {
            assert!(run.stderr.len() > 20 && run.stderr.len() < 1000, "{run:#?}");
        }
    }
}

/// Data at the edge of what is data. Written as VTK's ascii files, which people write by hand.
#[test]
fn absurd_data() {
    let program = program();
    let points = |name: &str, points: &[[f64; 3]]| {
        let list: String = points.iter().map(|p| format!("{} {} {}\n", p[0], p[1], p[2])).collect();
        let head = "# vtk DataFile Version 3.0\nparticles\nASCII\nDATASET POLYDATA\nPOINTS";
        program.write(name, format!("{head} {} double\n{list}", points.len()));
    };
    let grid = |f: fn(f64, f64, f64) -> [f64; 3]| -> Vec<[f64; 3]> {
        (0..512).map(|i| f(f64::from(i % 8), f64::from(i / 8 % 8), f64::from(i / 64))).collect()
    };
    points("one.vtk", &[[1.0, 2.0, 3.0]]);
    points("two.vtk", &[[0.0; 3], [1.0, 0.0, 0.0]]);
    points("same.vtk", &[[1.0; 3]; 100]);
    points("line.vtk", &grid(|x, y, z| [x + 8.0 * y + 64.0 * z, 0.0, 0.0]));
    points("flat.vtk", &grid(|x, y, z| [x + 8.0 * y, 0.0, z]));
    points("microns.vtk", &grid(|x, y, z| [x * 1e-6, y * 1e-6, z * 1e-6]));
    points("galaxy.vtk", &grid(|x, y, z| [x * 1e12, y * 1e12, z * 1e12]));
    points("far.vtk", &grid(|x, y, z| [x + 1e9, y - 1e9, z]));
    points("stray.vtk", &[grid(|x, y, z| [x, y, z]), vec![[1e12, 0.0, 0.0]]].concat());
    points(
        "nan.vtk",
        &[grid(|x, y, z| [x, y, z]), vec![[f64::NAN, 0.0, 0.0], [0.0, f64::INFINITY, 0.0]]].concat(),
    );
    points("all-nan.vtk", &[[f64::NAN; 3]; 10]);
    points("none.vtk", &[]);
    for name in program.list("") {
        program.run(&format!("info {name} --json")).ok();
        program.run(&format!("render {name} -o out.png --size 32x18 --report r.json")).ok();
        let picture = meniscus_tests::Pixels::read(&program.path("out.png"));
        assert_eq!(picture.black_share(), 0.0, "{name}");
        let flaws = meniscus_tests::read_json(&program.path("r.json"))["flaws"].to_string();
        assert_eq!(flaws.contains("non_finite_dropped"), name.contains("nan"), "{name}: {flaws}");
        // An empty stage is a picture too, but not the one that was asked for.
        let empty = ["all-nan.vtk", "none.vtk"].contains(&name.as_str());
        assert_eq!(flaws.contains("nothing_visible"), empty, "{name}: {flaws}");
    }
}

/// Coordinates whose squares leave single precision define no picture today; they must still end in words.
#[test]
fn coordinates_beyond_single_precision() {
    let program = program();
    for scale in ["e-300", "e-30", "e-15", "e18", "e30", "e300"] {
        let list: String =
            (0..512).map(|i| format!("{}{scale} {}{scale} {}{scale}\n", i % 8, i / 8 % 8, i / 64)).collect();
        let head = "# vtk DataFile Version 3.0\nparticles\nASCII\nDATASET POLYDATA\nPOINTS 512 double\n";
        program.write("extreme.vtk", format!("{head}{list}"));
        let info = program.run("info extreme.vtk --json").ok().json();
        assert_eq!(info["frame"]["finite_points"], 512, "{scale}");
        let drawn = program.run("render extreme.vtk -o out.png --size 32x18");
        assert!(drawn.code.is_some_and(|code| code <= 2) && !drawn.stderr.is_empty(), "{drawn:#?}");
    }
}
