//! Files that somebody writes to while they are read.

mod common;

use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use common::xml::{Format, Packing, Xml};
use meniscus_core::{Cancel, FrameRequest, FrameSource};
use meniscus_io::{IoMode, Series, SeriesOptions};

/// Many points, so that the file has many pages.
fn put(folder: &Path) -> PathBuf {
    let path = folder.join("frame.vtu");
    let bytes = Xml { pieces: &[20_000], ..Xml::plain(Format::AppendedRaw) }.bytes();
    std::fs::write(&path, bytes).expect("written");
    path
}

fn open(path: &Path, io_mode: IoMode) -> Series {
    Series::open(path, &SeriesOptions { io_mode, ..Default::default() }).expect("opens")
}

#[test]
fn a_file_that_shrinks_is_an_error_of_its_frame() {
    meniscus_io::map_guard::install().expect("installed");
    let folder = tempfile::tempdir().expect("a folder");
    for mode in [IoMode::Map, IoMode::Read, IoMode::Auto] {
        let path = put(folder.path());
        let series = open(&path, mode);
        let file = OpenOptions::new().write(true).open(&path).expect("opens");
        file.set_len(9000).expect("shortened");
        let error = series.read(0, &FrameRequest::default(), &Cancel::default()).expect_err("shortened");
        assert_eq!(error.file.as_deref(), Some(path.as_path()), "{mode:?}: {error}");
    }
}

/// Ends the writer when the reader panics, too: a failure, not a test that never ends.
struct StopAtEnd<'a>(&'a Cancel);

impl Drop for StopAtEnd<'_> {
    fn drop(&mut self) {
        self.0.cancel();
    }
}

/// A legacy file of 20 000 points in a row with their numbers.
fn legacy(form: &str, write: impl Fn(&mut Vec<u8>, f32)) -> Vec<u8> {
    let mut bytes =
        format!("# vtk DataFile Version 3.0\nrow\n{form}\nDATASET POLYDATA\nPOINTS 20000 float\n")
            .into_bytes();
    (0..20_000).for_each(|i| [i as f32, 0.0, 0.0].iter().for_each(|value| write(&mut bytes, *value)));
    bytes.extend(b"\nPOINT_DATA 20000\nSCALARS number float\nLOOKUP_TABLE default\n");
    (0..20_000).for_each(|i| write(&mut bytes, i as f32));
    bytes
}

/// The file is in use on another thread when it shrinks and grows: whatever is read, the process lives and every frame
/// that is delivered is whole.
#[test]
fn shrinking_under_the_reader_does_not_end_the_process() {
    meniscus_io::map_guard::install().expect("installed");
    let folder = tempfile::tempdir().expect("a folder");
    let xml = |format, packing| {
        Xml { pieces: &[9_000, 11_000], packing, block: 4000, ..Xml::plain(format) }.bytes()
    };
    let files = [
        ("vtu", xml(Format::AppendedRaw, Packing::None)),
        ("vtu", xml(Format::AppendedRaw, Packing::Zlib)),
        ("vtu", xml(Format::AppendedBase64, Packing::Lz4)),
        ("vtu", xml(Format::Inline, Packing::None)),
        ("vtu", xml(Format::Ascii, Packing::None)),
        ("vtk", legacy("BINARY", |bytes, value| bytes.extend(value.to_be_bytes()))),
        ("vtk", legacy("ASCII", |bytes, value| bytes.extend(format!("{value} ").bytes()))),
    ];
    for (index, (extension, bytes)) in files.iter().enumerate() {
        let path = folder.path().join(format!("frame{index}.{extension}"));
        std::fs::write(&path, bytes).expect("written");
        let modes = [IoMode::Map, IoMode::Read].map(|mode| open(&path, mode));
        let info = modes[1].frame_info(0, false).expect("opens");
        let attributes = info.attributes.iter().map(|a| a.name.clone()).collect();
        let request = FrameRequest { attributes };
        let whole = modes[0].read(0, &request, &Cancel::default()).expect("whole");
        let stop = Cancel::default();
        std::thread::scope(|scope| {
            let _stop = StopAtEnd(&stop);
            scope.spawn(|| {
                while !stop.is_cancelled() {
                    let mut file = File::create(&path).expect("emptied");
                    file.write_all(bytes).expect("written");
                }
            });
            for series in modes.iter().cycle().take(100) {
                if let Ok(frame) = series.read(0, &request, &Cancel::default()) {
                    assert!(frame.sets == whole.sets, "file {index}: a frame with bytes of an emptied file");
                }
            }
        });
    }
}

#[test]
fn a_file_that_is_replaced_or_grows_reads_as_it_is_then() {
    let folder = tempfile::tempdir().expect("a folder");
    for mode in [IoMode::Map, IoMode::Read] {
        let path = put(folder.path());
        let series = open(&path, mode);
        let read = || series.read(0, &FrameRequest::default(), &Cancel::default()).expect("reads");
        assert_eq!(read().len(), 20_000);
        let other = folder.path().join("other");
        std::fs::write(&other, Xml::plain(Format::Ascii).bytes()).expect("written");
        std::fs::rename(&other, &path).expect("renamed");
        assert_eq!(read().len(), 10, "{mode:?}");
        OpenOptions::new().append(true).open(&path).and_then(|mut f| f.write_all(b"\n\n\n")).expect("grows");
        assert_eq!(read().len(), 10, "{mode:?}");
    }
}

#[test]
fn fresh_files_are_read_and_files_at_rest_are_mapped() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = put(folder.path());
    let said = |path: &Path| {
        let series = open(path, IoMode::Auto);
        series.choices().iter().find(|choice| choice.what == "files").map(|choice| choice.value.clone())
    };
    assert_eq!(said(&path).as_deref(), Some("read in blocks"));
    let long_ago = std::time::SystemTime::now() - std::time::Duration::from_secs(3600);
    File::options().write(true).open(&path).and_then(|f| f.set_modified(long_ago)).expect("aged");
    assert_eq!(said(&path).as_deref(), Some("mapped"));
}
