//! What the targets share: a file in memory, and everything a caller may do with it.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use meniscus_core::{Cancel, FrameRequest, FrameSource};
use meniscus_io::{IoMode, Series, SeriesOptions};

/// A folder in memory where there is one: a disk would be worn out by millions of files.
pub fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let memory = Path::new("/dev/shm");
        let base = if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() };
        tempfile::Builder::new().prefix("meniscus-fuzz-").tempdir_in(base).expect("a folder").keep()
    })
}

/// Opens `name` with `bytes` in it, describes its frames and reads them with all attributes. The number of bytes says whether
/// the file is mapped, and whether particles are selected.
pub fn open(name: &str, bytes: &[u8]) {
    let path = folder().join(name);
    std::fs::write(&path, bytes).expect("a file in memory");
    let options = SeriesOptions {
        io_mode: if bytes.len() % 2 == 0 { IoMode::Map } else { IoMode::Read },
        where_expr: (bytes.len() % 4 < 2).then(|| "x >= 0 or id in (1, 3)".to_owned()),
        ..SeriesOptions::default()
    };
    let Ok(series) = Series::open(&path, &options) else { return };
    for index in 0..series.frame_count().min(3) {
        let Ok(info) = series.frame_info(index, true) else { continue };
        let attributes = info.attributes.iter().map(|a| a.name.clone()).collect();
        let request = FrameRequest { attributes, ..FrameRequest::default() };
        let frame = series.read(index, &request, &Cancel::default());
        let frame = frame.expect("what `info` reads can be read");
        assert!(frame.len() <= info.points, "{} of {}", frame.len(), info.points);
    }
}
