//! `.bgeo` and `.ply` files, in every form.

use std::io::Write;

/// Coordinates of point `i`; exact as `f32` and in few letters.
pub fn point(i: usize) -> [f32; 3] {
    [i as f32 * 0.25, 1.0 - (i % 100) as f32 * 0.5, (i % 7) as f32]
}

pub fn id(i: usize) -> i32 {
    (3 * i + 1) as i32
}

pub fn velocity(i: usize) -> [f32; 3] {
    [0.5, (i % 5) as f32, -0.25]
}

/// Two numbers that belong together.
pub fn life(i: usize) -> [f32; 2] {
    [(i % 3) as f32, 10.0]
}

/// A `.bgeo` file of `count` points.
pub fn bgeo(count: usize) -> Vec<u8> {
    let mut file = b"BgeoV".to_vec();
    // Version, points, primitives, groups of both, attributes of points, vertices, primitives and the whole.
    for number in [5, count as i32, 1, 0, 0, 4, 0, 0, 0] {
        file.extend(number.to_be_bytes());
    }
    let attribute = |file: &mut Vec<u8>, name: &str, size: u16, ty: i32| {
        file.extend((name.len() as u16).to_be_bytes());
        file.extend(name.as_bytes());
        file.extend(size.to_be_bytes());
        file.extend(ty.to_be_bytes());
    };
    attribute(&mut file, "id", 1, 1);
    file.extend([0; 4]);
    attribute(&mut file, "velocity", 3, 5);
    file.extend([0; 12]);
    attribute(&mut file, "object", 1, 4);
    file.extend(2_i32.to_be_bytes());
    for name in ["sea", "spray"] {
        file.extend((name.len() as u16).to_be_bytes());
        file.extend(name.as_bytes());
    }
    attribute(&mut file, "life", 2, 0);
    file.extend([0; 8]);
    for i in 0..count {
        for number in point(i).into_iter().chain([1.0]) {
            file.extend(number.to_be_bytes());
        }
        file.extend(id(i).to_be_bytes());
        velocity(i).iter().for_each(|number| file.extend(number.to_be_bytes()));
        file.extend(((i % 2) as i32).to_be_bytes());
        life(i).iter().for_each(|number| file.extend(number.to_be_bytes()));
    }
    // A particle system of all of them, as partio writes it, and the end.
    file.extend([0x00, 0x00, 0x80, 0x00, 0x00, 0xff]);
    file
}

/// `bytes` packed.
pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packer.write_all(bytes).and_then(|()| packer.finish()).expect("in memory")
}

/// How the numbers of a `.ply` file are written.
pub const PLY_FORMATS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

/// A `.ply` file of `count` points and one face, its header's lines ended by `end`.
pub fn ply(count: usize, format: &str, end: &str) -> Vec<u8> {
    let header = format!(
        "ply\nformat {format} 1.0\ncomment made for a test\nelement vertex {count}\nproperty uchar red\n\
         property double density\nproperty float x\nproperty float y\nproperty float z\nproperty float vel_x\n\
         property float vel_y\nproperty float vel_z\nproperty int32 id\nelement face 1\n\
         property list uchar int vertex_indices\nend_header\n"
    );
    let mut file = header.replace('\n', end).into_bytes();
    for i in 0..count {
        let (red, density) = ((i % 256) as u8, 1000.0 + i as f64);
        let floats: Vec<f32> = [point(i), velocity(i)].concat();
        if format == "ascii" {
            let numbers: Vec<String> = floats.iter().map(f32::to_string).collect();
            file.extend(format!("{red} {density} {} {}{end}", numbers.join(" "), id(i)).bytes());
            continue;
        }
        let mut value = |bytes: &[u8]| {
            if format == "binary_big_endian" {
                file.extend(bytes.iter().rev());
            } else {
                file.extend(bytes);
            }
        };
        value(&[red]);
        value(&density.to_le_bytes());
        floats.iter().for_each(|number| value(&number.to_le_bytes()));
        value(&id(i).to_le_bytes());
    }
    file.extend(if format == "ascii" { b"3 0 1 2\n".to_vec() } else { vec![0; 13] });
    file
}

/// A table of `count` points: `header`, and rows of identity, position and velocity with `between` between their values.
pub fn table(count: usize, header: &str, between: &str) -> Vec<u8> {
    let mut file = header.to_owned();
    for i in 0..count {
        let mut values = vec![id(i).to_string()];
        values.extend(point(i).iter().chain(&velocity(i)).map(f32::to_string));
        file += &values.join(between);
        file.push('\n');
    }
    file.into_bytes()
}
