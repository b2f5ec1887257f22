//! Land around the water, from an elevation grid in the scene file.

use glam::DVec3;
use meniscus_core::{Aabb, UpAxis};
use meniscus_scene::{Terrain, UpFrame};
use meniscus_tests::{Pixels, data_dir, read_json};

use crate::{program, program_with_dam};

/// A slope that rises to the north through the water of the dam break, over its tank and half a metre around it.
fn slope() -> String {
    let header = "ncols 22\nnrows 11\nxllcenter -0.5\nyllcenter -0.5\ncellsize 0.2\n";
    let rows = (0..11).rev().map(|row| format!("{}\n", format!("{:.3} ", 0.04 * f64::from(row)).repeat(22)));
    header.to_owned() + &rows.collect::<String>()
}

#[test]
fn land_takes_the_place_of_the_floor_and_hides_the_water_in_it() {
    let program = program_with_dam(3000, 1);
    program.write("slope.asc", slope());
    program.write("scene.toml", "[[terrain]]\nfile = \"slope.asc\"\nmaterial = \"plain\"\n");
    // From above, without refraction and shadows: land is grey, water blue.
    let render = "render dam -o a.png --size 64x48 --lighting vtk --param lighting.refraction_scale=0 --param scene.shadows=false \
                  --camera 0.6,0.5,6/0.6,0.5,0/0,1,0/20 --scene scene.toml";
    let said = program.run(render).ok();
    assert!(!said.stderr.contains("terrain"), "nothing was left out: {}", said.stderr);
    let picture = Pixels::read(&program.path("a.png"));
    let share = |is: &dyn Fn(&[u8; 4]) -> bool, rows: std::ops::Range<usize>| {
        let pixels = &picture.rgba[rows.start * 64..rows.end * 64];
        pixels.iter().filter(|pixel| is(pixel)).count() as f64 / pixels.len() as f64
    };
    let is_water = |pixel: &[u8; 4]| pixel[2] > pixel[0].saturating_add(20);
    // The slope comes out of the water in the middle of the tank, whose southern wall is in row 35.
    assert_eq!(share(&is_water, 0..22), 0.0);
    assert!(share(&is_water, 29..34) > 0.5, "{}", share(&is_water, 29..34));

    // Land that lies higher than all of the water leaves nothing of it.
    program.write("slope.asc", slope().replace(" 0.", " 5."));
    program.run(&render.replace("0.6,0.5,6/", "0.6,0.5,16/")).ok();
    assert!(!Pixels::read(&program.path("a.png")).rgba.iter().any(is_water), "no water");
}

#[test]
fn grids_that_cannot_be_used_are_named() {
    let program = program_with_dam(1000, 1);
    program.write("scene.toml", "[[terrain]]\nfile = \"slope.asc\"\n");
    for (grid, said) in [
        (None, "cannot be read"),
        (Some("ncols 3\nnrows 1\n1 2 3\n"), "cellsize is missing"),
        (Some("hello"), "gdal_translate"),
    ] {
        if let Some(grid) = grid {
            program.write("slope.asc", grid);
        }
        let run = program.run("render dam -o a.png --size 32x18 -q --scene scene.toml").expect(3);
        assert!(run.stderr.contains("slope.asc") && run.stderr.contains(said), "{}", run.stderr);
    }
}

/// Seen at a small angle, refracted rays end far below what is in the picture beside them. The bed of water is the same whether it is the
/// floor, which is known exactly, or the top of a block, which is met in the picture.
#[test]
fn a_bed_is_seen_through_the_water_as_a_floor_is() {
    let program = program_with_dam(30_000, 1);
    program.write("floor.toml", "[floor]\nheight = 0\nmaterial = \"concrete\"\n");
    let block = "[[box]]\nmin = [-50, -50, -1]\nmax = [50, 50, 0]\nmaterial = \"concrete\"\n";
    program.write("block.toml", format!("[floor]\nheight = -5\n{block}"));
    let picture = |scene: &str| {
        let flags = "--lighting point-light --param scene.shadows=false --size 480x270 --camera 6,-3,1.0/1.6,0.5,0.2/0,0,1/20";
        program.run(&format!("render dam -o {scene}.png -q {flags} --scene {scene}.toml")).ok();
        Pixels::read(&program.path(&format!("{scene}.png")))
    };
    let (floor, block) = (picture("floor"), picture("block"));
    let far_off =
        std::iter::zip(&floor.rgba, &block.rgba).filter(|(a, b)| (0..3).any(|i| a[i].abs_diff(b[i]) > 40));
    // Single pixels at silhouettes and where four steps are too few; dark bands over the whole surface were one in sixty.
    let share = far_off.count() as f64 / floor.rgba.len() as f64;
    assert!(share < 5e-4, "{share}");
}

#[test]
fn made_land_comes_with_a_scene_that_shows_it() {
    let program = program();
    let said = program.run("make fjord-tsunami -o fjord --particles 50000").ok();
    assert!(said.stderr.contains("--scene fjord/fjord_tsunami_scene.toml"), "{}", said.stderr);
    program
        .run("render fjord -o a.png --size 96x54 --report r.json --scene fjord/fjord_tsunami_scene.toml")
        .ok();
    assert_eq!(read_json(&program.path("r.json"))["flaws"], serde_json::json!([]));
    let picture = Pixels::read(&program.path("a.png"));
    let blue = picture.rgba.iter().filter(|pixel| pixel[2] > pixel[0] + 25).count() as f64 / (96.0 * 54.0);
    // A band of water between mountains.
    assert!((0.01..0.4).contains(&blue), "{blue}");
}

#[test]
fn a_map_of_the_usgs_has_the_heights_that_it_says() {
    let Some(data) = data_dir() else { return };
    let terrain = Terrain::read(&data.join("terrain/SainteHelens.dem")).expect("a map");
    assert_eq!((terrain.size()[0], terrain.spacing().to_array()), (327, [30.0, 30.0]));
    let mesh = terrain.mesh(UpFrame::new(UpAxis::Z), DVec3::ZERO);
    let Aabb { min, max } = Aabb::of_points(&mesh.positions);
    // Of its header, metres.
    assert_eq!((min.z, max.z), (682.0, 2543.0));
}
