//! `.bgeo`, `.ply` and tables: all attributes of a point beside one another.

mod common;

use std::path::{Path, PathBuf};

use common::records::{self, PLY_FORMATS};
use meniscus_core::{Cancel, FrameRequest, FrameSource, SetFrame};
use meniscus_io::{Error, FrameInfo, IoMode, Series, SeriesOptions};

/// Enough that values are converted in several pieces, which end within tuples.
const COUNT: usize = 30_011;

fn put(folder: &Path, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, bytes).expect("written");
    path
}

fn open(path: &Path, options: &SeriesOptions) -> Result<(FrameInfo, SetFrame), Error> {
    let series = Series::open(path, options)?;
    let info = series.frame_info(0, true)?;
    let attributes = info.attributes.iter().map(|a| a.name.clone()).collect();
    let frame = series.read(0, &FrameRequest { attributes }, &Cancel::default()).expect("read");
    Ok((info, frame))
}

/// Compares what was read with the points that the identities say; gives how many there are.
fn check_points(name: &str, frame: &SetFrame) -> usize {
    let water = &frame.sets[0].particles;
    let find =
        |name: &str| water.attributes.iter().find(|a| a.name.eq_ignore_ascii_case(name)).map(|a| &a.values);
    let velocity = find("velocity").or_else(|| find("vel")).expect("a velocity");
    let (life, density, red) = (find("life"), find("density"), find("red"));
    for (at, id) in water.ids.iter().enumerate() {
        let i = (*id as usize - 1) / 3;
        let origin = frame.origin.to_array();
        let expected: [f32; 3] =
            std::array::from_fn(|a| (f64::from(records::point(i)[a]) - origin[a]) as f32);
        assert_eq!(water.positions[at], expected, "{name}, point {i}");
        assert_eq!(*id, records::id(i) as u64, "{name}, point {i}");
        assert_eq!(velocity[3 * at..][..3], records::velocity(i), "{name}, point {i}");
        if let Some(life) = life {
            assert_eq!(life[2 * at..][..2], records::life(i), "{name}, point {i}");
        }
        if let Some((density, red)) = density.zip(red) {
            assert_eq!((density[at], red[at]), (1000.0 + i as f32, (i % 256) as f32), "{name}, point {i}");
        }
    }
    water.len()
}

#[test]
fn every_form_is_read_alike_mapped_or_not_whole_or_thinned() {
    let folder = tempfile::tempdir().expect("a folder");
    let bgeo = records::bgeo(COUNT);
    let mut files = vec![("plain.bgeo", bgeo.clone()), ("packed.bgeo", records::gzip(&bgeo))];
    for format in PLY_FORMATS {
        files.push((format, records::ply(COUNT, format, "\n")));
    }
    files.push(("windows.ply", records::ply(COUNT, "binary_little_endian", "\r\n")));
    let tables = [
        (
            "paraview.csv",
            "\"Id\",\"Points:0\",\"Points:1\",\"Points:2\",\"vel:0\",\"vel:1\",\"vel:2\"\n",
            ",",
        ),
        (
            "dualsphysics.csv",
            "Idp;Pos.x [m];Pos.y [m];Pos.z [m];Vel.x [m/s];Vel.y [m/s];Vel.z [m/s];\n",
            " ; ",
        ),
        ("numpy.txt", "# made for a test\n#id x y z vel_x vel_y vel_z\n", " "),
    ];
    files.extend(tables.map(|(name, header, between)| (name, records::table(COUNT, header, between))));
    for (name, bytes) in files {
        let is_table = name.contains(".csv") || name.contains(".txt");
        let path = put(folder.path(), name, bytes);
        for io in [IoMode::Map, IoMode::Read] {
            let options = SeriesOptions { io_mode: io, keep_others: true, ..SeriesOptions::default() };
            let (info, frame) = open(&path, &options).unwrap_or_else(|e| panic!("{name}: {e}"));
            assert_eq!(
                (info.points, info.point_type),
                (COUNT, Some(if is_table { "Float64" } else { "Float32" })),
                "{name}"
            );
            assert_eq!(check_points(name, &frame), COUNT, "{name}");
            let (_, frame) = open(&path, &SeriesOptions { every: Some(7), ..options }).expect(name);
            let taken = check_points(name, &frame);
            assert!((COUNT / 8..COUNT / 6).contains(&taken), "{name}: {taken} of {COUNT}");
        }
    }
}

#[test]
fn properties_that_differ_in_a_last_letter_are_vectors() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = put(folder.path(), "a.ply", records::ply(5, "ascii", "\n"));
    let (info, _) = open(&path, &SeriesOptions::default()).expect("opens");
    let listed: Vec<_> = info.attributes.iter().map(|a| (a.name.as_str(), a.components, a.ty)).collect();
    assert_eq!(
        listed,
        [("red", 1, "UInt8"), ("density", 1, "Float64"), ("vel", 3, "Float32"), ("id", 1, "Int32")]
    );
}

#[test]
fn numbered_files_are_a_series_packed_or_not() {
    let folder = tempfile::tempdir().expect("a folder");
    for number in [10, 9, 11] {
        put(folder.path(), &format!("fluid_{number}.bgeo"), records::gzip(&records::bgeo(number)));
    }
    put(folder.path(), "fluid_1.bgeo.gz", records::gzip(&records::bgeo(1)));
    let series = Series::open(folder.path(), &SeriesOptions::default()).expect("a series");
    let points: Vec<usize> = (0..3).map(|i| series.frame_info(i, false).expect("reads").points).collect();
    assert_eq!(points, [9, 10, 11]);
    let packed = Series::open(&folder.path().join("*.bgeo.gz"), &SeriesOptions::default()).expect("a glob");
    assert_eq!(packed.frame_info(0, false).expect("reads").points, 1);
}

/// What is in the first frame of a file with this text: points, sums of the coordinates, and names of the other columns.
fn table(text: &str) -> Result<(usize, [f64; 3], Vec<String>), String> {
    let folder = tempfile::tempdir().expect("a folder");
    let (info, _) =
        open(&put(folder.path(), "a.txt", text), &SeriesOptions::default()).map_err(|e| e.to_string())?;
    let sums = info.centroid.expect("a point").map(|mean| mean * info.points as f64);
    Ok((info.points, sums, info.attributes.into_iter().map(|a| a.name).collect()))
}

#[test]
fn tables_of_every_kind() {
    let expected =
        |names: &[&str]| Ok((2, [5.0, 7.0, 9.0], names.iter().map(|&n| n.to_owned()).collect::<Vec<_>>()));
    assert_eq!(table("1 2 3\n4 5 6"), expected(&[]));
    assert_eq!(table("\n1,2,3\r\n\r\n4,5,6\r\n"), expected(&[]));
    assert_eq!(table("2\nwater at rest\nO 1 2 3\nO 4 5 6\n"), expected(&[]), "an .xyz file");
    assert_eq!(
        table("2\nstill water, at rest\nO 1 2 3\nO 4 5 6\n"),
        expected(&[]),
        "with a title as long as a row"
    );
    assert_eq!(table("\u{feff}x,y,z\n1,2,3\n4,5,6\n"), expected(&[]), "behind a byte order mark");
    assert_eq!(table("X\tY\tZ\tT (K)\n1\t2\t3\t280\n4\t5\t6\tnan\n"), expected(&["T"]));
    assert_eq!(table("7 1 2 3 1e3\n8 4 5 6 1e3\n"), expected(&["id", "column 5"]), "rows that are counted");
    assert_eq!(
        table("7 1 2 3\n9 4 5 6\n"),
        Ok((2, [16.0, 5.0, 7.0], vec!["column 4".into()])),
        "and that are not"
    );
    assert_eq!(table("m,x,y,z,name\n0.5,1,2,3,a\n0.5,4,5,6,b\n"), expected(&["m"]), "words are left out");
}

#[test]
fn tables_that_do_not_fit_are_refused() {
    for (text, expected) in [
        ("1 2 3\n4 5 6\n7 8\n", "the line at byte 12: a row of 2 values, expected 3"),
        ("x,y,z\n1,2,3\n4,,6\n", "the line at byte 12: a row of 2 values, expected 3"),
        ("2\n8 12 12\n1 2 3 4 5 6\n", "a row of 6 values, expected 3"),
        ("x,y,w\n1,2,3\n", "expected columns called x, y, z, one after another; found [\"x\", \"y\", \"w\"]"),
        // Nobody knows which of them are x, y, z.
        ("\"t, s\",x,y,z\n0,1,2,3\n", "5 names [\"t\", \"s\", \"x\", \"y\", \"z\"] for rows of 4 values"),
        ("1 2 3\n4 5 six\n", "\"six\", expected a number"),
        ("1,5;2,5;3,5\n", "neither a VTK file"),
        ("1,5 2,5 3,5\n", "neither a VTK file"),
        ("a\nb\nc\n1 2 3\n", "neither a VTK file"),
        ("1 2 3 \0\n", "neither a VTK file"),
    ] {
        let error = table(text).expect_err(text);
        assert!(error.contains(expected), "{text:?}: {error}");
    }
}

#[test]
fn a_log_beside_particles_is_not_taken_for_them() {
    let folder = tempfile::tempdir().expect("a folder");
    put(folder.path(), "water.bgeo", records::bgeo(9));
    for number in 0..3 {
        put(folder.path(), &format!("fluid_gauge_{number}.csv"), "t,x,y,z\n0,1,2,3\n");
    }
    let series = Series::open(folder.path(), &SeriesOptions::default()).expect("a series");
    assert_eq!(series.frame_info(0, false).expect("reads").points, 9);
}

/// Looking at all properties for each would take minutes.
#[test]
fn very_many_properties_are_no_bomb() {
    let folder = tempfile::tempdir().expect("a folder");
    let more: String = (0..200_000).map(|i| format!("property uchar p{i}\n")).collect();
    let header = |format: &str, more: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n{more}end_header\n"
        )
    };
    let binary = [header("binary_big_endian", &more).into_bytes(), vec![0; 12], vec![7; 200_000]].concat();
    let series =
        Series::open(&put(folder.path(), "a.ply", binary), &SeriesOptions::default()).expect("opens");
    let info = series.frame_info(0, true).expect("reads");
    assert_eq!(info.attributes.len(), 200_000);
    assert_eq!(info.attributes[199_999].max, Some(vec![Some(7.0)]));
    let row = |count: usize| vec!["1"; count].join(" ");
    let text = header("ascii", &more) + &row(200_003);
    let error = open(&put(folder.path(), "b.ply", text), &SeriesOptions::default()).expect_err("too many");
    assert!(error.to_string().contains("200003 properties in text, more than 1000"), "{error}");
    let error = table(&row(1001)).expect_err("too many");
    assert!(error.contains("neither a VTK file"), "{error}");
    assert_eq!(table(&row(1000)).map(|found| found.0), Ok(1));
}

#[test]
fn faults_name_the_place_and_what_to_do() {
    let bgeo = records::bgeo(10);
    let with = |at: usize, number: i32| {
        let mut file = bgeo.clone();
        file[at..at + 4].copy_from_slice(&number.to_be_bytes());
        file
    };
    let packed = records::gzip(&bgeo);
    let ply = |from: &str, to: &str| {
        let file = String::from_utf8(records::ply(3, "ascii", "\n")).expect("text");
        assert!(file.contains(from), "{from:?} is not in the file");
        file.replacen(from, to, 1).into_bytes()
    };
    // Packed zeros behind the header, far more than they take.
    let trap = records::gzip(&[bgeo.clone(), vec![0; 257 << 20]].concat());
    let folder = tempfile::tempdir().expect("a folder");
    for (name, bytes, expected) in [
        ("version", with(5, 19), "version 19; expected version 5"),
        ("negative", with(9, -3), "byte 13: the number of points is -3, expected 0 or more"),
        ("too many", with(9, i32::MAX), "2147483647 points of 44 bytes are declared"),
        ("cut off", bgeo[..bgeo.len() - 50].to_vec(), "it is cut off or the count is wrong"),
        ("header only", bgeo[..60].to_vec(), "the file ends, expected"),
        ("type", with(47, 2), "point attribute \"id\" has the unknown type 2"),
        ("packed and cut off", packed[..packed.len() / 2].to_vec(), "it is damaged or cut off"),
        ("packed text", records::gzip(b"# vtk DataFile Version 3.0\n"), "unpack it with gunzip first"),
        ("trap", trap, "more than 100 times its size"),
        ("new", b"\x7fNSJ\x01".to_vec(), "Houdini's new .bgeo"),
        ("no end", ply("end_header\n", ""), "expected a line of a PLY header, found \"0 1000"),
        (
            "no points",
            ply("property float y", "property float q"),
            "expected vertices with the properties x, y, z",
        ),
        (
            "mixed",
            ply("property float y", "property double y"),
            "expected vertices with the properties x, y, z",
        ),
        ("vertices", ply("vertex 3", "vertex 4000"), "4000 vertices of 9 numbers are declared"),
        ("short row", ply("0 1000 0 1 0", "0 1000 0 1"), "a row of 8 values, expected 9"),
        ("overflow", ply("vertex 3", "vertex 18446744073709551615"), "of 9 numbers are declared"),
        ("no count", ply("vertex 3", "vertex many"), "expected a number of elements, found \"many\""),
        ("list", ply("property uchar red", "property list uchar int n"), "vertices with lists as properties"),
        (
            "order",
            ply("element vertex", "element face 1\nelement vertex"),
            "element \"face\" comes before the vertices",
        ),
        ("twice", ply("element face", "element vertex"), "a second `element vertex`"),
        ("encoding", ply("ascii", "base64"), "unknown format \"base64\""),
        ("ply type", ply("uchar red", "colour red"), "unknown type \"colour\""),
        ("nothing but", b"ply\nformat ascii 1.0\n".to_vec(), "the file ends, expected end_header"),
    ] {
        let path = put(folder.path(), name, bytes);
        let error = open(&path, &SeriesOptions::default()).expect_err(name).to_string();
        assert!(error.contains(expected) && error.contains(name), "{name}: {error}");
    }
}
