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
use meniscus_io::writer::{
    Values, WriteAttribute, WriteParticles, write_legacy_binary, write_vtu_raw, write_vtu_zlib,
};
use meniscus_io::{Error, Series, SeriesOptions};

/// Names and particles.
const SIZES: [(&str, u64); 2] = [("300k", 300_000), ("1.1M", 1_131_712)];

type Write = fn(&Path, &WriteParticles<'_>) -> Result<(), Error>;

const FORMATS: [(&str, &str, Write); 3] = [
    ("vtu-raw", "raw.vtu", write_vtu_raw),
    ("vtu-zlib", "zlib.vtu", write_vtu_zlib),
    ("vtk-binary", "legacy.vtk", write_legacy_binary),
];

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
    let written = FORMATS.map(|(_, name, write)| {
        let path = folder.join(name);
        write(&path, &particles).expect("a file in the temporary folder");
        path
    });
    written.into()
}

fn open(path: &Path) -> Series {
    Series::open(path, &SeriesOptions::default()).expect("a file that was just written")
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
                |path| open(path),
            );
            for (what, attributes) in [("positions", vec![]), ("velocity", vec!["velocity".to_owned()])] {
                let bytes = bytes_per_particle(!attributes.is_empty()) * particles;
                let request = FrameRequest { attributes };
                stage.cpu(
                    [&format!("read-{what}-{format}"), size],
                    particles,
                    || open(&files()[index]),
                    |_| Some(bytes),
                    |series| series.read(0, &request, &Cancel::default()).expect("a readable frame"),
                );
            }
        }
    }
}

criterion_group!(benches, io);
criterion_main!(benches);
