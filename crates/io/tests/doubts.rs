//! What is said where the data or the request says too little.

mod common;

use std::path::{Path, PathBuf};

use common::data_dir;
use meniscus_core::{Cancel, Choice, Flaw, FrameRequest, FrameSource, Look, SpacingSource};
use meniscus_io::writer::{Values, WriteAttribute, WriteParticles, write_vtu_raw};
use meniscus_io::{Error, Series, SeriesOptions, SetSpec};

fn open(path: &Path, options: &SeriesOptions) -> Series {
    Series::open(path, options).unwrap_or_else(|e| panic!("{e}"))
}

fn write(path: &Path, positions: &[[f64; 3]], attributes: &[WriteAttribute<'_>]) {
    write_vtu_raw(path, &WriteParticles { positions, attributes, time: None }).expect("written");
}

/// A cube of `side`³ particles at distance 0.1.
fn cube(side: usize) -> Vec<[f64; 3]> {
    let at = |i: usize| [i % side, i / side % side, i / side / side];
    (0..side.pow(3)).map(|i| at(i).map(|c| 0.1 * c as f64)).collect()
}

/// A file of `positions` with the values of `type`.
fn typed(folder: &Path, name: &str, positions: &[[f64; 3]], kind: impl Fn(usize) -> i32) -> PathBuf {
    let kinds: Vec<i32> = (0..positions.len()).map(kind).collect();
    let path = folder.join(name);
    let attribute = WriteAttribute { name: "type", components: 1, values: Values::I32(&kinds) };
    write(&path, positions, &[attribute]);
    path
}

fn selecting(expression: &str) -> SeriesOptions {
    SeriesOptions { where_expr: Some(expression.into()), ..Default::default() }
}

fn with_sets(specs: &[&str]) -> SeriesOptions {
    let sets = specs.iter().map(|text| SetSpec::parse(text).expect("a set")).collect();
    SeriesOptions { sets, ..Default::default() }
}

fn line<'a>(series: &'a Series, what: &str) -> Option<&'a Choice> {
    series.choices().iter().find(|choice| choice.what == what)
}

#[test]
fn a_guessed_spacing_is_called_a_guess() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("triangle.vtu");
    write(&path, &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[]);
    let series = open(&path, &SeriesOptions::default());
    let reason = &line(&series, "spacing").expect("a line").reason;
    assert!(reason.starts_with("a guess") && reason.contains("too far apart"), "{reason}");
    write(&path, &cube(12), &[]);
    let series = open(&path, &SeriesOptions::default());
    let reason = &line(&series, "spacing").expect("a line").reason;
    assert!(reason.starts_with("estimated"), "{reason}");
}

#[test]
fn the_flag_for_a_part_left_out_can_be_pasted() {
    let Some(dir) = data_dir() else { return };
    let path = dir.join("sphere_entry/fluid_with_sphere.pvd");
    let flag = line(&open(&path, &SeriesOptions::default()), "parts left out").expect("a line").flag.clone();
    let pattern = dir.join("sphere_entry/sphere_*.vtp");
    assert_eq!(flag, format!("--set \"sphere={}:solid\"", pattern.display()));
    let spec = flag.strip_prefix("--set \"").and_then(|rest| rest.strip_suffix('"')).expect("quoted");
    let series = open(&path, &with_sets(&[spec]));
    assert_eq!(line(&series, "parts left out"), None, "nothing is left out any more");
    for index in [0, 19] {
        let frame = series.read(index, &FrameRequest::default(), &Cancel::default()).expect("reads");
        let sphere = &frame.sets[1];
        assert_eq!((sphere.name.as_str(), sphere.look), ("sphere", Look::Solid));
        assert!(!sphere.particles.is_empty());
        let name = format!("sphere_{index:04}.vtp");
        assert!(frame.files.last().expect("files").ends_with(name), "frame {index}: {:?}", frame.files);
    }
}

#[test]
fn a_part_in_a_folder_with_odd_letters_can_be_pasted() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = folder.path().join("run [1] a=b in $x");
    std::fs::create_dir(&place).expect("created");
    write(&place.join("fluid.vtu"), &cube(4), &[]);
    let mesh = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n\
                POLYGONS 1 4\n3 0 1 2\n";
    std::fs::write(place.join("2.vtk"), mesh).expect("written");
    let collection = "<VTKFile type=\"Collection\"><Collection><DataSet timestep=\"0\" file=\"fluid.vtu\"/>\
                      <DataSet timestep=\"0\" part=\"1\" file=\"2.vtk\"/></Collection></VTKFile>";
    let path = place.join("all.pvd");
    std::fs::write(&path, collection).expect("written");
    let series = open(&path, &SeriesOptions::default());
    let flag = &line(&series, "parts left out").expect("a line").flag;
    let spec = flag.strip_prefix("--set \"").and_then(|rest| rest.strip_suffix('"')).expect("quoted");
    assert!(!spec.contains(['$', '"', '`', '\\', '!']), "{spec}: the shell would read it otherwise");
    let series = open(&path, &with_sets(&[spec]));
    let frame = series.read(0, &FrameRequest::default(), &Cancel::default()).expect("reads");
    assert_eq!((frame.sets[1].name.as_str(), frame.sets[1].particles.len()), ("part", 3));
}

#[test]
fn a_set_with_fewer_frames_than_the_series_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    for i in 0..3 {
        write(&folder.path().join(format!("fluid_{i}.vtu")), &cube(4), &[]);
        write(&folder.path().join(format!("ball_{i}.vtu")), &cube(3), &[]);
    }
    let input = folder.path().join("fluid_*.vtu");
    let set = |file: &str| format!("ball={}:solid", folder.path().join(file).display());
    let series = open(&input, &with_sets(&[&set("ball_1.vtu")]));
    let found = line(&series, "set ball").expect("a line");
    assert_eq!(found.value, "1 frame for all 3 of the series", "{found}");
    assert!(found.flag.starts_with("--set"), "{found}");
    let series = open(&input, &with_sets(&[&set("ball_*.vtu")]));
    assert_eq!(line(&series, "set ball"), None, "every frame has its own");
    std::fs::remove_file(folder.path().join("ball_2.vtu")).expect("removed");
    let series = open(&input, &with_sets(&[&set("ball_*.vtu")]));
    assert_eq!(line(&series, "set ball").expect("a line").value, "2 frames for all 3 of the series");
}

#[test]
fn a_selection_that_matches_nothing_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let points = cube(4);
    let path = typed(folder.path(), "f_0.vtu", &points, |i| i as i32 % 3);
    let refusal = |options: &SeriesOptions| match Series::open(&path, options) {
        Err(error @ Error::Usage { .. }) => error.to_string(),
        other => panic!("{:?}", other.map(|series| series.choices().to_vec())),
    };
    assert_eq!(
        refusal(&selecting("type == 9")),
        "the selection \"type == 9\" matches none of 64 particles; type has the values 0, 1, 2"
    );
    let message = refusal(&selecting("z > 7 and type == 1"));
    assert!(message.ends_with("; z is from 0 to 0.3; type has the values 0, 1, 2"), "{message}");
    let message = refusal(&with_sets(&["water=type == 9"]));
    assert!(message.contains("matches none of 64"), "{message}");
    // Another set may fill later.
    let series = open(&path, &with_sets(&["sand=type == 9:solid"]));
    assert_eq!(line(&series, "set sand").expect("a line").value, "no particle");
}

#[test]
fn later_frames_may_be_without_matches() {
    let folder = tempfile::tempdir().expect("a folder");
    let points = cube(4);
    typed(folder.path(), "f_0.vtu", &points, |i| i as i32 % 3);
    typed(folder.path(), "f_1.vtu", &points, |_| 5);
    let series = open(&folder.path().join("f_*.vtu"), &selecting("type == 1"));
    let read = |i| series.read(i, &FrameRequest::default(), &Cancel::default()).expect("reads").len();
    assert_eq!((read(0), read(1)), (21, 0));
}

#[test]
fn sets_that_take_everything_still_have_a_spacing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = typed(folder.path(), "f.vtu", &cube(12), |_| 1);
    let series = open(&path, &with_sets(&["sand=type == 1:solid"]));
    assert!((series.space().spacing / 0.1 - 1.0).abs() < 0.05, "{}", series.space().spacing);
    assert!(series.flaws().is_empty(), "{:?}", series.flaws());
    // A block beside coarser walls, told apart by name: nothing of it is a wall drawn as water, and the liquid sets the scale.
    let mut points = cube(12);
    let walls = cube(20).into_iter().map(|[x, y, z]| [10.0 + 3.0 * x, 3.0 * y, 3.0 * z]);
    points.extend(walls);
    let path = typed(folder.path(), "g.vtu", &points, |i| i32::from(i >= 1728));
    let series = open(&path, &with_sets(&["fluid=type == 0", "walls=type == 1:hidden"]));
    assert!((series.space().spacing / 0.1 - 1.0).abs() < 0.05, "{}", series.space().spacing);
    assert!(series.flaws().is_empty(), "{:?}", series.flaws());
}

#[test]
fn a_broken_first_frame_is_left_to_those_who_draw_it() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("f_0.vtu"), "<VTKFile").expect("written");
    write(&folder.path().join("f_1.vtu"), &cube(12), &[]);
    let series = open(&folder.path().join("f_*.vtu"), &SeriesOptions::default());
    assert!(series.flaws().is_empty(), "{:?}", series.flaws());
    assert!(series.read(0, &FrameRequest::default(), &Cancel::default()).is_err());
}

#[test]
fn grains_are_drawn_as_large_as_they_say() {
    let Some(dir) = data_dir() else { return };
    let series = open(&dir.join("liggghts_chute"), &SeriesOptions::default());
    let space = series.space();
    assert!((0.0015..=0.0025).contains(&space.radius), "{space:?}");
    assert!((space.spacing / (2.0 * space.radius) - 1.0).abs() < 1e-12, "{space:?}");
    assert!(!series.flaws().iter().any(|flaw| matches!(flaw, Flaw::SpacingUncertain { .. })));
    for what in ["spacing", "radius"] {
        let reason = &line(&series, what).expect("a line").reason;
        assert!(reason.contains("\"radius\""), "{what}: {reason}");
    }
}

#[test]
fn a_radius_counts_where_the_density_does_not_agree() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("f.vtu");
    let points = cube(12);
    // Spacing by density 0.1: (radius, spacing expected).
    for (radius, expected) in [(0.05, 0.1), (0.03, 0.1), (0.01, 0.02), (0.0, 0.1), (-1.0, 0.1), (900.0, 0.1)]
    {
        let radii = vec![radius; points.len()];
        let attribute = WriteAttribute { name: "Radius", components: 1, values: Values::F64(&radii) };
        write(&path, &points, &[attribute]);
        let space = *open(&path, &SeriesOptions::default()).space();
        // 5 %: the promise of the specification for estimates.
        assert!((space.spacing / expected - 1.0).abs() < 0.05, "{radius}: {space:?}");
        assert_eq!(space.spacing_source, SpacingSource::Estimate);
    }
}

/// Points behind those that the header counts would be missing without a word.
#[test]
fn more_points_than_the_header_says_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let legacy = |name: &str, mode: &str, body: &[u8]| {
        let head = format!("# vtk DataFile Version 3.0\nx\n{mode}\nDATASET POLYDATA\nPOINTS 2 float\n");
        let path = folder.path().join(name);
        std::fs::write(&path, [head.as_bytes(), body].concat()).expect("written");
        Series::open(&path, &SeriesOptions::default())
    };
    let binary = [0x3f_u8, 0x80, 0, 0].repeat(9);
    for (name, mode, body) in
        [("a.vtk", "ASCII", &b"0 0 0 1 0 0\n0.5 0 1\n"[..]), ("b.vtk", "BINARY", &binary[..])]
    {
        let message = legacy(name, mode, body).err().expect(name).to_string();
        for part in [name, "behind POINTS 2", "correct the number of points"] {
            assert!(message.contains(part), "{message}");
        }
    }
    for body in ["0 0 0 1 0 0\n", "0 0 0 1 0 0\n\nMETADATA\nINFORMATION 0\n\nVERTICES 1 3\n2 0 1\n"] {
        assert_eq!(
            legacy("c.vtk", "ASCII", body.as_bytes()).expect("opens").point_count(0).expect("counts"),
            2
        );
    }
}

#[test]
fn what_is_not_read_is_named_with_what_to_do() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, bytes, parts) in [
        ("a.vtkhdf", &b"\x89HDF\r\n\x1a\n\0\0\0"[..], ["HDF5", "write it as .vtu or .vtp"]),
        (
            "b.vtm",
            b"<VTKFile type=\"vtkMultiBlockDataSet\"></VTKFile>",
            ["vtkMultiBlockDataSet", "open one of the files"],
        ),
        (
            "c.vts",
            b"<VTKFile type=\"StructuredGrid\"></VTKFile>",
            ["StructuredGrid", "write the points as .vtu"],
        ),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("written");
        let message = Series::open(&path, &SeriesOptions::default()).err().expect(name).to_string();
        assert!(parts.iter().all(|part| message.contains(part)), "{message}");
    }
}

/// Lengths have significant digits, not six decimals.
#[test]
fn small_lengths_are_printed() {
    let folder = tempfile::tempdir().expect("a folder");
    let points: Vec<[f64; 3]> = cube(12).into_iter().map(|p| p.map(|c| 2.5e-5 * c)).collect();
    write(&folder.path().join("f.vtu"), &points, &[]);
    let series = open(&folder.path().join("f.vtu"), &SeriesOptions::default());
    let value = |what: &str| {
        let line = series.choices().iter().find(|choice| choice.what == what).expect(what);
        line.value.parse::<f64>().expect("a number")
    };
    // Five digits: half a unit of the last one is at most 5e-5 of the number.
    assert!((value("spacing") / series.space().spacing - 1.0).abs() < 5e-5, "{}", value("spacing"));
    assert!((value("radius") / series.space().radius - 1.0).abs() < 5e-5, "{}", value("radius"));
}
