//! Small legacy files.

/// An ASCII file with every kind of section around 4 points.
pub const ASCII: &str = "# vtk DataFile Version 5.1
every section
ASCII
DATASET POLYDATA
FIELD FieldData 2
TimeValue 1 1 double
0.5
Notes 1 2 string
POINTS%2099%20float
two words
POINTS 4 double
0 0 0  1 0 0
0 1 0
+1. .5 1e0
METADATA
INFORMATION 1
NAME L2_NORM_RANGE LOCATION vtkDataArray
DATA 2 0 1.5

VERTICES 5 4
OFFSETS vtktypeint64
0 1 2 3 4
METADATA
INFORMATION 0

CONNECTIVITY vtktypeint64
0 1 2 3
CELL_DATA 4
SCALARS cell int 1
LOOKUP_TABLE default
9 9 9 9
POINT_DATA 4
SCALARS pressure float
LOOKUP_TABLE colours
1 2 3 4
LOOKUP_TABLE colours 1
0 0 0 1
VECTORS velocity double
1 2 3 4 5 6 7 8 9 10 11 12
METADATA
COMPONENT_NAMES
along%20x


INFORMATION 1
NAME L2_NORM_RANGE LOCATION vtkDataArray
DATA 2 0 1.5

NORMALS n float
0 0 1 0 0 1 0 0 1 0 0 1
TENSORS stress float
0 0 0 0 0 0 0 0 1
0 0 0 0 0 0 0 0 2
0 0 0 0 0 0 0 0 3
0 0 0 0 0 0 0 0 4
TEXTURE_COORDINATES uv 2 float
0 0 0 1 1 0 1 1
COLOR_SCALARS rgb 3
0 0 1 0 1 0 1 0 0 0.5 0.5 0.5
FIELD FieldData 2
id 1 4 vtkIdType
40 30 20 10
mass%20flow 1 4 float
5 6 7 8
METADATA
COMPONENT_NAMES
POINTS 4 float

";

/// The same points in old binary form, with bytes in front of the payload that look like blanks and like keywords.
pub fn binary() -> Vec<u8> {
    let mut file =
        b"# vtk DataFile Version 3.0\nold\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n".to_vec();
    // 0x20202020 and 0x0a0a0a0a are small numbers and blanks at once.
    for bits in [0x2020_2020_u32, 0, 0, 0x3f80_0000, 0x0a0a_0a0a, 0, 0, 0x3f80_0000, 0, 0, 0, 0x3f80_0000] {
        file.extend(bits.to_be_bytes());
    }
    file.extend(b"\nCELLS 4 8\n");
    for cell in 0_i32..4 {
        file.extend(1_i32.to_be_bytes());
        file.extend((0x0a0a_0a00 + cell).to_be_bytes());
    }
    file.extend(b"\nCELL_TYPES 4\n");
    (0..4).for_each(|_| file.extend(1_i32.to_be_bytes()));
    file.extend(b"\nPOINT_DATA 4\nSCALARS flag bit 1\nLOOKUP_TABLE default\n");
    file.push(0b1010_0000);
    file.extend(b"\nFIELD FieldData 2\nNotes 1 1 string\n");
    file.push(0b1100_0000 | 6);
    file.extend(b"POINTS\nPOINTS 1 4 short\n");
    [7_i16, 0x0a0a, 9, 10].iter().for_each(|v| file.extend(v.to_be_bytes()));
    file
}
