//! Every format in every encoding, from files made here.

mod common;

use std::path::{Path, PathBuf};

use common::legacy;
use common::xml::{Format, Xml};
use meniscus_core::{Cancel, FrameRequest, FrameSource, SetFrame};
use meniscus_io::{Error, FrameInfo, Series, SeriesOptions};

fn put(folder: &Path, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, bytes).expect("written");
    path
}

fn open(path: &Path) -> Result<(FrameInfo, SetFrame), Error> {
    let series = Series::open(path, &SeriesOptions::default())?;
    let info = series.frame_info(0, true)?;
    let attributes = info.attributes.iter().map(|a| a.name.clone()).collect();
    let frame = series.read(0, &FrameRequest { attributes }, &Cancel::default()).expect("read");
    Ok((info, frame))
}

fn attribute<'a>(frame: &'a SetFrame, name: &str) -> &'a [f32] {
    let found = frame.sets[0].particles.attributes.iter().find(|a| a.name == name);
    &found.unwrap_or_else(|| panic!("no attribute {name}")).values
}

#[test]
fn xml_in_every_encoding() {
    let folder = tempfile::tempdir().expect("a folder");
    let cases = Xml::all();
    assert_eq!(cases.len(), 288);
    for case in cases {
        let path = put(folder.path(), &format!("case.{}", case.extension()), case.bytes());
        let (info, frame) = open(&path).unwrap_or_else(|e| panic!("{case:?}: {e}"));
        let count = case.points();
        assert_eq!(info.points, count, "{case:?}");
        assert_eq!(info.point_type, Some(if case.single { "Float32" } else { "Float64" }), "{case:?}");
        let water = &frame.sets[0].particles;
        for i in 0..count {
            let point = Xml::point(i);
            let expected: [f32; 3] = std::array::from_fn(|a| (point[a] - frame.origin.to_array()[a]) as f32);
            assert_eq!(water.positions[i], expected, "{case:?}, point {i}");
            assert_eq!(water.ids[i], Xml::id(i) as u64, "{case:?}, point {i}");
            assert_eq!(attribute(&frame, "density")[i], Xml::density(i) as f32, "{case:?}, point {i}");
        }
    }
}

/// Made with Python's `lzma`, which has the only xz encoder at hand: blocks of 32 bytes.
#[test]
fn xml_with_lzma() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/lzma.vtp");
    let (info, _) = open(&path).expect("opens");
    assert_eq!(info.bounds, Some([0.0, 4.5, 1021.75, 1024.0, 0.0, 81.0]));
    assert_eq!(info.centroid, Some([2.25, 1022.875, 28.5]));
}

#[test]
fn legacy_ascii_with_every_section() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in [
        ("lf.vtk", legacy::ASCII.to_owned()),
        ("crlf.vtk", legacy::ASCII.replace('\n', "\r\n")),
        (
            "lower.vtk",
            legacy::ASCII.replace("POINTS 4 double", "points 4 DOUBLE").replace("POINT_DATA", "Point_Data"),
        ),
    ] {
        let (info, frame) = open(&put(folder.path(), name, text)).expect(name);
        assert_eq!((info.points, info.time), (4, Some(0.5)), "{name}");
        assert_eq!(info.bounds, Some([0.0, 1.0, 0.0, 1.0, 0.0, 1.0]), "{name}");
        let listed: Vec<_> = info.attributes.iter().map(|a| (a.name.as_str(), a.components, a.ty)).collect();
        assert_eq!(
            listed,
            [
                ("pressure", 1, "Float32"),
                ("velocity", 3, "Float64"),
                ("n", 3, "Float32"),
                ("stress", 9, "Float32"),
                ("uv", 2, "Float32"),
                ("rgb", 3, "UInt8"),
                ("id", 1, "Int64"),
                ("mass flow", 1, "Float32"),
            ],
            "{name}"
        );
        assert_eq!(frame.sets[0].particles.ids, [40, 30, 20, 10], "{name}");
        assert_eq!(attribute(&frame, "rgb"), [0., 0., 255., 0., 255., 0., 255., 0., 0., 128., 128., 128.]);
        assert_eq!(attribute(&frame, "mass flow"), [5.0, 6.0, 7.0, 8.0], "{name}");
    }
}

/// As meshio writes them in version 5.1.
#[test]
fn legacy_types_by_size() {
    let folder = tempfile::tempdir().expect("a folder");
    let names =
        ["int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float32", "float64"];
    let arrays: String = names.iter().map(|name| format!("{name} 1 1 vtktype{name}\n7\n")).collect();
    let text = format!(
        "# vtk DataFile Version 5.1\nx\nASCII\nDATASET POLYDATA\nPOINTS 1 vtktypefloat64\n1 2 3\nPOINT_DATA 1\n\
         FIELD FieldData {}\n{arrays}",
        names.len()
    );
    let (info, _) = open(&put(folder.path(), "sizes.vtk", text)).expect("opens");
    assert_eq!(info.point_type, Some("Float64"));
    for attribute in &info.attributes {
        assert_eq!(attribute.ty.to_lowercase(), attribute.name);
        assert_eq!(attribute.min, Some(vec![Some(7.0)]));
    }
    assert_eq!(info.attributes.len(), names.len());
}

#[test]
fn legacy_binary_whose_payload_looks_like_text() {
    let folder = tempfile::tempdir().expect("a folder");
    let (info, frame) = open(&put(folder.path(), "old.vtk", legacy::binary())).expect("opens");
    let names: Vec<_> = info.attributes.iter().map(|a| (a.name.as_str(), a.ty)).collect();
    assert_eq!(names, [("flag", "Bit"), ("POINTS", "Int16")]);
    assert_eq!(attribute(&frame, "flag"), [1.0, 0.0, 1.0, 0.0]);
    assert_eq!(attribute(&frame, "POINTS"), [7.0, 2570.0, 9.0, 10.0]);
    assert_eq!(info.bounds.map(|b| b[0]), Some(f64::from(f32::from_bits(0))));
    assert_eq!(info.bounds.map(|b| b[1]), Some(1.0));
}

#[test]
fn wild_spellings() {
    let folder = tempfile::tempdir().expect("a folder");
    let plain = String::from_utf8(Xml::plain(Format::Ascii).bytes()).expect("text");
    for (name, text) in [
        ("bom.vtu", format!("\u{feff}{plain}")),
        ("format.vtu", plain.replace("format=", "Format =  ")),
        ("comment.vtu", plain.replace("<Points>", "<!-- <Piece> > --><Points>")),
        ("comment_in_data.vtu", plain.replace(" 1023.75 ", " <!-- a point --> 1023.75 ")),
        (
            "only_blanks_between.vtu",
            plain.replace(" 1023.75 ", "<!-- a --> <!-- b -->1023.75<!-- c --> \n<!-- d -->"),
        ),
        ("cdata.vtu", plain.replace(" 1023.75 ", " <![CDATA[1023]]>.<![CDATA[75 ]]>")),
        ("letter.vtu", plain.replace(" 1023.75 ", " 1&#48;23.75&#x20;")),
        ("upper.vtu", plain.replace("'ascii'", "'ASCII'").replace("'LittleEndian'", "'littleendian'")),
        (
            "key.vtu",
            plain.replace("</DataArray>", "<InformationKey name='x'>7 7</InformationKey></DataArray>"),
        ),
        ("no_declaration.vtu", plain.replace("<?xml version='1.0'?>\n", "")),
        ("extension.dat", plain.clone()),
        ("unnamed.vtu", plain.replace("Name='Points'", "")),
    ] {
        assert!(name == "extension.dat" || text != plain, "{name} changes nothing");
        let (info, _) = open(&put(folder.path(), name, &text)).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(info.bounds, Some([0.0, 4.5, 1021.75, 1024.0, 0.0, 81.0]), "{name}");
    }
}

#[test]
fn parallel_files_and_their_faults() {
    let folder = tempfile::tempdir().expect("a folder");
    put(folder.path(), "a.vtu", Xml::plain(Format::AppendedRaw).bytes());
    put(folder.path(), "b.vtu", Xml::plain(Format::Inline).bytes());
    let parallel = |sources: &[&str]| {
        let pieces: String = sources.iter().map(|source| format!("<Piece Source='{source}'/>")).collect();
        format!("<VTKFile type='PUnstructuredGrid'><PUnstructuredGrid>{pieces}</PUnstructuredGrid></VTKFile>")
    };
    let (info, frame) = open(&put(folder.path(), "ab.pvtu", parallel(&["a.vtu", "b.vtu"]))).expect("opens");
    assert_eq!((info.points, attribute(&frame, "density").len()), (20, 20));
    for (name, sources) in [("missing.pvtu", ["a.vtu", "none.vtu"]), ("self.pvtu", ["a.vtu", "self.pvtu"])] {
        let error = open(&put(folder.path(), name, parallel(&sources))).expect_err(name).to_string();
        assert!(error.contains("piece 1") && error.contains(sources[1]), "{error}");
    }
}

/// Written by programs on Windows; also in series.
#[cfg(unix)]
#[test]
fn backslashes_separate_folders_where_no_file_has_them() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("sub")).expect("created");
    put(folder.path(), "sub/a.vtu", Xml::plain(Format::AppendedRaw).bytes());
    let one = Xml { pieces: &[1], ..Xml::plain(Format::Ascii) }.bytes();
    put(folder.path(), "sub\\b.vtu", one);
    put(folder.path(), "sub/b.vtu", Xml::plain(Format::AppendedRaw).bytes());
    let pieces = r"<Piece Source='sub\a.vtu'/><Piece Source='sub\b.vtu'/>";
    let text = format!(
        "<VTKFile type='PUnstructuredGrid'><PUnstructuredGrid>{pieces}</PUnstructuredGrid></VTKFile>"
    );
    assert_eq!(open(&put(folder.path(), "ab.pvtu", text)).expect("opens").0.points, 11);
    let entry = r"<DataSet timestep='0' file='sub\a.vtu'/>";
    let text = format!("<VTKFile type='Collection'><Collection>{entry}</Collection></VTKFile>");
    assert_eq!(open(&put(folder.path(), "a.pvd", text)).expect("opens").0.points, 10);
}

/// Putting together what comments take apart must not copy all before each of them; this one would take hours.
#[test]
fn a_comment_at_every_number_is_no_bomb() {
    let folder = tempfile::tempdir().expect("a folder");
    let count = 500_000;
    let numbers = "1 2 3<!---->\n".repeat(count);
    let text = format!(
        "<VTKFile type='PolyData'><PolyData><Piece NumberOfPoints='{count}'><Points><DataArray type='Float32' \
         NumberOfComponents='3' format='ascii'>{numbers}</DataArray></Points></Piece></PolyData></VTKFile>"
    );
    let (info, _) = open(&put(folder.path(), "comments.vtp", text)).expect("opens");
    assert_eq!((info.points, info.centroid), (count, Some([1.0, 2.0, 3.0])));
}

/// Looking for each name among all would take minutes, as would keeping all that is empty.
#[test]
fn very_many_arrays_and_pieces_are_no_bomb() {
    let folder = tempfile::tempdir().expect("a folder");
    let arrays: String = (0..50_000)
        .map(|i| {
            format!(
                "<DataArray type='Int8' Name='{i}' NumberOfComponents='2' format='ascii'>1 {}</DataArray>",
                i % 9
            )
        })
        .collect();
    let text = format!(
        "<VTKFile type='PolyData'><PolyData>{}<Piece NumberOfPoints='1'><PointData>{arrays}</PointData><Points>\
         <DataArray type='Float32' NumberOfComponents='3' format='ascii'>1 2 3</DataArray></Points></Piece>\
         </PolyData></VTKFile>",
        "<Piece/>".repeat(1_000_000)
    );
    let path = put(folder.path(), "many.vtp", text);
    let info = Series::open(&path, &SeriesOptions::default()).and_then(|series| series.frame_info(0, true));
    let info = info.expect("opens");
    assert_eq!((info.points, info.attributes.len()), (1, 50_000));
    assert_eq!(info.attributes[49_999].max, Some(vec![Some(1.0), Some(f64::from(49_999 % 9))]));
}

#[test]
fn what_no_file_needs_is_refused_before_it_is_looked_into() {
    let folder = tempfile::tempdir().expect("a folder");
    let plain = String::from_utf8(Xml::plain(Format::Ascii).bytes()).expect("text");
    let attributes: String = (0..200_000).map(|i| format!(" a{i}=''")).collect();
    let long = "x".repeat(65 << 20);
    for (name, text, words) in [
        ("attributes.vtu", plain.replace("<Points>", &format!("<Points{attributes}>")), "attributes"),
        ("comment.vtu", plain.replace("<Points>", &format!("<!--{long}--><Points>")), "longer than"),
        ("open.vtu", format!("{plain}<!--{long}"), "longer than"),
    ] {
        let error = open(&put(folder.path(), name, text)).expect_err(name).to_string();
        assert!(error.contains(words) && error.contains("byte "), "{error}");
    }
}

/// The pieces of parallel files look like a longer series of their own.
#[test]
fn a_folder_with_parallel_files_is_not_a_series_of_pieces() {
    let folder = tempfile::tempdir().expect("a folder");
    for frame in 0..2 {
        let mut pieces = String::new();
        for piece in 0..3 {
            let name = format!("water_{frame}_{piece}.vtu");
            put(folder.path(), &name, Xml::plain(Format::AppendedRaw).bytes());
            pieces += &format!("<Piece Source='{name}'/>");
        }
        let text = format!(
            "<VTKFile type='PUnstructuredGrid'><PUnstructuredGrid>{pieces}</PUnstructuredGrid></VTKFile>"
        );
        put(folder.path(), &format!("water_{frame}.pvtu"), text);
    }
    let series = Series::open(folder.path(), &SeriesOptions::default()).expect("opens");
    assert_eq!(series.frame_count(), 2, "{:?}", series.choices());
    assert_eq!(series.frame_info(1, false).expect("reads").points, 30);
}

#[test]
fn faults_name_file_place_expected_and_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = |format| String::from_utf8(Xml::plain(format).bytes()).expect("text");
    let ascii = text(Format::Ascii);
    for (name, bytes, words) in [
        ("number.vtu", ascii.replace(" 1023.75 ", " 1023,75 "), &["Points", "value 4", "1023,75"][..]),
        ("short.vtu", ascii.replace(" 1023.75 ", " "), &["Points", "expected 30", "found 29"]),
        ("cut.vtu", ascii.split("</Points>").next().unwrap_or_default().to_owned(), &["cut off", "VTKFile"]),
        (
            "type.vtu",
            ascii.replace("'Float64' Name='Points'", "'Float80' Name='Points'"),
            &["Float80", "expected"],
        ),
        ("entity.vtu", format!("<!DOCTYPE x [<!ENTITY a 'a'>]>{ascii}"), &["document type"]),
        ("deep.vtu", "<a>".repeat(100_000), &["<a>", "VTKFile"]),
        ("deep2.vtu", ascii.replace("<Points>", &"<x>".repeat(100_000)), &["nested"]),
        ("legacy.vtk", legacy::ASCII.replace("POINTS 4 double", "POINTS 9999 double"), &["POINTS", "9999"]),
        (
            "count.vtk",
            legacy::ASCII.replace("POINTS 4 double", "POINTS -4 double"),
            &["number of points", "-4"],
        ),
        ("gzip.vtk", "\u{1f}\u{8b}".into(), &["VTK"]),
        ("empty.vtu", String::new(), &["empty"]),
        ("broken.vtu.series", "{\"files\": [".into(), &["line 1", "series"]),
        (
            "self.pvd",
            "<VTKFile type='Collection'><Collection><DataSet file='self.pvd'/></Collection></VTKFile>".into(),
            &["itself"],
        ),
    ] {
        let error = open(&put(folder.path(), name, bytes)).expect_err(name).to_string();
        for word in words.iter().chain([&name]) {
            assert!(error.contains(word), "{name}: no {word:?} in {error:?}");
        }
    }
    #[cfg(unix)]
    assert_eq!(open(Path::new("/dev/zero")).expect_err("a device").kind().as_str(), "io");
    let empty = tempfile::tempdir().expect("a folder");
    assert_eq!(open(empty.path()).expect_err("an empty folder").kind().as_str(), "empty");
    let error = open(&folder.path().join("nowhere.vtu")).expect_err("nothing there");
    assert_eq!(error.kind().as_str(), "not_found");
    let error = open(folder.path().join("nowhere_%03d.vtu").as_path()).expect_err("nothing there");
    assert_eq!(error.kind().as_str(), "empty");
}

#[test]
fn series_of_every_spelling() {
    let folder = tempfile::tempdir().expect("a folder");
    let bytes = Xml::plain(Format::Ascii).bytes();
    for number in [2, 9, 10, 11] {
        put(folder.path(), &format!("water_{number}.vtu"), &bytes);
    }
    put(folder.path(), "walls_1.vtu", &bytes);
    let names = |input: &str| -> Vec<String> {
        let series = Series::open(&folder.path().join(input), &SeriesOptions::default()).expect(input);
        let name = |i| series.files(i)[0].file_name().expect("a name").to_string_lossy().into_owned();
        (0..series.frame_count()).map(name).collect()
    };
    let expected = ["water_2.vtu", "water_9.vtu", "water_10.vtu", "water_11.vtu"];
    for input in ["", "*.vtu", "water_*.vtu", "water_%d.vtu", "water_%i.vtu"] {
        assert_eq!(names(input), expected, "{input:?}");
    }
    assert_eq!(names("water_%02d.vtu"), expected[2..]);
    assert_eq!(names("walls_1.vtu"), ["walls_1.vtu"]);
    let collection: String = [(3, "water_10.vtu"), (1, "water_2.vtu"), (2, "water_9.vtu")]
        .iter()
        .map(|(time, file)| format!("<DataSet timestep='{time}' part='0' file='{file}'/>"))
        .collect();
    let text = format!("<VTKFile type='Collection'><Collection>{collection}</Collection></VTKFile>");
    put(folder.path(), "water.pvd", text);
    assert_eq!(names("water.pvd"), expected[..3]);
}

/// An offset is a claim like any other: one that only fits modulo the data's length, or overflows, is refused by name.
#[test]
fn offsets_behind_the_data_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = String::from_utf8(Xml::plain(Format::AppendedBase64).bytes()).expect("text");
    let data = text.rsplit_once('_').expect("appended data").1.split_once('<').expect("its end").0.trim_end();
    let points =
        text.split_once("Name='Points'").expect("points").1.split_once("offset='").expect("its offset");
    let own: usize = points.1.split_once('\'').expect("a number").0.parse().expect("a number");
    for offset in [own + data.len(), 99_999_999, usize::MAX] {
        let (before, after) = text.split_once("Name='Points'").expect("points");
        let after = after.replacen(&format!("offset='{own}'"), &format!("offset='{offset}'"), 1);
        let file = put(folder.path(), "offset.vtu", format!("{before}Name='Points'{after}"));
        let error = open(&file).expect_err("nothing is there").to_string();
        assert!(error.contains("Points") && error.contains(&format!("offset {offset} is beyond")), "{error}");
    }
}

/// What is no file of numbers must be refused at once: opening a pipe, for one, would wait for a writer that never comes.
#[cfg(unix)]
#[test]
fn what_is_no_file_is_refused_at_once() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    use std::os::unix::net::UnixListener;

    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let fails = |name: &str| open(&at(name)).expect_err(name);
    let _socket = UnixListener::bind(at("socket.vtk")).expect("a socket");
    let made = std::process::Command::new("mkfifo").arg(at("pipe.vtk")).status().expect("mkfifo runs");
    assert!(made.success());
    for name in ["socket.vtk", "pipe.vtk"] {
        let error = fails(name);
        assert!(error.kind().as_str() == "io" && error.to_string().contains("regular file"), "{error}");
    }
    symlink(at("b.vtk"), at("a.vtk")).expect("a link");
    symlink(at("a.vtk"), at("b.vtk")).expect("a link");
    assert!(matches!(fails("a.vtk").kind().as_str(), "io" | "not_found"));
    put(folder.path(), "real.gz.vtu", [0x1f, 0x8b, 8, 0, 0, 0]);
    assert!(fails("real.gz.vtu").to_string().contains("gunzip"));
    put(folder.path(), "utf16.vtu", [0xff, 0xfe, b'<', 0]);
    assert!(fails("utf16.vtu").to_string().contains("UTF-8"));
    // A folder that holds itself, beside pipes and sockets: only what is a file counts.
    symlink(folder.path(), at("again")).expect("a link");
    std::fs::remove_file(at("real.gz.vtu"))
        .and_then(|()| std::fs::remove_file(at("utf16.vtu")))
        .expect("gone");
    assert_eq!(open(folder.path()).expect_err("nothing to read").kind().as_str(), "empty");
    let closed = put(folder.path(), "closed.vtu", Xml::plain(Format::Ascii).bytes());
    std::fs::set_permissions(&closed, std::fs::Permissions::from_mode(0o000)).expect("closed");
    // The superuser may read it all the same.
    assert!(
        open(&closed).is_ok_and(|(info, _)| info.points == 10) || fails("closed.vtu").kind().as_str() == "io"
    );
}
