//! Opening a series and reading its frame: a dam break with velocity, density, pressure and ids, positions in double
//! precision, in every format that our writer knows. Files come from the page cache: what is measured is decoding.
//!
//! | size | why |
//! |---|---|
//! | `300k` | fits into the caches of a server: what decoding costs at best |
//! | `1.1M` | the size users have, larger than any cache |

use std::cell::OnceCell;
use std::path::{Path, PathBuf};

use bench_views::{Stage, View};
use criterion::{Criterion, criterion_group, criterion_main};
use meniscus_core::{Cancel, FrameRequest, FrameSource};
use meniscus_io::writer::{self, Encoding, Format, Values, WriteAttribute, WriteParticles};
use meniscus_io::{IoMode, Series, SeriesOptions};

/// Names and particles.
const SIZES: [(&str, u64); 2] = [("300k", 300_000), ("1.1M", 1_131_712)];

const FORMATS: [(&str, &str, Format); 8] = [
    ("vtu-raw", "raw.vtu", Format::Vtu(Encoding::Raw)),
    ("vtu-zlib", "zlib.vtu", Format::Vtu(Encoding::Zlib)),
    ("vtu-lz4", "lz4.vtu", Format::Vtu(Encoding::Lz4)),
    ("vtu-lzma", "lzma.vtu", Format::Vtu(Encoding::Lzma)),
    ("vtu-base64", "base64.vtu", Format::Vtu(Encoding::Base64)),
    ("vtu-ascii", "ascii.vtu", Format::Vtu(Encoding::Ascii)),
    ("vtk-binary", "binary.vtk", Format::LegacyBinary),
    ("vtk-ascii", "ascii.vtk", Format::LegacyAscii),
];

/// Ways of reading besides the plain one: in blocks instead of mapped, and only some of the particles.
const WAYS: [&str; 2] = ["in-blocks", "selected"];

fn options_of(way: &str) -> SeriesOptions {
    if way == "in-blocks" {
        SeriesOptions { io_mode: IoMode::Read, ..mapped() }
    } else {
        SeriesOptions { where_expr: Some("density < 990 or z < 0.06".into()), ..mapped() }
    }
}

/// Writes the case in every format, in their order.
fn write_all(folder: &Path, particles: u64) -> Vec<PathBuf> {
    std::fs::create_dir_all(folder).expect("a folder in the temporary folder");
    let view = View { particles, ..View::dam_break() };
    let frame = view.source().case_frame(view.frame, &Cancel::default()).expect("a frame of the case");
    let attribute = |name, components, values| WriteAttribute { name, components, values };
    let attributes = [
        attribute("velocity", 3, Values::F32(frame.velocities.as_flattened())),
        attribute("density", 1, Values::F32(&frame.density)),
        attribute("pressure", 1, Values::F32(&frame.pressure)),
        attribute("id", 1, Values::I64(&frame.ids)),
    ];
    let particles =
        WriteParticles { positions: &frame.positions, attributes: &attributes, time: Some(frame.time) };
    let written = FORMATS.map(|(_, name, format)| {
        let path = folder.join(name);
        writer::write(&path, &particles, format).expect("a file in the temporary folder");
        path
    });
    written.into()
}

/// Files that were just written would be read in blocks.
fn mapped() -> SeriesOptions {
    SeriesOptions { io_mode: IoMode::Map, ..SeriesOptions::default() }
}

fn open(path: &Path, options: &SeriesOptions) -> Series {
    Series::open(path, options).expect("a file that was just written")
}

/// Bytes per particle that reading cannot do without: positions in double and `velocity` in single precision come from the
/// file, in whatever form it has them; both go to memory in single precision.
fn bytes_per_particle(with_velocity: bool) -> u64 {
    let positions = size_of::<[f64; 3]>() + size_of::<[f32; 3]>();
    let velocity = if with_velocity { 2 * size_of::<[f32; 3]>() } else { 0 };
    (positions + velocity) as u64
}

fn io(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut stage = Stage::new(criterion, "io");
    for (size, particles) in SIZES {
        let particles = if bench_views::is_measured() { particles } else { 2_000 };
        let files = OnceCell::new();
        let files = || files.get_or_init(|| write_all(&folder.path().join(size), particles));
        for (index, (format, _, _)) in FORMATS.iter().enumerate() {
            // Origin, spacing, up axis: the survey of the first frame, of which it reads what it needs, is part of it.
            stage.cpu(
                [&format!("open-{format}"), size],
                particles,
                || &files()[index],
                |_| None,
                |path| open(path, &mapped()),
            );
            for (what, attributes) in [("positions", vec![]), ("velocity", vec!["velocity".to_owned()])] {
                let bytes = bytes_per_particle(!attributes.is_empty()) * particles;
                let request = FrameRequest { attributes };
                stage.cpu(
                    [&format!("read-{what}-{format}"), size],
                    particles,
                    || open(&files()[index], &mapped()),
                    |_| Some(bytes),
                    |series| series.read(0, &request, &Cancel::default()).expect("a readable frame"),
                );
            }
            for way in WAYS {
                stage.cpu(
                    [&format!("read-{way}-{format}"), size],
                    particles,
                    || open(&files()[index], &options_of(way)),
                    |_| None,
                    |series| {
                        series
                            .read(0, &FrameRequest::default(), &Cancel::default())
                            .expect("a readable frame")
                    },
                );
            }
        }
    }
}

criterion_group!(benches, io);
criterion_main!(benches);
