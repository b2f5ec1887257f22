//! Differential tests with `vtkio`, which shares no code with us: it reads what we write, we read what it writes. Only of what
//! it can do: no raw or compressed data, no legacy poly data of version 5.1, no `vtktypeint64` in fields of legacy files.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use meniscus_core::{Cancel, FrameRequest, FrameSource};
use meniscus_io::writer::{Encoding, Format, Values, WriteAttribute, WriteParticles, write};
use meniscus_io::{Series, SeriesOptions};
use vtkio::model::{
    Attribute, Attributes, ByteOrder, CellType, Cells, DataArray, DataSet, FieldArray, IOBuffer, Piece,
    PolyDataPiece, UnstructuredGridPiece, Version, VertexNumbers, Vtk,
};

/// Numbers that do not fit into each other's types: what is cast on the way does not come back.
struct Case {
    positions: Vec<[f64; 3]>,
    velocity: Vec<f32>,
    density: Vec<f64>,
    kind: Vec<i32>,
    id: Vec<i64>,
}

impl Case {
    fn new(count: usize) -> Self {
        Self {
            positions: (0..count).map(|i| [i as f64 / 3.0, -1e-3 * i as f64, 5e5 + i as f64 / 7.0]).collect(),
            velocity: (0..3 * count).map(|i| i as f32 / 3.0 - 7.0).collect(),
            density: (0..count).map(|i| 1000.0 + 1.0 / (i + 3) as f64).collect(),
            kind: (0..count).map(|i| i as i32 % 3 - 1).collect(),
            id: (0..count).map(|i| (1 << 33) + i as i64).collect(),
        }
    }
}

/// What another reader makes of a file: coordinates, and every attribute in double precision.
type Content = (Vec<f64>, Vec<(String, Vec<f64>)>);

/// `work` of vtkio, whose panics are its own.
fn guarded<T>(what: &str, work: impl FnOnce() -> Result<T, vtkio::Error>) -> T {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(result) => result.unwrap_or_else(|e| panic!("vtkio refuses {what}: {e}")),
        Err(_) => panic!("vtkio panics at {what}"),
    }
}

fn doubles(buffer: &IOBuffer) -> Vec<f64> {
    buffer.cast_into().expect("numbers")
}

fn by_vtkio(path: &Path) -> Content {
    let what = path.display().to_string();
    let vtk = guarded(&what, || Vtk::import(path));
    let (points, data) = match vtk.data {
        DataSet::UnstructuredGrid { pieces, .. } => {
            let piece = pieces.into_iter().next().expect("a piece");
            let piece = guarded(&what, || Ok(piece.into_loaded_piece_data(None)?));
            (piece.points, piece.data)
        }
        DataSet::PolyData { pieces, .. } => {
            let piece = pieces.into_iter().next().expect("a piece");
            let piece = guarded(&what, || Ok(piece.into_loaded_piece_data(None)?));
            (piece.points, piece.data)
        }
        other => panic!("{what}: {other:?}"),
    };
    let mut attributes = Vec::new();
    for attribute in data.point {
        match attribute {
            Attribute::DataArray(array) => attributes.push((array.name, doubles(&array.data))),
            Attribute::Field { data_array, .. } => {
                attributes.extend(data_array.into_iter().map(|array| (array.name, doubles(&array.data))));
            }
        }
    }
    (doubles(&points), attributes)
}

#[test]
fn vtkio_reads_what_we_write() {
    let case = Case::new(500);
    let folder = tempfile::tempdir().expect("a folder");
    let attribute = |name, components, values| WriteAttribute { name, components, values };
    let attributes = [
        attribute("velocity", 3, Values::F32(&case.velocity)),
        attribute("density", 1, Values::F64(&case.density)),
        attribute("kind", 1, Values::I32(&case.kind)),
        attribute("id", 1, Values::I64(&case.id)),
    ];
    for (name, format) in [
        ("binary.vtk", Format::LegacyBinary),
        ("ascii.vtk", Format::LegacyAscii),
        ("base64.vtu", Format::Vtu(Encoding::Base64)),
        ("ascii.vtu", Format::Vtu(Encoding::Ascii)),
        ("base64.vtp", Format::Vtp(Encoding::Base64)),
        ("ascii.vtp", Format::Vtp(Encoding::Ascii)),
    ] {
        let path = folder.path().join(name);
        let known = if name.ends_with(".vtk") { 3 } else { 4 };
        let attributes = &attributes[..known];
        write(&path, &WriteParticles { positions: &case.positions, attributes, time: None }, format)
            .expect(name);
        let (positions, found) = by_vtkio(&path);
        assert_eq!(positions, case.positions.as_flattened(), "{name}");
        let expected: [(&str, Vec<f64>); 4] = [
            ("velocity", case.velocity.iter().map(|v| f64::from(*v)).collect()),
            ("density", case.density.clone()),
            ("kind", case.kind.iter().map(|v| f64::from(*v)).collect()),
            ("id", case.id.iter().map(|v| *v as f64).collect()),
        ];
        let found: Vec<(&str, Vec<f64>)> =
            found.iter().map(|(n, values)| (n.as_str(), values.clone())).collect();
        assert_eq!(found, expected[..known], "{name}");
    }
}

/// The data set that holds `case` as vtkio has it.
fn of_vtkio(case: &Case, poly_data: bool, legacy: bool) -> DataSet {
    let count = case.positions.len();
    let points = IOBuffer::F64(case.positions.as_flattened().to_vec());
    let mut data = Attributes::new();
    if legacy {
        data.point.push(Attribute::Field {
            name: "FieldData".into(),
            data_array: vec![
                FieldArray::new("density", 1).with_data(IOBuffer::F64(case.density.clone())),
                FieldArray::new("kind", 1).with_data(IOBuffer::I32(case.kind.clone())),
                FieldArray::new("id", 1).with_data(IOBuffer::I64(case.id.clone())),
            ],
        });
    } else {
        let array = |name: &str, data| Attribute::DataArray(DataArray::scalars(name, 1).with_buf(data));
        data.point.push(array("density", IOBuffer::F64(case.density.clone())));
        data.point.push(array("kind", IOBuffer::I32(case.kind.clone())));
        data.point.push(array("id", IOBuffer::I64(case.id.clone())));
    }
    let velocity = DataArray::vectors("velocity").with_buf(IOBuffer::F32(case.velocity.clone()));
    data.point.push(Attribute::DataArray(velocity));
    let cell_verts = VertexNumbers::XML {
        connectivity: (0..count as u64).collect(),
        offsets: (1..=count as u64).collect(),
    };
    if poly_data {
        let piece = PolyDataPiece { points, verts: Some(cell_verts), data, ..PolyDataPiece::default() };
        return DataSet::PolyData { meta: None, pieces: vec![Piece::Inline(Box::new(piece))] };
    }
    let cells = Cells { cell_verts, types: vec![CellType::Vertex; count] };
    let piece = UnstructuredGridPiece { points, cells, data };
    DataSet::UnstructuredGrid { meta: None, pieces: vec![Piece::Inline(Box::new(piece))] }
}

#[test]
fn we_read_what_vtkio_writes() {
    let case = Case::new(500);
    let folder = tempfile::tempdir().expect("a folder");
    for poly_data in [false, true] {
        for (name, version, order) in [
            ("big.vtk", Version::new_legacy(4, 2), ByteOrder::BigEndian),
            ("ascii.vtk", Version::new_legacy(4, 2), ByteOrder::BigEndian),
            ("little.vtu", Version::new_xml(1, 0), ByteOrder::LittleEndian),
            ("big.vtu", Version::new_xml(1, 0), ByteOrder::BigEndian),
        ] {
            let legacy = name.ends_with("vtk");
            let name = if poly_data { name.replace("vtu", "vtp") } else { name.to_owned() };
            let path = folder.path().join(&name);
            let data = of_vtkio(&case, poly_data, legacy);
            let vtk = Vtk { version, byte_order: order, title: "particles".into(), data, file_path: None };
            guarded(&name, || if name == "ascii.vtk" { vtk.export_ascii(&path) } else { vtk.export(&path) });
            let series = Series::open(&path, &SeriesOptions::default()).unwrap_or_else(|e| panic!("{e}"));
            let attributes = ["velocity", "density", "kind"].map(str::to_owned).to_vec();
            let frame = series.read(0, &FrameRequest { attributes }, &Cancel::default()).expect(&name);
            let water = &frame.sets[0].particles;
            let origin = frame.origin.to_array();
            for (i, found) in water.positions.iter().enumerate() {
                let expected: [f32; 3] = std::array::from_fn(|a| (case.positions[i][a] - origin[a]) as f32);
                assert_eq!(*found, expected, "{name}, point {i}");
            }
            let ids: Vec<u64> = case.id.iter().map(|&id| id as u64).collect();
            assert_eq!(water.ids, ids, "{name}");
            let density: Vec<f32> = case.density.iter().map(|&v| v as f32).collect();
            let kind: Vec<f32> = case.kind.iter().map(|&v| v as f32).collect();
            let found: Vec<&[f32]> = water.attributes.iter().map(|a| a.values.as_slice()).collect();
            assert_eq!(found, [&case.velocity, &density, &kind], "{name}");
        }
    }
}
