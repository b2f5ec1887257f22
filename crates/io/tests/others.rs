//! What is no water in the same file: air by its density, bodies by how they move, kinds that nothing tells apart.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use meniscus_core::{Cancel, Flaw, FrameRequest, FrameSource, Look};
use meniscus_io::{Series, SeriesOptions, SetSpec};

/// Particles on a lattice of 10 x 10 x 10, and their attributes as legacy VTK declares them.
struct File(String);

const POINTS: usize = 1000;

fn at(i: usize) -> [f64; 3] {
    [i % 10, i / 10 % 10, i / 100].map(|c| c as f64)
}

impl File {
    fn new(position: impl Fn(usize) -> [f64; 3]) -> Self {
        let points = tuples(position);
        Self(format!(
            "# vtk DataFile Version 3.0\nkinds\nASCII\nDATASET POLYDATA\nPOINTS {POINTS} double\n{points}\nPOINT_DATA {POINTS}\n"
        ))
    }

    fn lattice() -> Self {
        Self::new(at)
    }

    fn scalars<T: Display>(self, name: &str, ty: &str, value: impl Fn(usize) -> T) -> Self {
        let values: Vec<String> = (0..POINTS).map(|i| value(i).to_string()).collect();
        Self(format!("{}SCALARS {name} {ty} 1\nLOOKUP_TABLE default\n{}\n", self.0, values.join("\n")))
    }

    fn velocity(self, value: impl Fn(usize) -> [f64; 3]) -> Self {
        Self(format!("{}VECTORS velocity double\n{}\n", self.0, tuples(value)))
    }

    fn write(self, folder: &Path, name: &str) -> PathBuf {
        let path = folder.join(name);
        std::fs::write(&path, self.0).unwrap();
        path
    }
}

fn tuples(value: impl Fn(usize) -> [f64; 3]) -> String {
    (0..POINTS).map(value).map(|[x, y, z]| format!("{x} {y} {z}")).collect::<Vec<_>>().join("\n")
}

fn open(path: &Path, options: &SeriesOptions) -> Series {
    Series::open(path, options).unwrap_or_else(|e| panic!("{e}"))
}

/// The first frame's sets: look and number of particles.
fn sets(series: &Series) -> Vec<(Look, usize)> {
    let frame = series.read(0, &FrameRequest::default(), &Cancel::default()).unwrap();
    frame.sets.iter().map(|set| (set.look, set.particles.len())).collect()
}

/// The line about `what`, if there is one.
fn line(series: &Series, what: &str) -> Option<String> {
    series.choices().iter().find(|choice| choice.what == what).map(ToString::to_string)
}

fn flaws(series: &Series) -> Vec<Flaw> {
    series.flaws().iter().cloned().collect()
}

fn with_set(name: &str, pattern: &str, look: Look) -> SeriesOptions {
    let set = SetSpec { name: name.into(), pattern: pattern.into(), look };
    SeriesOptions { sets: vec![set], ..Default::default() }
}

/// The lower 400 are water.
fn is_air(i: usize) -> bool {
    i >= 400
}

fn density(i: usize) -> f64 {
    if is_air(i) { 1.2 + 0.001 * (i % 7) as f64 } else { 1000.0 + (i % 7) as f64 }
}

#[test]
fn air_of_another_kind_is_not_drawn_as_water() {
    let folder = tempfile::tempdir().unwrap();
    // However the kind is spelt and stored.
    for (name, ty) in [("phase", "int"), ("Material_ID", "long"), ("fluidId", "float"), ("ptype", "double")] {
        let file =
            File::lattice().scalars(name, ty, |i| 1 + i32::from(is_air(i))).scalars("rho", "double", density);
        let path = file.write(folder.path(), &format!("{name}.vtk"));
        let series = open(&path, &SeriesOptions::default());
        assert_eq!(sets(&series), [(Look::Water, 400), (Look::Hidden, 600)], "{name}");
        assert_eq!(flaws(&series), [], "{name}");
        let said = line(&series, "air").expect(name);
        let flag = format!("override with --set \"air={name} == 2:water\"");
        assert!(said.starts_with("air: 600 of 1000 particles, not drawn") && said.contains(&flag), "{said}");
        assert_eq!(line(&series, "kinds"), None, "{name}");

        // The flag draws it, and the others can be had without the choice.
        let shown = open(&path, &with_set("air", &format!("{name} == 2"), Look::Water));
        assert_eq!(sets(&shown), [(Look::Water, 400), (Look::Water, 600)], "{name}");
        let kept = open(&path, &SeriesOptions { keep_others: true, ..Default::default() });
        assert_eq!(sets(&kept), [(Look::Water, 1000)], "{name}");
        let flag = format!("--where '{name} == 1'");
        assert_eq!(flaws(&kept), [Flaw::OthersDrawnAsWater { what: "air", flag }], "{name}");
    }
}

#[test]
fn air_that_only_its_density_tells_is_not_drawn_as_water() {
    let folder = tempfile::tempdir().unwrap();
    let path = File::lattice().scalars("density", "double", density).write(folder.path(), "a.vtk");
    let series = open(&path, &SeriesOptions::default());
    assert_eq!(sets(&series), [(Look::Water, 400), (Look::Hidden, 600)]);
    let said = line(&series, "air").expect("a line");
    assert!(said.contains("--set \"air=0 < density < 35:water\""), "{said}");
    let shown = open(&path, &with_set("air", "0 < density < 35", Look::Water));
    assert_eq!(sets(&shown), [(Look::Water, 400), (Look::Water, 600)]);

    // Lone particles whose density is summed over too few neighbours are no gas.
    let spray = |i: usize| 1000.0 / f64::from(1 + (i % 40) as u32);
    let path = File::lattice().scalars("density", "double", spray).write(folder.path(), "b.vtk");
    let series = open(&path, &SeriesOptions::default());
    assert_eq!((sets(&series), flaws(&series)), (vec![(Look::Water, 1000)], vec![]));
}

#[test]
fn walls_and_air_are_both_left_out_and_one_flag_does_not_undo_the_other() {
    let folder = tempfile::tempdir().unwrap();
    let is_wall = |i: usize| at(i).iter().any(|c| *c < 1.0 || *c > 8.0);
    let kind = |i: usize| if is_wall(i) { 2 } else { i32::from(is_air(i)) };
    let walls = (0..POINTS).filter(|&i| is_wall(i)).count();
    let air = (0..POINTS).filter(|&i| !is_wall(i) && is_air(i)).count();
    let file = File::lattice().scalars("type", "int", kind).scalars("density", "double", density);
    let path = file.write(folder.path(), "a.vtk");
    let water = (Look::Water, POINTS - walls - air);
    let series = open(&path, &SeriesOptions::default());
    assert_eq!(sets(&series), [water, (Look::Hidden, walls), (Look::Hidden, air)]);
    let shown = open(&path, &with_set("air", "type == 1", Look::Water));
    assert_eq!(sets(&shown), [water, (Look::Water, air), (Look::Hidden, walls)]);
}

#[test]
fn kinds_that_nothing_tells_apart_are_pointed_out_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let file = || File::lattice().scalars("Material", "int", |i| 1 + i32::from(is_air(i)));
    // Soil, which is more than the water here.
    let soil = file().scalars("density", "double", |i| if is_air(i) { 2000.0 } else { 1000.0 });
    let path = soil.write(folder.path(), "a.vtk");
    let series = open(&path, &SeriesOptions::default());
    assert_eq!((sets(&series), flaws(&series)), (vec![(Look::Water, 1000)], vec![]));
    let said = line(&series, "kinds").expect("a line");
    for part in [
        "Material == 1 (400 particles of density 1000), Material == 2 (600 particles of density 2000), all drawn as water",
        "--set \"other=Material == 2:solid\"",
    ] {
        assert!(said.contains(part), "{said}");
    }
    let told = open(&path, &with_set("other", "Material == 2", Look::Solid));
    assert_eq!((sets(&told), line(&told, "kinds")), (vec![(Look::Water, 400), (Look::Solid, 600)], None));
    let said = SeriesOptions { where_expr: Some("Material in (1, 2)".into()), ..Default::default() };
    assert_eq!(line(&open(&path, &said), "kinds"), None, "the user says what the water is");

    let path = file().write(folder.path(), "b.vtk");
    let said = line(&open(&path, &SeriesOptions::default()), "kinds").expect("a line");
    assert!(said.contains("--set \"other=Material == 1:solid\""), "the most are the water: {said}");

    // Steel: water is no gas beside it. Shares of a phase are no kinds.
    let steel = file().scalars("density", "double", |i| if is_air(i) { 7850.0 } else { 1000.0 });
    let series = open(&steel.write(folder.path(), "c.vtk"), &SeriesOptions::default());
    assert_eq!(sets(&series), [(Look::Water, 1000)]);
    let share = File::lattice().scalars("phase", "double", |i| (i % 3) as f64 / 2.0);
    let series = open(&share.write(folder.path(), "d.vtk"), &SeriesOptions::default());
    assert_eq!(line(&series, "kinds"), None);
}

/// Kinds of a wave maker: 0 stands, 1 is the piston, 3 the water.
fn piston(i: usize) -> i32 {
    match at(i) {
        [_, _, z] if z < 1.0 => 0,
        [x, _, _] if x < 2.0 => 1,
        _ => 3,
    }
}

/// Something that is not the same everywhere.
fn wave(i: usize) -> [f64; 3] {
    let [x, y, z] = at(i);
    [f64::sin(x + 2.0 * z), 0.1 * f64::cos(y), f64::sin(2.0 * x)]
}

#[test]
fn a_body_that_moves_is_no_water() {
    let folder = tempfile::tempdir().unwrap();
    // It turns about its own edge and moves along.
    let (sin, cos) = f64::sin_cos(0.4);
    let turned = |[x, y, z]: [f64; 3]| [0.5 + cos * x - sin * z, y, sin * x + cos * z];
    let speed = |i: usize| match piston(i) {
        0 => [0.0; 3],
        1 => [0.5 - at(i)[2], 0.0, at(i)[0]],
        _ => wave(i),
    };
    let moved = |i: usize| match piston(i) {
        0 => at(i),
        1 => turned(at(i)),
        _ => std::array::from_fn(|axis| at(i)[axis] + wave(i)[axis]),
    };
    let count = |kind: i32| (0..POINTS).filter(|&i| piston(i) == kind).count();
    let typed = |file: File| file.scalars("Type", "unsigned_char", piston);

    // One moment's velocities: pointed out.
    let path = typed(File::lattice()).velocity(speed).write(folder.path(), "one.vtk");
    let series = open(&path, &SeriesOptions::default());
    let flag = "--where 'Type == 3'".to_owned();
    assert!(
        flaws(&series).contains(&Flaw::OthersDrawnAsWater { what: "body", flag }),
        "{:?}",
        series.flaws()
    );
    assert_eq!(sets(&series), [(Look::Water, POINTS)]);

    // Seen to move: left out.
    typed(File::lattice()).write(folder.path(), "f_0.vtk");
    typed(File::new(moved)).write(folder.path(), "f_1.vtk");
    let series = open(&folder.path().join("f_*.vtk"), &SeriesOptions::default());
    assert_eq!(sets(&series), [(Look::Water, count(3)), (Look::Hidden, count(0)), (Look::Hidden, count(1))]);
    let said = line(&series, "body").expect("a line");
    assert!(said.contains("--set \"body=Type == 1:solid\""), "{said}");
}

#[test]
fn a_drop_that_falls_into_a_lake_at_rest_is_no_body() {
    let folder = tempfile::tempdir().unwrap();
    let file = File::lattice().scalars("body", "int", |i| i32::from(i < 200));
    let fall = |i: usize| if i < 200 { [0.0, 0.0, -2.0] } else { [0.0; 3] };
    let series = open(&file.velocity(fall).write(folder.path(), "a.vtk"), &SeriesOptions::default());
    assert_eq!(sets(&series), [(Look::Water, POINTS)]);
    assert!(flaws(&series).iter().all(|flaw| !matches!(flaw, Flaw::OthersDrawnAsWater { what: "body", .. })));
}
