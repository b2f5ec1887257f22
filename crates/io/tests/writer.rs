//! What is written is read back, number by number, in every format.

use std::path::Path;

use meniscus_core::{Cancel, Flaw, FrameRequest, FrameSource};
use meniscus_io::writer::{
    Encoding, Format, Values, WriteAttribute, WriteParticles, write, write_legacy_binary, write_pvd,
    write_vtu_raw,
};
use meniscus_io::{Error, Series, SeriesOptions, SetSpec};

type Write = fn(&Path, &WriteParticles<'_>) -> Result<(), Error>;
const FORMATS: [(&str, Write); 12] = [
    ("raw.vtu", write_vtu_raw),
    ("zlib.vtu", |path, p| write(path, p, Format::Vtu(Encoding::Zlib))),
    ("lz4.vtu", |path, p| write(path, p, Format::Vtu(Encoding::Lz4))),
    ("lzma.vtu", |path, p| write(path, p, Format::Vtu(Encoding::Lzma))),
    ("ascii.vtu", |path, p| write(path, p, Format::Vtu(Encoding::Ascii))),
    ("base64.vtu", |path, p| write(path, p, Format::Vtu(Encoding::Base64))),
    ("raw.vtp", |path, p| write(path, p, Format::Vtp(Encoding::Raw))),
    ("zlib.vtp", |path, p| write(path, p, Format::Vtp(Encoding::Zlib))),
    ("ascii.vtp", |path, p| write(path, p, Format::Vtp(Encoding::Ascii))),
    ("base64.vtp", |path, p| write(path, p, Format::Vtp(Encoding::Base64))),
    ("binary.vtk", write_legacy_binary),
    ("ascii.vtk", |path, p| write(path, p, Format::LegacyAscii)),
];

/// A lattice at map coordinates, with ids that count down.
struct Case {
    positions: Vec<[f64; 3]>,
    velocity: Vec<f32>,
    kind: Vec<u8>,
    id: Vec<i64>,
}

impl Case {
    fn new(side: usize) -> Self {
        let at = |i: usize| [i % side, i / side % side, i / side / side].map(|c| c as f64);
        let count = side * side * side;
        Self {
            positions: (0..count)
                .map(|i| {
                    let [x, y, z] = at(i);
                    [500_000.0 + 0.1 * x, 3_400_000.0 + 0.1 * y, 0.1 * z]
                })
                .collect(),
            velocity: (0..3 * count).map(|i| i as f32 * 0.5).collect(),
            kind: (0..count).map(|i| (i % 3) as u8).collect(),
            id: (0..count).map(|i| (1 << 40) - i as i64).collect(),
        }
    }

    fn write(&self, path: &Path, write: Write) {
        let attributes = [
            WriteAttribute { name: "velocity", components: 3, values: Values::F32(&self.velocity) },
            WriteAttribute {
                name: "kind of \"<particle>\" %",
                components: 1,
                values: Values::U8(&self.kind),
            },
            WriteAttribute { name: "id", components: 1, values: Values::I64(&self.id) },
        ];
        let particles =
            WriteParticles { positions: &self.positions, attributes: &attributes, time: Some(0.25) };
        write(path, &particles).expect("written");
    }
}

#[test]
fn everything_comes_back() {
    let case = Case::new(20);
    let folder = tempfile::tempdir().expect("a folder");
    for (name, write) in FORMATS {
        let path = folder.path().join(name);
        case.write(&path, write);
        let series = Series::open(&path, &SeriesOptions::default()).expect(name);
        let kind = "kind of \"<particle>\" %";
        let request = FrameRequest { attributes: vec!["velocity".into(), kind.into()] };
        let frame = series.read(0, &request, &Cancel::default()).expect(name);
        assert_eq!(frame.time, Some(0.25), "{name}");
        let water = &frame.sets[0].particles;
        assert_eq!(water.len(), case.positions.len(), "{name}");
        for (i, position) in water.positions.iter().enumerate() {
            let origin = frame.origin.to_array();
            let expected: [f32; 3] =
                std::array::from_fn(|axis| (case.positions[i][axis] - origin[axis]) as f32);
            assert_eq!(*position, expected, "{name}, particle {i}");
        }
        let ids: Vec<u64> = case.id.iter().map(|&id| id as u64).collect();
        assert_eq!(water.ids, ids, "{name}");
        assert_eq!(water.attributes[0].values, case.velocity, "{name}");
        assert_eq!(
            water.attributes[1].values.iter().map(|&v| v as u8).collect::<Vec<_>>(),
            case.kind,
            "{name}"
        );
        let info = series.frame_info(0, true).expect(name);
        // 0.1 times a whole number up to 19, added to map coordinates: the doubles written, exactly.
        assert_eq!(info.bounds, Some([500_000.0, 500_001.9, 3_400_000.0, 3_400_001.9, 0.0, 0.1 * 19.0]));
        let counts: Vec<u64> = info.attributes[1].values.iter().map(|v| v.count).collect();
        assert_eq!(counts, [2667, 2667, 2666], "{name}");
        assert!((info.spacing / 0.1 - 1.0).abs() < 0.05, "{name}: {}", info.spacing);
    }
}

#[test]
fn selections_split_the_particles() {
    let case = Case::new(12);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.vtu");
    case.write(&path, write_vtu_raw);
    let counts = |where_expr: Option<&str>, sets: &[&str]| {
        let sets = sets.iter().map(|set| SetSpec::parse(set).expect("a set")).collect();
        let options = SeriesOptions { where_expr: where_expr.map(Into::into), sets, ..Default::default() };
        let series = Series::open(&path, &options)?;
        let frame = series.read(0, &FrameRequest::default(), &Cancel::default()).expect("read");
        for set in &frame.sets {
            for (i, position) in set.particles.positions.iter().enumerate() {
                // The identity tells which particle of the file this is.
                let of_file = ((1_u64 << 40) - set.particles.ids[i]) as usize;
                let expected = (case.positions[of_file][0] - frame.origin.x) as f32;
                assert_eq!(position[0], expected, "set {}", set.name);
            }
        }
        Ok::<_, Error>(frame.sets.iter().map(|s| (s.name.clone(), s.particles.len())).collect::<Vec<_>>())
    };
    let count = |f: &dyn Fn(usize) -> bool| (0..1728).filter(|&i| f(i)).count();
    let named = |name: &str, n: usize| (name.to_owned(), n);
    assert_eq!(counts(None, &[]).expect("all"), [named("water", 1728)]);
    let low = |i: usize| i / 144 < 4;
    assert_eq!(counts(Some("z < 0.35"), &[]).expect("z"), [named("water", count(&low))]);
    assert_eq!(
        counts(None, &["fast=velocity.x > 1000:spheres", "low=z < 0.35:solid"]).expect("sets"),
        [
            named("water", count(&|i| i as f32 * 1.5 <= 1000.0 && !low(i))),
            named("fast", count(&|i| i as f32 * 1.5 > 1000.0)),
            named("low", count(&|i| i as f32 * 1.5 <= 1000.0 && low(i))),
        ]
    );
    let unknown = counts(Some("nothing == 1"), &[]).expect_err("no such attribute").to_string();
    assert!(unknown.contains("column 1") && unknown.contains("velocity"), "{unknown}");
}

#[test]
fn a_second_series_becomes_a_set() {
    let (water, soil) = (Case::new(6), Case::new(5));
    let folder = tempfile::tempdir().expect("a folder");
    for frame in 0..3 {
        water.write(&folder.path().join(format!("water_{frame}.vtu")), write_vtu_raw);
        soil.write(&folder.path().join(format!("soil_{frame}.vtk")), write_legacy_binary);
    }
    let pattern = format!("soil={}:solid", folder.path().join("soil_*.vtk").display());
    let options =
        SeriesOptions { sets: vec![SetSpec::parse(&pattern).expect("a set")], ..Default::default() };
    let series = Series::open(folder.path(), &options).expect("opens");
    assert_eq!(series.frame_count(), 3);
    assert!(series.choices()[0].value.starts_with("water_"), "{}", series.choices()[0]);
    let request = FrameRequest { attributes: vec!["velocity".into()] };
    let frame = series.read(2, &request, &Cancel::default()).expect("read");
    assert_eq!(frame.sets.iter().map(|s| s.particles.len()).collect::<Vec<_>>(), [216, 125]);
    assert_eq!(frame.files.len(), 2);
}

#[test]
fn broken_points_are_dropped_and_counted() {
    let mut case = Case::new(8);
    case.positions[5][1] = f64::NAN;
    case.positions[100][2] = f64::INFINITY;
    let folder = tempfile::tempdir().expect("a folder");
    for (name, write) in FORMATS {
        let path = folder.path().join(name);
        case.write(&path, write);
        let series = Series::open(&path, &SeriesOptions::default()).expect(name);
        let frame = series.read(0, &FrameRequest::default(), &Cancel::default()).expect(name);
        assert_eq!(frame.len(), 510, "{name}");
        assert_eq!(frame.flaws.iter().collect::<Vec<_>>(), [&Flaw::NonFiniteDropped { count: 2 }], "{name}");
        assert_eq!(
            frame.sets[0].particles.ids[5],
            (1 << 40) - 6,
            "{name}: identities move up with the points"
        );
        let info = series.frame_info(0, false).expect(name);
        assert_eq!((info.points, info.finite_points, info.dropped), (512, 510, 2), "{name}");
    }
}

#[test]
fn nothing_at_all_is_a_frame_too() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, write) in FORMATS {
        let path = folder.path().join(name);
        write(&path, &WriteParticles::default()).expect(name);
        let series = Series::open(&path, &SeriesOptions::default()).expect(name);
        let frame = series.read(0, &FrameRequest::default(), &Cancel::default()).expect(name);
        assert!(frame.is_empty(), "{name}");
        assert_eq!(series.frame_info(0, true).expect(name).bounds, None, "{name}");
    }
}

#[test]
fn attributes_of_the_wrong_length_are_refused_and_leave_no_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let attributes = [WriteAttribute { name: "p", components: 1, values: Values::F32(&[1.0]) }];
    let particles =
        WriteParticles { positions: &[[0.0; 3]; 2], attributes: &attributes, ..Default::default() };
    for (name, write) in FORMATS {
        assert!(write(&folder.path().join(name), &particles).is_err(), "{name}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
}

#[test]
fn a_cancelled_read_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.vtu");
    Case::new(8).write(&path, write_vtu_raw);
    let series = Series::open(&path, &SeriesOptions::default()).expect("opens");
    let cancel = Cancel::default();
    cancel.cancel();
    let error = series.read(0, &FrameRequest::default(), &cancel).expect_err("cancelled");
    assert_eq!(error.kind.as_str(), "cancelled");
}

#[test]
fn text_holds_every_number() {
    let folder = tempfile::tempdir().expect("a folder");
    let numbers = [0.1, -1e300, 5e-324, f64::MAX, 1e15, 123_456_789.123_456_78, -0.0, 1e-4];
    let singles: Vec<f32> = numbers.map(|v| (v as f32).clamp(f32::MIN, f32::MAX)).to_vec();
    let attributes = [
        WriteAttribute { name: "d", components: 1, values: Values::F64(&numbers) },
        WriteAttribute { name: "f", components: 1, values: Values::F32(&singles) },
        WriteAttribute { name: "n", components: 1, values: Values::F32(&[f32::NAN; 8]) },
    ];
    let positions = numbers.map(|v| [v / 1e280, 0.0, 0.0]);
    let particles = WriteParticles { positions: &positions, attributes: &attributes, time: None };
    for (name, format) in [("a.vtk", Format::LegacyAscii), ("a.vtu", Format::Vtu(Encoding::Ascii))] {
        let path = folder.path().join(name);
        write(&path, &particles, format).expect(name);
        let series = Series::open(&path, &SeriesOptions::default()).expect(name);
        let request = FrameRequest { attributes: vec!["f".into(), "n".into()] };
        let frame = series.read(0, &request, &Cancel::default()).expect(name);
        assert_eq!(frame.sets[0].particles.attributes[0].values, singles, "{name}");
        assert!(frame.sets[0].particles.attributes[1].values.iter().all(|v| v.is_nan()), "{name}");
        let info = series.frame_info(0, true).expect(name);
        assert_eq!(info.attributes[0].min, Some(vec![Some(-1e300)]), "{name}");
        assert_eq!(info.attributes[0].max, Some(vec![Some(f64::MAX)]), "{name}");
    }
}

#[test]
fn conversion_keeps_numbers_types_and_the_selection() {
    let case = Case::new(9);
    let folder = tempfile::tempdir().expect("a folder");
    let source = folder.path().join("source.vtu");
    case.write(&source, write_vtu_raw);
    let options = SeriesOptions { where_expr: Some("z < 0.35".into()), ..Default::default() };
    let selected = Series::open(&source, &options).expect("opens");
    let listed = |path: &Path| {
        let series = Series::open(path, &SeriesOptions::default()).expect("opens");
        let mut info = series.frame_info(0, true).expect("reads");
        info.file.clear();
        (info.points, info.time, info.bounds, info.centroid, format!("{:?}", info.attributes))
    };
    let first = folder.path().join("first.vtu");
    let cancel = Cancel::default();
    let count = selected.convert_frame(0, &first, Format::Vtu(Encoding::Raw), &cancel).expect("converts");
    assert_eq!(count, 4 * 81);
    let expected = listed(&first);
    assert_eq!((expected.0, expected.1), (count, Some(0.25)));
    assert!(expected.4.contains("\"UInt8\"") && expected.4.contains("\"Int64\""), "{}", expected.4);
    // Around through every format and back: nothing is lost on the way.
    let around = Series::open(&first, &SeriesOptions::default()).expect("opens");
    for (name, format) in [
        ("a.vtk", Format::LegacyAscii),
        ("b.vtk", Format::LegacyBinary),
        ("c.vtp", Format::Vtp(Encoding::Ascii)),
        ("d.vtp", Format::Vtp(Encoding::Zlib)),
        ("e.vtu", Format::Vtu(Encoding::Base64)),
        ("f.vtu", Format::Vtu(Encoding::Lz4)),
        ("g.vtu", Format::Vtu(Encoding::Lzma)),
    ] {
        let path = folder.path().join(name);
        around.convert_frame(0, &path, format, &cancel).expect(name);
        assert_eq!(listed(&path), expected, "{name}");
    }
}

#[test]
fn collections_come_back_with_times() {
    let folder = tempfile::tempdir().expect("a folder");
    Case::new(3).write(&folder.path().join("a & b.vtu"), write_vtu_raw);
    Case::new(4).write(&folder.path().join("c.vtu"), write_vtu_raw);
    let path = folder.path().join("all.pvd");
    write_pvd(&path, &[(0.5, "a & b.vtu".into()), (1.25, "c.vtu".into())]).expect("written");
    let series = Series::open(&path, &SeriesOptions::default()).expect("opens");
    assert_eq!(series.times(), [Some(0.5), Some(1.25)]);
    let read = |i| series.read(i, &FrameRequest::default(), &Cancel::default()).expect("reads").len();
    assert_eq!((read(0), read(1)), (27, 64));
}

/// A socket stands for all that is no file: pipes, devices, folders.
#[cfg(unix)]
#[test]
fn only_files_are_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.vtu");
    let _socket = std::os::unix::net::UnixListener::bind(&path).unwrap();
    let particles = WriteParticles { positions: &[[0.0; 3]], attributes: &[], time: None };
    let error = write_vtu_raw(&path, &particles).unwrap_err().to_string();
    assert!(error.contains("out.vtu") && error.contains("no regular file"), "{error}");
    assert!(!path.metadata().unwrap().is_file());
}
