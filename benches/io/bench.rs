//! Opening a series and reading its frame: 300,000 particles of a dam break with velocity, density, pressure and ids in
//! double precision, in the formats that simulations write. Files come from the page cache: what is measured is decoding.

use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::Duration;

use bench_views::View;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use meniscus_core::{Cancel, FrameRequest, FrameSource};
use meniscus_io::writer::{
    Values, WriteAttribute, WriteParticles, write_legacy_binary, write_vtu_raw, write_vtu_zlib,
};
use meniscus_io::{Error, Series, SeriesOptions};

type Write = fn(&Path, &WriteParticles<'_>) -> Result<(), Error>;

const FORMATS: [(&str, &str, Write); 3] = [
    ("vtu-raw", "raw.vtu", write_vtu_raw),
    ("vtu-zlib", "zlib.vtu", write_vtu_zlib),
    ("vtk-binary", "legacy.vtk", write_legacy_binary),
];

/// Writes the case in every format.
fn write_all(folder: &Path, particles: u64) -> Vec<(&'static str, PathBuf)> {
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
    let written = FORMATS.map(|(format, name, write)| {
        let path = folder.join(name);
        write(&path, &particles).expect("a file in the temporary folder");
        (format, path)
    });
    written.into()
}

fn open(path: &Path) -> Series {
    Series::open(path, &SeriesOptions::default()).expect("a file that was just written")
}

fn io(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let particles = if bench_views::is_measured() { 300_000 } else { 2_000 };
    let files = write_all(folder.path(), particles);
    let mut group = criterion.benchmark_group("io");
    group
        .sample_size(10)
        .measurement_time(Duration::from_secs(3))
        .throughput(Throughput::Elements(particles));
    for (format, path) in &files {
        // Origin, spacing, up axis: the survey of the first frame is part of it.
        group.bench_function(format!("open/{format}"), |b| b.iter(|| black_box(open(path))));
        let series = open(path);
        for (what, attributes) in [("positions", vec![]), ("velocity", vec!["velocity".to_owned()])] {
            let request = FrameRequest { attributes };
            group.bench_function(format!("read-{what}/{format}"), |b| {
                b.iter(|| black_box(series.read(0, &request, &Cancel::default()).expect("a readable frame")));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, io);
criterion_main!(benches);
